"""The parts of docs/results.md, each a function that makes its text from the runs."""
from . import figures as f
from . import published
from .experiments import FURTHER_WORLDS, HOLDOUTS, MAPS, MECHANISMS, ODOMETRIES, ODOMETRY, PAPER_WORLDS, PLANES, PLANS, ROBUSTNESS, SEEDS, TOPOLOGY, TWINS

PICTURES = {'cf1': 'images/cf1.png', 'se2': 'images/se2.png'}  # world: file beside the page
ROBOT_WORLDS = PAPER_WORLDS + ['oblique', 'two_wings', 'people']


def text_of(part, results):
    """The lines of a part; the first is its heading."""
    experiment, function = SECTIONS[part]
    if results.worlds(experiment):
        return function(results)
    return [f'## {part.capitalize()}\n', f'No runs yet: `bench/reproduce --tables {part}`.\n']


def table(head, rows):
    """Rows of text as Markdown."""
    lines = ['| ' + ' | '.join(head) + ' |', '|---' * len(head) + '|']
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n'


def title(world):
    return world[:-1].upper() + '-' + world[-1] if world in PAPER_WORLDS else world.replace('_', ' ')


class Results:
    """What the runs gave."""

    def __init__(self, runner):
        self.runner = runner
        self.read = {}

    def of(self, experiment, world, name, simulation=None):
        simulation = simulation or next(iter(experiment.simulations_of(world)))
        key = (experiment.name, world, name, simulation)
        if key not in self.read:
            variant = next(v for v in experiment.variants if v.name == name)
            self.read[key] = self.runner.result(experiment, world, variant, simulation)
        return self.read[key]

    def cell(self, experiment, world, name, figure, simulation=None):
        """A figure of a run, a dash when there is none."""
        result = self.of(experiment, world, name, simulation)
        try:
            return figure(*result[:2]) if result else '-'
        except (KeyError, TypeError):
            return '-'

    def worlds(self, experiment):
        """Those of which there are runs."""
        return [w for w in experiment.worlds if any(self.of(experiment, w, v.name, s) for v in experiment.variants_on(w) for s in experiment.simulations_of(w))]

    def commits(self):
        """Of the runs that were read."""
        return sorted({result[2] for result in self.read.values() if result})

    def row(self, label, name, worlds, figure, bold=False):
        """A figure of one variant of the maps in several worlds; nothing when none has it."""
        cells = [self.cell(MAPS, w, name, figure) for w in worlds]
        mark = '**' if bold else ''
        return [[mark + label + mark] + [mark + c + mark if c != '-' else c for c in cells]] if any(c != '-' for c in cells) else []


def published_rows(figures, worlds):
    return [[method] + [row.get(w, '-') for w in worlds] for method, row in figures.items()]


def our_rows(results, worlds, figure, odometry=True, encoders=True):
    rows = results.row('this package, LiDAR odometry alone', 'odometry', worlds, figure) if odometry else []
    rows += results.row('this package without topological layer, LiDAR only', 'no_layer', worlds, figure)
    rows += results.row('this package, LiDAR only', 'full', worlds, figure, bold=True)
    if encoders:
        rows += results.row('encoder odometry alone', 'encoders_odometry', worlds, figure) if odometry else []
        rows += results.row('this package without topological layer, encoder odometry', 'encoders_no_layer', worlds, figure)
        rows += results.row('this package, encoder odometry', 'encoders', worlds, figure, bold=True)
    return rows


