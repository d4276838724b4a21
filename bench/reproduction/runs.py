"""Runs experiments: a process a world, as many at once as there are cores; keeps what is finished."""
import concurrent.futures
import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time

import yaml

from .experiments import world_file

# Rough CPU seconds a second of data: the simulator, a different front end (and its planes), a back end. They only order the work and tell the time left.
SIMULATOR, FRONT_END, BACK_END = 0.08, 0.09, 0.04
USUAL_LENGTH = 330  # s


def read_json(path):
    with open(path) as file:
        return json.load(file)


class Job:
    """One world of one experiment, simulated in one way: one process for all variants that have to be run."""

    def __init__(self, experiment, world, simulation, folder, root):
        self.experiment, self.world, self.simulation = experiment, world, simulation
        self.options = experiment.simulations_of(world)[simulation]
        self.folder = os.path.join(folder, experiment.name, world, simulation) if simulation else os.path.join(folder, experiment.name, world)
        self.duration = experiment.duration.get(world)
        self.variants = []
        self.share = 0.0  # done
        with open(world_file(root, world)) as file:
            self.length = self.duration or (yaml.safe_load(file).get('route') or {}).get('duration') or USUAL_LENGTH

    @property
    def name(self):
        return f'{self.experiment.name}/{self.world}' + (f'/{self.simulation}' if self.simulation else '')

    @property
    def cost(self):
        fronts = {str(sorted((k, str(v)) for k, v in variant.settings.items() if k.startswith(('odometry.', 'prefilter.')))) for variant in self.variants}
        backs = sum(v.maps for v in self.variants)
        return self.length * (SIMULATOR + FRONT_END * len(fronts) + BACK_END * backs)


class Progress:
    """A line that tells how far all jobs are."""

    def __init__(self, jobs):
        self.jobs = jobs
        self.begin = time.monotonic()
        self.lock = threading.Lock()
        self.terminal = sys.stderr.isatty()
        self.printed = -1

    def show(self, note=None):
        with self.lock:
            total = sum(j.cost for j in self.jobs)
            share = sum(j.cost * j.share for j in self.jobs) / total if total else 1.0
            spent = time.monotonic() - self.begin
            left = f'{spent * (1 - share) / share / 60:.0f} min left' if share > 0.02 else 'time left not yet known'
            running = ', '.join(f'{j.name} {100 * j.share:.0f} %' for j in self.jobs if 0 < j.share < 1)
            clear = '\r\x1b[K' if self.terminal else ''
            if note:
                print(f'{clear}{note}', file=sys.stderr)
            if self.terminal:
                print(f'{clear}{100 * share:3.0f} %  {left}  {running}'[:160], end='', file=sys.stderr, flush=True)
            elif int(20 * share) > self.printed or note:
                self.printed = int(20 * share)
                print(f'{100 * share:3.0f} %, {left}', file=sys.stderr, flush=True)

    def end(self):
        if self.terminal:
            print(file=sys.stderr)


