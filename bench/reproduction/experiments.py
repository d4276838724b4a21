"""What is run: each experiment maps worlds in several ways (variants), all of them over the same simulated scans."""
import os

PAPER_WORLDS = ['cf1', 'cf2', 'se1', 'se2', 'lc1', 'le1', 'le2']
FURTHER_WORLDS = ['oblique', 'two_wings', 'people', 'fast_walker']
QUICK_WORLDS = ['se1', 'lc1']

NO_LAYER = {'mapping.topological_layer': 'false'}
ENCODERS = {'odometry.source': 'topic'}
MOTION_ONLY = {'until': 'odometry'}
# The motion within a scan taken from the scan before, not solved: what most LiDAR odometries do.
LAST_VELOCITY = {'odometry.motion.model': 'velocity'}


class Variant:
    """One way of mapping: parameters over the defaults, and the row that tells of it."""

    def __init__(self, name, label, *settings):
        self.name, self.label = name, label
        self.settings = {key: value for part in settings for key, value in part.items()}

    @property
    def argument(self):
        return self.name + (':' if self.settings else '') + ','.join(f'{k}={v}' for k, v in self.settings.items())

    @property
    def maps(self):
        return self.settings.get('until') != 'odometry'


class Experiment:
    """Worlds and the variants run on each. `duration`: worlds of which only the beginning is used [s]. `simulations`: for a world, the ways in which it
    is simulated, each with the options of run_world that it takes."""

    def __init__(self, name, worlds, variants, duration=None, simulations=None):
        self.name, self.worlds, self.variants, self.duration, self.simulations = name, worlds, variants, duration or {}, simulations or {}

    def simulations_of(self, world):
        return self.simulations.get(world, {'': []})

    def variants_on(self, world):
        return [v for v in self.variants if not (v.settings.get('odometry.source') == 'topic' and world in NO_ROBOT)]


NO_ROBOT = ['fast_walker']  # carried by a person: there are no wheels or legs to count

MAPS = Experiment('maps', PAPER_WORLDS + FURTHER_WORLDS, [
    Variant('full', 'this package'),
    Variant('no_layer', 'this package without topological layer', NO_LAYER),
    Variant('odometry', 'this package, odometry alone', MOTION_ONLY),
    Variant('encoders', 'this package', ENCODERS),
    Variant('encoders_no_layer', 'this package without topological layer', ENCODERS, NO_LAYER),
    Variant('encoders_odometry', 'encoder odometry alone', ENCODERS, MOTION_ONLY)])


# Twins of the worlds: seen by a real sensor, each by another unit, in a building with the errors of real ones.
def real_sensor(worlds):
    return {world: {'real': ['--sensor', 'real', '--unit', str(number)]} for number, world in enumerate(worlds, 1)}


TWINS = Experiment('twins', MAPS.worlds, MAPS.variants[:3], simulations=real_sensor(MAPS.worlds))

# Buildings of other outlines than rectangles, with both sensors. The second set is kept aside: it is run when the work on places is done, and only read.
PLAN_WORLDS = ['plan_shapes', 'plan_halls', 'plan_warehouse', 'plan_open_office', 'plan_branching', 'plan_alcoves']
HOLDOUT_WORLDS = ['holdout_museum', 'holdout_school', 'holdout_factory', 'holdout_ward', 'holdout_villa', 'holdout_star']


def plans(name, worlds):
    simulations = {world: {'ideal': [], **real} for world, real in real_sensor(worlds).items()}
    return Experiment(name, worlds, [Variant('full', 'this package'), Variant('odometry', 'odometry alone', MOTION_ONLY)], simulations=simulations)


PLANS, HOLDOUTS = plans('plans', PLAN_WORLDS), plans('holdouts', HOLDOUT_WORLDS)


def motion(name, label, settings=None):
    return Variant(name, label, MOTION_ONLY, settings or {})