def paper(results):
    text = ["## The paper's experiments\n",
            'The worlds (`worlds/`, [worlds.md](worlds.md)) are buildings of the kinds that the paper describes, rebuilt from its text and not from its data: the published figures (Bavle et al., RA-L 2022) tell the order of '
            'magnitude; it is no race on the same track. One set of parameters, the defaults, for every world. "LiDAR only" is the odometry of this package; "encoder odometry" is the simulated robot\'s own, 1.2 % wrong in scale, '
            'drifting in heading, and without roll and pitch.\n']
    worlds = ['cf1', 'cf2', 'se1', 'se2']
    text += ['### Absolute trajectory error [m]\n', 'SE(3)-aligned, no scale, rmse. Published: the same kinds of building in Gazebo, LiDAR-only odometry.\n',
             table(['method'] + [title(w) for w in worlds], published_rows(published.ATE, worlds) + our_rows(results, worlds, f.ate, encoders=False))]
    worlds = ['cf1', 'cf2', 'lc1']
    text += ['### Map against the building, rmse [m]\n',
             'Points within 0.5 m of a true wall, column, floor or ceiling, after the alignment of the trajectory; points on furniture are left out. With the true motion and 2 cm of range noise it is 0.015 m. '
             "Published: recorded data against the architect's plan, the robot's encoder odometry.\n",
             table(['method'] + [title(w) for w in worlds], published_rows(published.MAP, worlds) + our_rows(results, worlds, f.map_rmse, odometry=False))]
    worlds = ['le1', 'le2']
    text += ['### Error between the first and the last pose, [m] / [deg]\n', 'Published: recorded data, encoder odometry.\n',
             table(['method'] + [title(w) for w in worlds], published_rows(published.END, worlds) + our_rows(results, worlds, f.start_to_end))]
    worlds = ['cf1', 'cf2', 'lc1', 'le1', 'le2']
    rows = [['length of the sequence, published'] + [f'{published.LENGTH[w]} s' for w in worlds]]
    rows += results.row('length of the sequence, here', 'full', worlds, f.length) + published_rows(published.TIME, worlds)
    rows += results.row('this package, LiDAR only', 'full', worlds, f.solve_time, bold=True) + results.row('this package, encoder odometry', 'encoders', worlds, f.solve_time)
    rows += results.row('this package, LiDAR only, the whole mapping stage a keyframe', 'full', worlds, f.mapping_time)
    text += ['### Computation time of the map optimisation, mean / std [ms]\n',
             'Published: 16 cores. Here: one thread, a figure a solve of the graph; the last row is CPU time with association, rooms, loops and solve.\n', table(['method'] + [title(w) for w in worlds], rows)]
    return text


def worlds(results):
    every = PAPER_WORLDS + FURTHER_WORLDS

    def rows(columns, among=every):
        lines = [[title(w)] + [results.cell(MAPS, w, name, figure) for name, figure in columns] for w in among]
        return [line for line in lines if any(c != '-' for c in line[1:])]

    def speed_of_simulator(world):
        made = results.runner.simulation(MAPS, world)
        return f"{made['cpu_seconds'] / made['data_seconds']:.3f}" if made else '-'

    cost = rows([('odometry', f.stage_cpu('prefilter', 'odometry')), ('odometry', f.scan_p99), ('full', f.stage_cpu('segmentation', per_second=True)),
                 ('full', f.stage_cpu('mapping', per_second=True)), ('full', f.speed), ('full', f.memory)])
    names = {title(w): w for w in every}
    return ['## Every world\n', *(f'![{title(w)}: map from above, true walls, path coloured by its error; rooms and corridors]({link})\n' for w, link in PICTURES.items() if results.of(MAPS, w, 'full')),
            '### Trajectory, LiDAR only\n',
            'ATE [m] of the final poses by what is switched on, of the live poses (known when each scan had been processed), and drift of the odometry over 10 m segments [%] / [deg/m].\n',
            table(['world', 'length', 'odometry alone', 'its live poses', 'without topological layer', 'whole', 'whole, live', 'drift', 'drift, live', 'map to plan [m]'],
                  rows([('full', f.length), ('odometry', f.ate), ('odometry', f.live_ate), ('no_layer', f.ate), ('full', f.ate), ('full', f.live_ate),
                        ('odometry', f.drift), ('odometry', f.live_drift), ('full', f.map_rmse)])),
            '### Trajectory, encoder odometry\n', 'The same with the simulated robot\'s encoders in place of the LiDAR odometry. ATE [m].\n',
            table(['world', 'encoders alone', 'without topological layer', 'whole', 'rooms', 'corridors', 'map to plan [m]'],
                  rows([('encoders_odometry', f.ate), ('encoders_no_layer', f.ate), ('encoders', f.ate), ('encoders', f.places('rooms')), ('encoders', f.places('corridors')),
                        ('encoders', f.map_rmse)], ROBOT_WORLDS)),
            '### Rooms, corridors and walls, LiDAR only\n',
            'Found of true ones (with what was found where none is), mean error of centre / width [mm] (corridors: across); faces of walls of which more than 2 m were in view within 6 m, '
            'share of duplicates, median error of normal [deg] / position [mm].\n',
            table(['world', 'rooms', 'errors', 'corridors', 'errors', 'walls', 'duplicates', 'errors'],
                  rows([('full', f.places('rooms')), ('full', f.place_errors('rooms')), ('full', f.places('corridors')), ('full', f.place_errors('corridors')),
                        ('full', f.walls_found), ('full', f.wall_duplicates), ('full', f.wall_errors)])),
            '### Cost\n',
            'One thread. CPU time [ms] of prefilter and odometry a scan (ten scans a second), 99th percentile of the odometry on the clock, CPU time of segmentation and mapping a second of data, CPU seconds of everything a second of '
            'data, peak memory [MiB] (of one process that maps the world in all six ways of the tables above at once), and CPU seconds of the simulator a second of data.\n',
            table(['world', 'prefilter and odometry a scan', 'p99', 'segmentation a second', 'mapping a second', 'all, s/s', 'memory of six', 'simulator, s/s'],
                  [line + [speed_of_simulator(names[line[0]])] for line in cost])]


