"""What mapping costs in buildings of different kinds: CPU time by stage, the time a keyframe and a solve take, memory over time.

Each world is mapped by a process of its own, one after another, and its memory is read while it runs. With the command line of another odometry, that one
and this package's work on the same recording in turns, and their CPU times are compared."""
import json
import os
import resource
import shlex
import statistics
import subprocess
import sys
import time

WORLDS = {'se1': 'six rooms', 'cluttered_office': 'an office with everything in it', 'car_park': 'a car park', 'warehouse': 'a warehouse', 'standstill': 'ten minutes of standing',
          'long_walk': 'two hours in an office of 500 m²'}
SHORT = 60  # s of each world with --quick
TURNS = 3  # how often two programs are run in turns
PERIOD = 1.0  # s between two readings of the memory


def resident_mib(pid):
    """Memory that a process holds now [MiB]; None once it has ended."""
    try:
        with open(f'/proc/{pid}/status') as file:
            for line in file:
                if line.startswith('VmRSS:'):
                    return int(line.split()[1]) / 1024
    except OSError:
        pass
    return None


def run_and_watch(command, log):
    """Runs a command to its end. Returns its CPU seconds and (share of its time, MiB) pairs."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    memory = []
    with open(log, 'w') as file:
        child = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
        while child.poll() is None:
            mib = resident_mib(child.pid)
            if mib is not None:
                memory.append((time.monotonic() - begin, mib))
            time.sleep(PERIOD)
    if child.returncode != 0:
        raise RuntimeError(f'{shlex.join(command)}: exit status {child.returncode}; see {log}')
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = max(time.monotonic() - begin, 1e-9)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, [(at / whole, mib) for at, mib in memory]


def map_world(world, options, folder):
    """The report of a world mapped anew, with `memory`: how it went on."""
    out = os.path.join(folder, world)
    os.makedirs(out, exist_ok=True)
    command = [os.path.join(options.programs, 'run_world'), os.path.join(options.root, 'worlds', world + '.yaml'), '--out', out, '--threads', '1']
    command += ['--duration', str(SHORT)] if options.quick else []
    for assignment in options.set:
        command += ['--set', assignment]
    _, memory = run_and_watch(command, os.path.join(folder, world + '.log'))
    with open(os.path.join(out, 'report.json')) as file:
        report = json.load(file)
    report['memory'] = memory
    return report


def compare(command_line, options, folder):
    """CPU seconds of run_bag and of another program on one recording, run in turns; `{bag}` in the command line is the recording."""
    data = os.path.join(folder, 'recording')
    bag = os.path.join(data, 'data.bag')
    if not os.path.exists(bag):
        simulate = [os.path.join(options.programs, 'simulate'), os.path.join(options.root, 'worlds', 'se1.yaml'), data, '--quiet']
        subprocess.run(simulate + (['--duration', str(SHORT)] if options.quick else []), check=True)
    ours = [os.path.join(options.programs, 'run_bag'), bag, '--out', os.path.join(folder, 'recording_map'), '--threads', '1', '--quiet']
    theirs = [part.replace('{bag}', bag) for part in shlex.split(command_line)]
    times = {'ours': [], 'theirs': []}
    for turn in range(TURNS):
        for name, command in (('ours', ours), ('theirs', theirs)):
            times[name].append(run_and_watch(command, os.path.join(folder, f'{name}_{turn}.log'))[0])
    return {name: statistics.median(values) for name, values in times.items()}


def row(world, report):
    """A line of the table."""
    seconds = report['data_seconds']
    stages = report['stages_cpu_ms']
    shares = [f"{stages[name]['mean'] * stages[name]['runs'] / seconds:.1f}" for name in ('prefilter', 'odometry', 'segmentation', 'mapping')]
    mapping = stages['mapping']
    solves = report['solves'] or [{'ms': 0, 'factors': 0}]
    largest = max(solves, key=lambda s: s['factors'])
    return [WORLDS[world], f'{seconds:.0f}', str(report['counts']['keyframes']), str(report['counts']['planes']), str(largest['factors'])] + shares + [
        f"{mapping['mean']:.1f} / {mapping['p99']:.0f}", f"{solves[-1]['ms']:.0f}", f"{max(s['ms'] for s in solves):.0f}", f"{report['peak_memory_mib']:.0f}"]


HEAD = ['building', 's', 'keyframes', 'planes', 'factors', 'prefilter', 'odometry', 'segmentation', 'mapping', 'a keyframe, mean / p99', 'last solve', 'longest', 'memory']


def plot(reports, path):
    """Memory of the processes over their time."""
    import matplotlib
    matplotlib.use('Agg')
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(8, 4.5))
    for world, report in reports.items():
        axes.plot([100 * share for share, _ in report['memory']], [mib for _, mib in report['memory']], label=WORLDS[world])
    axes.set_xlabel('share of the run [%]')
    axes.set_ylabel('memory, simulator included [MiB]')
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def document(options):
    """Maps the worlds and returns the lines of the section `cost`."""
    folder = os.path.join(options.folder, 'cost')
    os.makedirs(folder, exist_ok=True)
    reports = {}
    for world in options.worlds or WORLDS:
        print(f'cost: {world}', file=sys.stderr, flush=True)
        reports[world] = map_world(world, options, folder)
    table = ['| ' + ' | '.join(cells) + ' |' for cells in [HEAD, ['---'] * len(HEAD), *(row(w, r) for w, r in reports.items())]]
    picture = os.path.join(folder if options.partial else os.path.join(options.root, 'docs', 'images'), 'memory.png')
    os.makedirs(os.path.dirname(picture), exist_ok=True)
    plot(reports, picture)
    text = ['## Cost\n',
            'One thread. CPU time of each stage [ms a second of data]; CPU time of mapping a keyframe [ms]; the last solve of the whole graph and the longest [ms on the clock]; peak memory [MiB], the '
            "simulator's own included. `factors`: of the largest solve.\n", *table, '',
            f'![Memory over the run of each building]({os.path.relpath(picture, os.path.dirname(options.results))})\n']
    if options.against:
        times = compare(options.against, options, folder)
        text.append(f'On one recording of six rooms, run in turns {TURNS} times each: {times["ours"]:.1f} CPU s of `run_bag`, {times["theirs"]:.1f} of `{options.against}`, ratio '
                    f'{times["ours"] / times["theirs"]:.2f}.\n')
    return text
