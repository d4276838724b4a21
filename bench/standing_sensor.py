"""Figures of a spinning 16-ring LiDAR's errors from a recording in which it stands still in front of walls: offsets of the rings, periodic and white noise,
texture, mixed pixels, echoes that are missing. See bench/compare_recordings --standing."""
import collections

import numpy as np

FIRING = 55.296e-6  # s, from one firing of all lasers to the next
CELL = np.radians(0.2)  # of azimuth
JUMPS = [(0.15, 0.3), (0.3, 0.5), (0.5, 0.8), (0.8, 1.3), (1.3, 2.5)]  # m


class Recording:
    """All points of the scans side by side: direction, range, intensity, firing within the scan, cell of ring and azimuth."""

    def __init__(self, scans):
        columns = collections.defaultdict(list)
        missing, fired = 0, 0
        for number, (_, _, points) in enumerate(scans):
            xyz = np.column_stack([points[k].astype(float) for k in 'xyz'])
            ranges = np.linalg.norm(xyz, axis=1)
            seen = ranges > 1e-3
            time = points['time'].astype(float)
            firing = np.floor((time - time.min()) / FIRING + 0.02).astype(int)
            fired += 16 * (firing.max() + 1)
            missing += 16 * (firing.max() + 1) - seen.sum()
            columns['xyz'].append(xyz[seen])
            columns['range'].append(ranges[seen])
            columns['ring'].append(points['ring'].astype(int)[seen])
            columns['intensity'].append(points['intensity'].astype(float)[seen])
            columns['firing'].append(firing[seen])
            columns['scan'].append(np.full(seen.sum(), number))
        for name, parts in columns.items():
            setattr(self, name, np.concatenate(parts))
        self.direction = self.xyz / self.range[:, None]
        self.azimuth = np.arctan2(self.xyz[:, 1], self.xyz[:, 0])
        self.no_return = missing / fired
        index = self.ring * 4096 + np.floor((self.azimuth + np.pi) / CELL).astype(int)
        self.cells, self.cell = np.unique(index, return_inverse=True)
        self.scans = len(scans)


def quiet_residuals(r):
    """Of each point to the line (range over azimuth) through its cell's points; and which cells hold one surface only and enough points."""
    count = np.bincount(r.cell)
    mean = lambda v: np.bincount(r.cell, v) / count
    offset = r.azimuth - mean(r.azimuth)[r.cell]
    ranges = r.range - mean(r.range)[r.cell]
    slope = np.bincount(r.cell, offset * ranges) / np.maximum(np.bincount(r.cell, offset * offset), 1e-9)
    residual = ranges - slope[r.cell] * offset
    spread = np.sqrt(np.bincount(r.cell, residual ** 2) / np.maximum(count - 2, 1))
    good = (count >= max(6, 0.6 * r.scans)) & (spread < 0.03) & (np.bincount(r.cell, np.abs(offset)) > 0)
    return residual * np.sqrt(count / np.maximum(count - 2, 1))[r.cell], good