def twins(results):
    rows = []
    for world in TWINS.worlds:
        cells = [' / '.join(results.cell(e, world, name, f.ate) for e in (MAPS, TWINS)) for name in ('odometry', 'no_layer', 'full')]
        cells += [results.cell(TWINS, world, 'full', figure) for figure in (f.quality, f.places_found, f.map_rmse, f.ghosts)]
        if any(c != '-' for c in cells[3:]) or results.of(TWINS, world, 'odometry'):
            rows.append([title(world), *cells])
    return ['## Real sensor, real building\n',
            'The same worlds with the errors of a real VLP-16, a unit a world, and of real buildings ([simulator.md](simulator.md)). ATE of the final poses [m], ideal / real; of the real one also the panoptic quality of the places, how many were found, '
            'map to plan [m], and the share of map points more than 10 cm off every surface / the distance that 95 % of the points keep [m].\n',
            table(['world', 'odometry alone', 'without topological layer', 'whole', 'quality of places', 'found', 'map to plan', 'ghosts / 95 %'], rows)]


def places_of(experiment, heading, words):
    def text(results):
        parts = [f'## {heading}\n', words + ' Panoptic quality, places found (with those that are none), overlap of true / found places, doors: recall / precision / error of the width (rms), ATE [m] whole / odometry alone.\n']
        for simulation, label in (('ideal', 'Ideal sensor, building as planned'), ('real', 'Real sensor, real building')):
            rows = []
            for world in experiment.worlds:
                cells = [results.cell(experiment, world, 'full', figure, simulation) for figure in (f.quality, f.places_found, f.overlaps, f.doors)]
                cells.append(' / '.join(results.cell(experiment, world, name, f.ate, simulation) for name in ('full', 'odometry')))
                if results.of(experiment, world, 'full', simulation):
                    rows.append([title(world), *cells])
            if rows:
                parts += [f'### {label}\n', table(['plan', 'quality', 'places', 'overlaps', 'doors', 'ATE'], rows)]
        return parts
    return text


plans = places_of(PLANS, 'Places of any outline', 'Six buildings that were looked at while the detection of places was built (`worlds/plan_*.yaml`).')
holdouts = places_of(HOLDOUTS, 'Places in buildings kept aside', 'Six buildings that were not looked at while the detection of places was built (`worlds/holdout_*.yaml`).')


def begun(experiment, world):
    return title(world) + (', first lap' if world == 'le1' and world in experiment.duration else '')