class Runner:
    """Runs jobs and remembers what failed."""

    def __init__(self, root, programs, folder, assignments, processes, commit):
        self.root, self.programs, self.folder, self.commit = root, programs, folder, commit
        self.assignments, self.processes = assignments, processes
        self.failures = []
        self.children = set()
        self.lock = None
        self.stopping = False
        self.known = self.parameters()
        self.program_digest = self.digest_of([self.program('run_world'), self.program('evaluate')])

    def program(self, name):
        path = os.path.join(self.programs, name)
        if not os.access(path, os.X_OK):
            sys.exit(f'bench/reproduce: {path} is missing: build first (scripts/build)')
        return path

    def parameters(self):
        """Full names of all parameters that the programs know."""
        def names(tree, prefix=''):
            for key, value in tree.items():
                yield from names(value, f'{prefix}{key}.') if isinstance(value, dict) else [prefix + key]
        text = subprocess.run([self.program('parameters'), 'yaml'], capture_output=True, text=True, check=True).stdout
        return {*names(yaml.safe_load(text)), 'until', 'imu', 'encoders'}

    def is_possible(self, experiment, variant):
        """False when it sets a parameter that is gone, so that it doesn't spoil the others of its world."""
        unknown = [name for name in variant.settings if name not in self.known]
        failure = f'{experiment.name}, {variant.name}: there is no parameter {", ".join(unknown)}'
        if unknown and failure not in self.failures:
            self.failures.append(failure)
        return not unknown

    @staticmethod
    def digest_of(paths):
        digest = hashlib.sha256()
        for path in paths:
            with open(path, 'rb') as file:
                digest.update(file.read())
        return digest.hexdigest()

    def key(self, job, variant):
        """Changes when the outcome may: programs, world, parameters."""
        world = self.digest_of([world_file(self.root, job.world)])
        return '\n'.join([self.program_digest, world, str(job.duration), *job.options, variant.argument, *self.assignments])

    def is_done(self, job, variant):
        path = os.path.join(job.folder, variant.name, 'key')
        if not os.path.exists(path):
            return False
        with open(path) as file:
            return file.read() == self.key(job, variant)

    def jobs_for(self, experiments):
        """What is left to do, the long ones first: they would leave a core idle at the end."""
        jobs = []
        for experiment in experiments:
            for world in experiment.worlds:
                if not os.path.exists(world_file(self.root, world)):
                    self.failures.append(f'{world}: there is no worlds/{world}.yaml')
                    continue
                for simulation in experiment.simulations_of(world):
                    job = Job(experiment, world, simulation, self.folder, self.root)
                    job.variants = [v for v in experiment.variants_on(world) if not self.is_done(job, v) and self.is_possible(experiment, v)]
                    if job.variants:
                        jobs.append(job)
        return sorted(jobs, key=lambda j: -j.cost)

    def lock_folder(self):
        """Two at once would write into each other's runs."""
        os.makedirs(self.folder, exist_ok=True)
        self.lock = open(os.path.join(self.folder, 'lock'), 'w')
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sys.exit(f'bench/reproduce: another one is running in {self.folder}')

    def run(self, jobs):
        self.lock_folder()
        progress = Progress(jobs)
        with concurrent.futures.ThreadPoolExecutor(self.processes) as pool:
            try:
                for done in concurrent.futures.as_completed([pool.submit(self.run_job, job, progress) for job in jobs]):
                    done.result()
            except KeyboardInterrupt:
                self.stopping = True
                for child in list(self.children):
                    child.terminate()
                progress.end()
                print('bench/reproduce: interrupted; what is finished is kept, run it again to go on', file=sys.stderr)
                sys.exit(130)
        progress.end()

    def run_job(self, job, progress):
        if self.stopping:
            return
        begin = time.monotonic()
        outcome = f'{len(job.variants)} runs'
        try:
            self.map_world(job, progress)
            for variant in job.variants:
                self.evaluate(job, variant)
        except (OSError, RuntimeError) as error:
            if self.stopping:
                return
            self.failures.append(f'{job.name}: {error}')
            outcome = 'FAILED'
        job.share = 1.0
        progress.show(f'{job.name}: {outcome} in {(time.monotonic() - begin) / 60:.1f} min')

    def map_world(self, job, progress):
        os.makedirs(job.folder, exist_ok=True)
        fresh = self.fresh(job)
        shutil.rmtree(fresh, ignore_errors=True)
        command = [self.program('run_world'), world_file(self.root, job.world), '--out', fresh, '--threads', '1']
        command += ['--duration', str(job.duration)] if job.duration else []
        command += job.options
        for assignment in self.assignments:
            command += ['--set', assignment]
        for variant in job.variants:
            command += ['--variant', variant.argument]

        def follow(line):
            if match := re.match(r'\s*(\d+) %', line):
                job.share = 0.97 * int(match.group(1)) / 100
                progress.show()
        self.call(job, command, follow, 'w')
        for name in ('ground_truth.tum', 'truth.json', 'simulation.json'):
            os.replace(os.path.join(fresh, name), os.path.join(job.folder, name))
        for variant in job.variants:
            run = os.path.join(job.folder, variant.name)
            shutil.rmtree(run, ignore_errors=True)
            os.replace(os.path.join(fresh, variant.name), run)
        os.rmdir(fresh)

    @staticmethod
    def fresh(job):
        """Where a world is mapped; what was there before stays until that has ended well."""
        return os.path.join(job.folder, '.fresh')

    def evaluate(self, job, variant):
        run = os.path.join(job.folder, variant.name)
        picture = [] if job.experiment.name == 'maps' and variant.maps else ['--no-picture']
        self.call(job, [self.program('evaluate'), run, '--truth', job.folder, *picture], lambda line: None, 'a')
        with open(os.path.join(run, 'commit'), 'w') as file:
            file.write(self.commit)
        with open(os.path.join(run, 'key'), 'w') as file:
            file.write(self.key(job, variant))

    def call(self, job, command, follow, mode):
        """Runs a program; what it says goes to the job's log."""
        path = os.path.join(job.folder, 'log.txt')
        with open(path, mode) as log:
            print('$', *command, file=log, flush=True)
            child = subprocess.Popen(command, stdout=log, stderr=subprocess.PIPE, text=True)
            self.children.add(child)
            last = ''
            for line in child.stderr:
                log.write(line)
                last = line.strip() or last
                follow(line)
            child.stderr.close()
            self.children.discard(child)
            if child.wait() != 0:
                raise RuntimeError(f'{last or "no message"} (exit status {child.returncode}; see {path})')

    def result(self, experiment, world, variant, simulation):
        """(evaluation, report, commit) of a run that is up to date, or None."""
        job = Job(experiment, world, simulation, self.folder, self.root) if os.path.exists(world_file(self.root, world)) else None
        if job is None or not self.is_done(job, variant):
            return None
        run = os.path.join(job.folder, variant.name)
        with open(os.path.join(run, 'commit')) as file:
            commit = file.read()
        return read_json(os.path.join(run, 'evaluation.json')), read_json(os.path.join(run, 'report.json')), commit

    def picture(self, experiment, world, name):
        return os.path.join(self.folder, experiment.name, world, name, 'evaluation.png')

    def trajectory(self, experiment, world, name):
        return os.path.join(self.folder, experiment.name, world, name, 'trajectory.tum')

    def simulation(self, experiment, world):
        path = os.path.join(self.folder, experiment.name, world, 'simulation.json')
        return read_json(path) if os.path.exists(path) else None