def periodic(r, residual, use, frequency=None):
    """Frequency [cycles a firing] and amplitude [m] of the strongest sine of the residuals, and the residuals without it (fitted a ring and scan)."""
    groups = []
    for scan in range(r.scans):
        for ring in range(16):
            at = np.nonzero(use & (r.scan == scan) & (r.ring == ring))[0]
            if len(at) > 300:
                groups.append(at)
    if not groups:
        return np.nan, np.nan, residual
    if frequency is None:
        length = 1 << 15  # a step of the frequency of 0.00003
        power = np.zeros(length // 2 + 1)
        for at in groups[::max(1, len(groups) // 60)]:
            series = np.zeros(length)
            series[r.firing[at]] = residual[at]
            power += np.abs(np.fft.rfft(series) / len(at)) ** 2
        power[:int(0.02 * length)] = 0
        frequency = np.argmax(power) / length
    amplitudes, rest = [], residual.copy()
    for at in groups:
        basis = np.column_stack([np.cos(2 * np.pi * frequency * r.firing[at]), np.sin(2 * np.pi * frequency * r.firing[at])])
        weights = np.linalg.lstsq(basis, residual[at], rcond=None)[0]
        amplitudes.append(np.hypot(*weights))
        rest[at] -= basis @ weights
    return frequency, float(np.median(amplitudes)), rest


def upright_walls(xy, ring, rng, most=6, reach=0.03):
    """Index lists of points on upright planes that many rings see, the largest first."""
    left = np.arange(len(xy))
    walls = []
    while len(walls) < most and len(left) > 500:
        best = []
        for _ in range(300):
            a, b = xy[rng.choice(left, 2, replace=False)]
            length = np.hypot(*(b - a))
            if length < 0.5:
                continue
            normal = np.array([a[1] - b[1], b[0] - a[0]]) / length
            near = left[np.abs((xy[left] - a) @ normal) < reach]
            if len(near) > len(best):
                best = near
        if len(best) < 400:
            break
        left = np.setdiff1d(left, best)
        if len(set(ring[best])) >= 12:
            walls.append(best)
    return walls


class WallFit:
    """Planes through the cells' mean points with one range offset a ring, in least squares; residuals along the ray."""

    def __init__(self, r, good):
        count = np.bincount(r.cell)
        mean = lambda v: np.bincount(r.cell, v) / count
        self.intensity = mean(r.intensity)[good]
        self.count = count[good]
        self.ring = (r.cells // 4096)[good]
        self.cell_of = np.nonzero(good)[0]
        direction = np.column_stack([mean(r.direction[:, k]) for k in range(3)])[good]
        self.direction = direction / np.linalg.norm(direction, axis=1)[:, None]
        self.point = self.direction * mean(r.range)[good][:, None]
        self.walls = upright_walls(self.point[:, :2], self.ring, np.random.default_rng(1))
        self.offsets = np.zeros(16)
        self.solve()

    def solve(self):
        planes = []
        for wall in self.walls:
            p = self.point[wall]
            middle = p[:, :2].mean(axis=0)
            normal = np.linalg.svd(p[:, :2] - middle)[2][-1]
            planes.append(np.array([normal[0], normal[1], 0, normal @ middle]))
        used = [wall for wall in self.walls]
        residual = {}
        for turn in range(8):
            rows, right, at_wall = [], [], []
            for w, (wall, plane) in enumerate(zip(used, planes)):
                n = plane[:3] / np.linalg.norm(plane[:3])
                p = self.point[wall] - self.offsets[self.ring[wall]][:, None] * self.direction[wall]
                error = p @ n - plane[3]
                across = self.direction[wall] @ n
                block = np.zeros((len(wall), 16 + 3 * len(used)))
                tangent = np.array([-n[1], n[0], 0])
                block[np.arange(len(wall)), self.ring[wall]] = across
                block[:, 16 + 3 * w] = -(p @ tangent)
                block[:, 16 + 3 * w + 1] = -p[:, 2]
                block[:, 16 + 3 * w + 2] = 1
                rows.append(block)
                right.append(error)
                at_wall.append(across)
            a, b = np.vstack(rows), np.concatenate(right)
            gauge = np.zeros((1, a.shape[1]))
            gauge[0, :16] = 1e3
            step = np.linalg.lstsq(np.vstack([a, gauge, 1e-6 * np.eye(a.shape[1])]), np.concatenate([b, [-1e3 * self.offsets.sum()], np.zeros(a.shape[1])]), rcond=None)[0]
            self.offsets = self.offsets + step[:16]
            for w, plane in enumerate(planes):
                n = plane[:3] / np.linalg.norm(plane[:3])
                tangent = np.array([-n[1], n[0], 0])
                n = n + step[16 + 3 * w] * tangent + step[16 + 3 * w + 1] * np.array([0, 0, 1.0])
                planes[w] = np.append(n / np.linalg.norm(n), plane[3] + step[16 + 3 * w + 2])
            for w, wall in enumerate(self.walls):  # what stands in front of the wall goes
                n = planes[w][:3]
                p = self.point[wall] - self.offsets[self.ring[wall]][:, None] * self.direction[wall]
                error = p @ n - planes[w][3]
                scale = max(0.005, 1.4826 * np.median(np.abs(error - np.median(error))))
                used[w] = wall[np.abs(error) < 2.5 * scale]
                residual[w] = error[np.abs(error) < 2.5 * scale]
        self.used, self.planes, self.residual = used, planes, residual

    def flat(self):
        """Cells on walls, their residual along the ray and the cosine of their incidence."""
        cells = np.concatenate(self.used)
        cosine = np.concatenate([np.abs(self.direction[wall] @ plane[:3]) for wall, plane in zip(self.used, self.planes)])
        sign = np.concatenate([np.sign(self.direction[wall] @ plane[:3]) for wall, plane in zip(self.used, self.planes)])
        error = np.concatenate([self.residual[w] for w in range(len(self.used))])
        return cells, error * sign / np.maximum(cosine, 0.2), cosine


def mixed_pixels(r):
    """Edges and floating points at them, by jump of the range."""
    edges, floating = np.zeros(len(JUMPS), int), np.zeros(len(JUMPS), int)
    smooth = 0.05
    for scan in range(r.scans):
        for ring in range(16):
            at = np.nonzero((r.scan == scan) & (r.ring == ring))[0]
            at = at[np.argsort(r.firing[at])]
            x, k = r.range[at], r.firing[at]
            if len(at) < 10:
                continue
            step = np.diff(k)
            for i in range(1, len(x) - 3):
                if step[i - 1] != 1 or step[i] != 1 or step[i + 1] != 1:
                    continue
                if abs(x[i] - x[i - 1]) > smooth:
                    continue
                sharp = abs(x[i + 1] - x[i + 2]) < smooth and abs(x[i + 1] - x[i]) > JUMPS[0][0]
                if sharp:
                    jump, floats = abs(x[i + 1] - x[i]), 0
                elif i + 3 < len(x) and step[i + 2] == 1 and abs(x[i + 2] - x[i + 3]) < smooth and \
                        min(x[i], x[i + 2]) + 0.05 < x[i + 1] < max(x[i], x[i + 2]) - 0.05:
                    jump, floats = abs(x[i + 2] - x[i]), 1
                else:
                    continue
                for j, (low, high) in enumerate(JUMPS):
                    if low <= jump < high:
                        edges[j] += 1
                        floating[j] += floats
    return edges, floating


def millimetres(values, digits=1):
    return ' / '.join('-' if not np.isfinite(v) else f'{1e3 * v:.{digits}f}' for v in values)


def rms(values, least=300):
    return 1.4826 * np.median(np.abs(values)) if len(values) >= least else np.nan


def figures(scans):
    """The table's column for a standing recording: name to text."""
    r = Recording(scans)
    residual, good = quiet_residuals(r)
    use = good[r.cell]
    bright = use & (r.intensity >= 20)
    frequency, amplitude, white = periodic(r, residual, bright)
    _, _, white_all = periodic(r, residual, use, frequency)
    fit = WallFit(r, good)
    cells, error, cosine = fit.flat()
    on_wall = np.full(len(r.cells), np.nan)
    on_wall[fit.cell_of[cells]] = cosine
    angle = np.degrees(np.arccos(np.minimum(on_wall[r.cell], 1)))
    rows = collections.OrderedDict()
    rows['scans, points a scan'] = f'{r.scans}, {len(r.range) / r.scans:.0f}'
    rows['firings without an echo'] = f'{100 * r.no_return:.1f} %'
    rows['walls used'] = str(len(fit.used))
    rows['range offset by ring: std, extremes [mm]'] = f'{1e3 * fit.offsets.std():.1f}, {1e3 * fit.offsets.min():+.0f} .. {1e3 * fit.offsets.max():+.0f}'
    rows['spread about one place [mm]'] = millimetres([rms(residual[bright])])
    rows['sine: cycles a firing, amplitude [mm]'] = f'{frequency:.4f}, {1e3 * amplitude:.1f}'
    classes = [(40, 101), (5, 40), (2, 5), (0, 2)]
    rows['white part, intensity 40-100, 5-40, 2-5, < 2 [mm]'] = millimetres([rms(white_all[use & (r.intensity >= low) & (r.intensity < high)]) for low, high in classes])
    rows['white part, incidence < 30, > 50 deg [mm]'] = millimetres([rms(white[bright & (angle < 30)]), rms(white[bright & (angle > 50)])])
    near = (np.diff(fit.cell_of[cells]) == 1) & (np.diff(fit.ring[cells]) == 0)
    step = np.diff(error)[near] / np.sqrt(2)
    noise = np.median(residual[bright] ** 2) / 0.4549 / np.median(fit.count)
    rows['texture of walls, cell to cell [mm]'] = millimetres([np.sqrt(max(0, (1.4826 * np.median(np.abs(step))) ** 2 - noise))])
    intensity = fit.intensity[cells]
    level = np.median(error[intensity >= 40]) if (intensity >= 40).sum() > 50 else np.nan
    bias = [np.median(error[(intensity >= low) & (intensity < high)]) - level if ((intensity >= low) & (intensity < high)).sum() > 50 else np.nan for low, high in [(0, 10), (10, 20), (20, 40)]]
    rows['bias, intensity < 10, 10-20, 20-40 against > 40 [mm]'] = millimetres(bias)
    edges, floating = mixed_pixels(r)
    rows['edges with a floating point, by jump [%]'] = ' / '.join(f'{100 * f / e:.0f}' if e > 30 else '-' for e, f in zip(edges, floating))
    rows['edges a scan, by jump'] = ' / '.join(f'{e / r.scans:.0f}' for e in edges)
    elevation = np.arctan2(r.xyz[:, 2], np.hypot(r.xyz[:, 0], r.xyz[:, 1]))
    rows['elevation within a ring, std [deg]'] = f'{np.degrees(np.median([elevation[r.ring == k].std() for k in range(16)])):.1e}'
    rows['intensity 5, 50, 95 %'] = ', '.join(f'{v:.0f}' for v in np.percentile(r.intensity, [5, 50, 95]))
    return rows