def odometry(results):
    e, among = ODOMETRY, results.worlds(ODOMETRY)
    rows = []
    for variant in e.variants:
        rows.append([variant.label] + [results.cell(e, w, variant.name, figure) for w in among for figure in (f.ate_and_live_mm, f.drift)] +
                    [results.cell(e, among[0], variant.name, f.stage_cpu('prefilter', 'odometry'))])
    head = ['LiDAR odometry alone'] + [text for w in among for text in (f'{begun(e, w)}: ATE (live) [mm]', 'drift')] + ['CPU a scan [ms]']
    return ['## Ablation: odometry\n',
            'Each row changes one thing. ATE of the final (live) poses, drift over 10 m segments [%] / [deg/m], CPU time of prefilter and odometry a scan on ' + title(among[0]) + '. No graph, no loops.\n', table(head, rows),
            "\nTwo rows lose SE-1, and for one reason: where a scan's motion is one piece that begins where the last one ended, its points tell its middle, so an error of the beginning comes back in the "
            'end with the other sign, and grows where the first half of the sweep sees more. In a turn at 52 deg/s the yaw of successive scans is wrong by -0.3, 0.5, -0.8, 1.3, -2.6 and 5.2 deg. Two pieces a '
            'scan, solved with those of the scan before, leave no way to do so.']