ODOMETRY = Experiment('odometry', ['se1', 'cf1', 'le1'], [
    motion('default', 'as shipped: two faces, window of two scans, two pieces of motion a scan'),
    motion('motion_scan', 'each scan alone, its begin held at the end of the last', {'odometry.motion.model': 'scan'}),
    motion('motion_velocity', 'deskewed with the last velocity, one pose a scan', LAST_VELOCITY),
    motion('motion_none', 'not deskewed, one pose a scan', {'odometry.motion.model': 'none'}),
    motion('distribution', 'distribution to distribution (VGICP) instead of the distance along the normal', {'odometry.motion.residual': 'distribution'}),
    motion('one_face', 'one Gaussian a voxel: of the face of a wall seen first', {'odometry.map.two_faces': 'false'}),
    motion('one_segment', 'one piece of motion a scan', {'odometry.motion.segments': 1}),
    motion('three_segments', 'three pieces', {'odometry.motion.segments': 3}),
    motion('voxel_05', 'voxels of 0.5 m only', {'odometry.map.voxel': 0.5, 'odometry.map.levels': 1}),
    motion('voxel_10', 'voxels of 1.0 m only', {'odometry.map.levels': 1}),
    motion('no_wide', 'no wider voxels for the rough alignment', {'odometry.map.wide_levels': 0}),
    motion('keypoints_03', 'keypoints: one in 0.3 m instead of 0.2 m', {'odometry.motion.keypoint_leaf': 0.3}),
    motion('keypoints_01', 'keypoints: one in 0.1 m', {'odometry.motion.keypoint_leaf': 0}),
    motion('loose_prior', 'prior on the change of velocity five times looser', {'odometry.motion.rotation_sigma': 4.5e-3, 'odometry.motion.translation_sigma': 7.5e-3}),
], duration={'le1': 440})

SEEDS = {f'seed_{i}': ['--seed', str(i)] for i in range(1, 21)}
SENSORS = {'noise_1': ['--noise', '0.01'], 'noise_3': ['--noise', '0.03'], 'noise_4': ['--noise', '0.04'], 'rate_5': ['--rate', '5'],
           'rate_20': ['--rate', '20'], 'first': ['--stamp', 'first']}
ROBUSTNESS = Experiment('robustness', ['se1', 'fast_walker', 'standstill'], [motion('default', 'as shipped')],
                        simulations={'se1': {**SEEDS, **SENSORS}, 'fast_walker': SEEDS})

PLANES = Experiment('planes', ['se1', 'se2', 'cf1'], [
    Variant('scans_tangent', 'all scans since the last, fitted plane', NO_LAYER, {'odometry.keyframe.cloud': 'scans', 'mapping.factors.plane_factor': 'tangent'}),
    Variant('scans_points', 'all scans since the last, points', NO_LAYER, {'odometry.keyframe.cloud': 'scans', 'mapping.factors.plane_factor': 'points'}),
    Variant('scan_tangent', 'one scan, fitted plane', NO_LAYER, {'odometry.keyframe.cloud': 'scan', 'mapping.factors.plane_factor': 'tangent'}),
    Variant('scan_points', 'one scan, points', NO_LAYER, {'odometry.keyframe.cloud': 'scan', 'mapping.factors.plane_factor': 'points'})])

# The mechanisms, each switched against the default, and the odometries under which they have to show what they are for.
MECHANISMS = [
    ('whole', 'as shipped', {}),
    ('no_layer', 'no topological layer: no rooms, no corridors', NO_LAYER),
    ('no_parallel', 'without parallel and perpendicular walls as factors', {'mapping.topology.parallel_factors': 'false'}),
    ('widths', 'with widths as factors', {'mapping.topology.width_factors': 'true'}),
    ('thickness', 'with thicknesses of walls as factors', {'mapping.topology.thickness_factors': 'true'}),
    ('no_merging', 'without merging of duplicate planes', {'mapping.merging.enabled': 'false'}),
    ('map_axes', "classes of walls in the map's axes, not the building's", {'mapping.semantics.dominant_frame': 'false'}),
    ('no_loops', 'without loop closure by scan matching', {'mapping.loops.enabled': 'false'})]
ODOMETRIES = [
    ('lidar', 'LiDAR odometry as shipped', {}),
    ('last_velocity', 'LiDAR odometry made worse: deskewed with the last velocity only', LAST_VELOCITY),
    ('encoders', "the robot's encoder odometry: 1.2 % wrong in scale, drifting in heading", ENCODERS)]

TOPOLOGY = Experiment('topology', ['se1', 'se2', 'cf1'], [
    Variant(f'{source}_{name}', label, settings, odometry) for source, _, odometry in ODOMETRIES for name, label, settings in MECHANISMS])

EXPERIMENTS = {e.name: e for e in (MAPS, TWINS, PLANS, HOLDOUTS, ODOMETRY, ROBUSTNESS, PLANES, TOPOLOGY)}
ALL_WORLDS = list(dict.fromkeys(world for e in EXPERIMENTS.values() for world in e.worlds))


def restricted(experiment, worlds, only=None):
    """The experiment on some of its worlds, with some of its variants."""
    variants = [v for v in experiment.variants if only is None or v.name in only]
    return Experiment(experiment.name, [w for w in experiment.worlds if w in worlds], variants, experiment.duration, experiment.simulations)


def world_file(root, world):
    return os.path.join(root, 'worlds', world + '.yaml')
