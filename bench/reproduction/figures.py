"""Single figures out of a run's evaluation.json and report.json, as text for a table's cell."""
import math


def statistics(values):
    if not values:
        return None
    mean = sum(values) / len(values)
    return mean, (sum((v - mean) ** 2 for v in values) / len(values)) ** 0.5


def millimetres(metres):
    if metres >= 1:
        return f'{metres:.1f} m'
    return f'{1000 * metres:.1f}' if metres < 0.1 else f'{1000 * metres:.0f}'


def ate_of(trajectory, text):
    def read(evaluation, _):
        return text(evaluation[trajectory]['ate_translation_m']['rmse'])
    return read


def drift_of(trajectory):
    def read(evaluation, _):
        d = evaluation[trajectory]['drift_10m']
        return f"{d['translation_percent']:.2f} / {d['rotation_deg_per_m']:.3f}"
    return read


ate, live_ate = (ate_of(t, '{:.4f}'.format) for t in ('trajectory', 'trajectory_live'))
ate_mm, live_ate_mm = (ate_of(t, millimetres) for t in ('trajectory', 'trajectory_live'))
drift, live_drift = (drift_of(t) for t in ('trajectory', 'trajectory_live'))


def ate_and_live_mm(evaluation, report):
    return f'{ate_mm(evaluation, report)} ({live_ate_mm(evaluation, report)})'


def standing_drift(path, count=100):
    """From the mean of the first poses of a trajectory file to that of the last: [m], [deg]. For one that stands: the mean of nearly equal quaternions is near enough."""
    with open(path) as file:
        poses = [[float(v) for v in line.split()[1:]] for line in file if line.strip() and not line.startswith('#')]

    def mean(some):
        return [sum(p[i] * (1 if p[6] > 0 else -1 if i > 2 else 1) for p in some) / len(some) for i in range(7)]
    begin, end = mean(poses[:count]), mean(poses[-count:])
    half = sum((a - b) ** 2 for a, b in zip(begin[3:], end[3:])) ** 0.5 / 2
    return sum((a - b) ** 2 for a, b in zip(begin[:3], end[:3])) ** 0.5, math.degrees(4 * math.asin(min(1.0, half)))


def length(evaluation, _):
    return f"{evaluation['trajectory']['duration_s']:.0f} s, {evaluation['trajectory']['length_m']:.0f} m"


def start_to_end(evaluation, _):
    error = evaluation['trajectory']['start_to_end']
    return f"{error['translation_m']:.4f} / {error['rotation_deg']:.3f}"


def map_rmse(evaluation, _):
    return f"{evaluation['map']['rmse_m']:.4f}"


def map_rmse_mm(evaluation, _):
    return f"{1000 * evaluation['map']['rmse_m']:.1f}"


def solve_time(_, report):
    mean, std = statistics([s['ms'] for s in report['solves']])
    return f'{mean:.1f} / {std:.1f}'


def mapping_time(_, report):
    stage = report['stages_cpu_ms']['mapping']
    return f"{stage['mean']:.1f} / {stage['std']:.1f}"


def places(kind):
    def read(evaluation, _):
        score = evaluation[kind]
        text = f"{len(score['matches'])} / {score['true']}"
        wrong = len(score['false_alarms'])
        return text + (f', {wrong} wrong' if wrong else '')
    return read


def place_errors(kind):
    def read(evaluation, _):
        score = evaluation[kind]
        if not score['matches']:
            return '-'
        return f"{1000 * score['center_error_m']['mean']:.0f} / {1000 * score['width_error_m']['mean']:.0f}"
    return read


def quality(evaluation, _):
    score = evaluation['places']
    return f"{score['panoptic_quality']:.3f}"


def places_found(evaluation, _):
    score = evaluation['places']
    wrong = len(score['invented'])
    return f"{len(score['matches'])} / {score['true']}" + (f', {wrong} wrong' if wrong else '')


def overlaps(evaluation, _):
    score = evaluation['places']
    return f"{100 * score['iou_of_true']:.0f} / {100 * score['iou_of_found']:.0f} %"


def doors(evaluation, _):
    score = evaluation['doors']
    return f"{score['recall']:.2f} / {score['precision']:.2f} / {100 * score['width_error_m']['rmse']:.1f} cm"


def ghosts(evaluation, _):
    return f"{100 * evaluation['map']['ghost_share']:.2f} % / {evaluation['map']['p95_m']:.3f}"


def walls_found(evaluation, _):
    score = evaluation['walls']
    return f"{score['found']} / {score['faces']} ({100 * score['recall']:.0f} %)"


def wall_duplicates(evaluation, _):
    return f"{100 * evaluation['walls']['duplicate_share']:.0f} %"


def wall_errors(evaluation, _):
    score = evaluation['walls']
    return f"{score['normal_error_deg']['median']:.3f} / {1000 * score['position_error_m']['median']:.1f}"


def stage_cpu(*stages, per_second=False):
    """CPU time of the stages [ms]: a scan, or a second of data."""
    def read(_, report):
        total = sum(report['stages_cpu_ms'][s]['mean'] * report['stages_cpu_ms'][s]['runs'] for s in stages)
        return f"{total / (report['data_seconds'] if per_second else report['counts']['scans']):.1f}"
    return read


def scan_p99(_, report):
    return f"{report['stages_ms']['odometry']['p99']:.0f}"


def speed(_, report):
    """CPU seconds a second of data."""
    return f"{report['cpu_seconds'] / report['data_seconds']:.3f}"


def memory(_, report):
    return f"{report['peak_memory_mib']:.0f}"