def robustness(results):
    def run(world, simulation=None):
        return results.of(ROBUSTNESS, world, 'default', simulation)

    def error(found, trajectory='trajectory'):
        return found[0][trajectory]['ate_translation_m']['rmse']

    def lost(found):
        return sum(n for status, n in found[1]['odometry_status'].items() if status == 'predicted')

    rows = []
    for world in ('se1', 'fast_walker'):
        found = [r for r in (run(world, s) for s in SEEDS) if r]
        if not found:
            continue
        finals, lives = (sorted(error(r, t) for r in found) for t in ('trajectory', 'trajectory_live'))
        rows.append([title(world), str(len(found))] + [f.millimetres(v) for e in (finals, lives) for v in (e[0], e[len(e) // 2], e[-1])] + [str(sum(lost(r) for r in found))])
    text = ['## Robustness of the odometry\n', 'LiDAR odometry alone, as shipped.\n', 'Seeds of the sensor\'s noise. ATE [mm] over the runs; scans that the map did not explain, in all of them.\n',
            table(['world', 'seeds', 'least', 'median', 'worst', 'live: least', 'median', 'worst', 'not explained'], rows)]
    labels = {'seed_1': '2 cm of range noise, 10 Hz, stamped at the last firing', 'first': 'stamped at the first firing', 'noise_1': '1 cm', 'noise_3': '3 cm', 'noise_4': '4 cm of range noise',
              'rate_5': '5 Hz', 'rate_20': '20 Hz'}
    rows = [[label, f.ate_and_live_mm(*r[:2]), f.drift(*r[:2]), str(lost(r))] for label, r in ((label, run('se1', s)) for s, label in labels.items()) if r]
    text += [f'{title("se1")}, other sensors. ATE of the final (live) poses [mm], drift over 10 m [%] / [deg/m].\n', table(['sensor', 'ATE (live)', 'drift', 'not explained'], rows)]
    if still := run('standstill'):
        way, angle = f.standing_drift(results.runner.trajectory(ROBUSTNESS, 'standstill', 'default'))
        text.append(f'Ten minutes of standing still (`worlds/standstill.yaml`): {f.millimetres(way)} mm and {angle:.3f} deg from the mean pose of the first ten seconds to that of the last; single poses scatter by '
                    f'{f.millimetres(error(still))} mm rms.\n')
    return text


def planes(results):
    e = PLANES
    text = ['## Ablation: what a keyframe\'s cloud is, and how an observed plane enters the graph\n',
            'Without topological layer. A keyframe\'s cloud is one deskewed scan, or all scans since the keyframe before, put together with the odometry (`odometry.keyframe.cloud`); an observed plane enters as the fitted plane or as its points '
            '(`mapping.factors.plane_factor`). ATE [mm]; walls found, their duplicates, median error of normal [deg] / position [mm]; map to plan [mm]; CPU time of segmentation / mapping [ms a second of data].\n']
    for world in results.worlds(e):
        columns = [f.ate_mm, f.walls_found, f.wall_duplicates, f.wall_errors, f.map_rmse_mm, f.stage_cpu('segmentation', per_second=True), f.stage_cpu('mapping', per_second=True)]
        rows = [[v.label] + [results.cell(e, world, v.name, c) for c in columns] for v in e.variants]
        text.append(table([title(world), 'ATE', 'walls', 'duplicates', 'errors', 'map to plan', 'segmentation', 'mapping'], rows))
    return text


def total_places(results, experiment, among, name):
    found = true = wrong = 0
    for world in among:
        result = results.of(experiment, world, name)
        if not result or 'rooms' not in result[0]:
            return '-'
        for kind in ('rooms', 'corridors'):
            score = result[0][kind]
            found, true, wrong = found + len(score['matches']), true + score['true'], wrong + len(score['false_alarms'])
    return f'{found} / {true}' + (f', {wrong} wrong' if wrong else '')


def mean_ate(results, experiment, among, name):
    found = [results.of(experiment, w, name) for w in among]
    errors = [run[0]['trajectory']['ate_translation_m']['rmse'] for run in found if run]
    return sum(errors) / len(errors) if len(errors) == len(among) else None


def verdict(results, experiment, among, source):
    """Which mechanisms show in the ATE, in words: better and worse mean by more than 0.2 mm and 5 %, over all worlds of the table."""
    whole = mean_ate(results, experiment, among, f'{source}_whole')
    groups = {'ATE worse than as shipped': [], 'ATE better': [], 'no difference in the ATE': []}
    for name, mechanism, _ in MECHANISMS[1:]:
        error = mean_ate(results, experiment, among, f'{source}_{name}')
        if whole is None or error is None:
            continue
        limit = max(0.0002, 0.05 * whole)
        group = 'ATE worse than as shipped' if error > whole + limit else 'ATE better' if error < whole - limit else 'no difference in the ATE'
        groups[group].append(mechanism.split(':')[0])
    return '; '.join(f'{group}: {", ".join(names)}' for group, names in groups.items() if names) + '.\n' if whole is not None else ''


def topology(results):
    e, among = TOPOLOGY, results.worlds(TOPOLOGY)
    text = ['## Ablation: topological layer and what belongs to it\n',
            'Each row switches one mechanism. With a good odometry the layer has little to mend, so it is shown with worse ones too. ATE [mm] / map to plan [mm]; rooms and corridors found in all of these worlds.\n']
    for source, label, _ in ODOMETRIES:
        rows = []
        for name, mechanism, _ in MECHANISMS:
            cells = [' / '.join(results.cell(e, w, f'{source}_{name}', c) for c in (f.ate_mm, f.map_rmse_mm)) for w in among]
            rows.append([mechanism] + ['-' if c == '- / -' else c for c in cells] + [total_places(results, e, among, f'{source}_{name}')])
        text += [f'### With {label}\n', table(['mechanism'] + [title(w) for w in among] + ['rooms and corridors'], rows), 'Over these worlds, ' + verdict(results, e, among, source) if among else '']
    return text


# Name of the part, the experiment that it tells of, the function.
SECTIONS = {'paper': (MAPS, paper), 'worlds': (MAPS, worlds), 'twins': (TWINS, twins), 'plans': (PLANS, plans), 'holdouts': (HOLDOUTS, holdouts), 'odometry': (ODOMETRY, odometry), 'robustness': (ROBUSTNESS, robustness), 'planes': (PLANES, planes), 'topology': (TOPOLOGY, topology)}
GROUPS = {'all': list(SECTIONS), 'maps': ['paper', 'worlds'], 'real': ['twins'], 'places': ['plans', 'holdouts'], 'ablation': ['odometry', 'robustness', 'planes', 'topology']}
