# mypy: disable-error-code="no-untyped-def"
"""Kernels that lay one laser sweep over another (see sweeps.py), compiled by numba.

A transform (x, y, psi) takes points of the second sweep into the frame of the first, the query.
Sums run in a fixed order and without fast math: same input, same bytes.
"""

from __future__ import annotations

import numba
import numpy as np

_entry = numba.njit(cache=True, nogil=True, error_model="numpy")
_inner = numba.njit(nogil=True, error_model="numpy")

AGREE, CONFLICT, HIDDEN, OUTSIDE, RESIDUAL = 0, 1, 2, 3, 4


@_inner
def overlaid(field, u, v, du, dv, stride):
    """Mean of a field (n, n) at every so many points, in cells, moved by (du, dv)."""
    size = field.shape[0]
    total, count = 0.0, 0
    for i in range(0, len(u), stride):
        a, b = u[i] + du, v[i] + dv
        count += 1
        if a >= 0.0 and b >= 0.0 and a < size and b < size:
            total += field[int(a), int(b)]
    return total / max(count, 1)


@_inner
def placed(px, py, psi, cell, half, u, v):
    """Points turned by psi, in cells of a field about the origin, into u and v."""
    c, s = np.cos(psi) / cell, np.sin(psi) / cell
    for i in range(len(px)):
        u[i] = c * px[i] - s * py[i] + half / cell
        v[i] = s * px[i] + c * py[i] + half / cell


@_inner
def widest(field, cell, half, px, py, turns, reach, step, stride, found):
    """Best translation on a field for every turn: rows value, x, y, psi of found."""
    steps = int(np.round(reach / step))
    u, v = np.empty(len(px)), np.empty(len(px))
    for k in range(len(turns)):
        placed(px, py, turns[k], cell, half, u, v)
        found[k, 0], found[k, 3] = -1.0, turns[k]
        for a in range(-steps, steps + 1):
            for b in range(-steps, steps + 1):
                if a * a + b * b > steps * steps + 1:
                    continue
                value = overlaid(field, u, v, a * step / cell, b * step / cell, stride)
                if value > found[k, 0]:
                    found[k, 0], found[k, 1], found[k, 2] = value, a * step, b * step


@_inner
def climbed(field, cell, half, px, py, pose, steps):
    """Best value near a pose on a field; the pose moves there."""
    u, v = np.empty(len(px)), np.empty(len(px))
    best = -1.0
    for level in range(len(steps)):
        best = -1.0
        x0, y0, psi0 = pose[0], pose[1], pose[2]
        for k in range(-2, 3):
            psi = psi0 + k * steps[level, 1]
            placed(px, py, psi, cell, half, u, v)
            for a in range(-2, 3):
                for b in range(-2, 3):
                    x, y = x0 + a * steps[level, 0], y0 + b * steps[level, 0]
                    value = overlaid(field, u, v, x / cell, y / cell, int(steps[level, 2]))
                    if value > best:
                        best = value
                        pose[0], pose[1], pose[2] = x, y, psi
    return best


@_entry
def search(fine, coarse, cells, half, px, py, turns, closed, reach, step, stride, steps, out):
    """Best few overlays of points on the query's fields: rows value, x, y, psi of out (K, 4).

    Every turn and translation on the coarse field; the best turns, none next to another, climb on
    the fine field. ``cells`` : sides of a fine and of a coarse cell; ``steps`` (L, 3): metres,
    radians and stride over the points of each level of the climb.
    """
    found = np.empty((len(turns), 4))
    widest(coarse, cells[1], half, px, py, turns, reach, step, stride, found)
    free = np.ones(len(turns), np.bool_)
    for k in range(len(out)):
        best = -1
        for t in range(len(turns)):
            if free[t] and (best < 0 or found[t, 0] > found[best, 0]):
                best = t
        out[k, 0] = -1.0
        if best < 0:
            continue
        for t in (best - 1, best, best + 1):
            if closed or 0 <= t < len(turns):
                free[t % len(turns)] = False
        out[k, 1:] = found[best, 1:]
        out[k, 0] = climbed(fine, cells[0], half, px, py, out[k, 1:], steps)


@_entry
def correlate(fine, coarse, cells, half, px, py, turns, reach, step, pose):
    """Best overlay on the fine field over every turn and every translation on a grid of ``step``.

    A block of translations as wide as a coarse cell is only looked into where the coarse field,
    the largest likelihood in reach of it, promises more than the best so far. Returns the mean
    likelihood; the pose is set.
    """
    per = max(1, int(np.floor(cells[1] / step + 1e-9)))
    blocks = int(np.ceil(2.0 * reach / (per * step) + 1e-9))
    bounds = np.empty((len(turns), blocks * blocks))
    u, v = np.empty(len(px)), np.empty(len(px))
    for t in range(len(turns)):
        placed(px, py, turns[t], cells[1], half, u, v)
        for b in range(blocks * blocks):
            dx = -reach + (b // blocks + 0.5) * per * step - 0.5 * step
            dy = -reach + (b % blocks + 0.5) * per * step - 0.5 * step
            bounds[t, b] = overlaid(coarse, u, v, dx / cells[1], dy / cells[1], 1)
    best = -1.0
    order = np.argsort(-bounds.ravel(), kind="mergesort")
    for at in order:
        t, b = at // (blocks * blocks), at % (blocks * blocks)
        if bounds[t, b] <= best:
            break
        placed(px, py, turns[t], cells[0], half, u, v)
        for i in range(per):
            for j in range(per):
                x = -reach + ((b // blocks) * per + i) * step
                y = -reach + ((b % blocks) * per + j) * step
                value = overlaid(fine, u, v, x / cells[0], y / cells[0], 1)
                if value > best:
                    best = value
                    pose[0], pose[1], pose[2] = x, y, turns[t]
    return best


@_inner
def beam(bearing, start, step, count, closed):
    """Beam a bearing falls on, as a fraction; of an open sweep it may lie outside."""
    at = (bearing - start) / step
    turn = 2.0 * np.pi / step
    while at < -0.5:
        at += turn
    while at >= turn - 0.5:
        at -= turn
    if not closed and at > 0.5 * (turn + count - 1.0):
        at -= turn
    return at


@_inner
def nearest(x, y, ranges, at, window, closed, px, py):
    """Hit nearest to a point among the beams around the one it falls on, and how far."""
    count = len(ranges)
    middle = int(np.round(at))
    best, row = np.inf, -1
    for k in range(middle - window, middle + window + 1):
        i = k
        if closed:
            i = k % count
        elif k < 0 or k >= count:
            continue
        if not (0.0 < ranges[i] < np.inf):
            continue
        d = (x[i] - px) ** 2 + (y[i] - py) ** 2
        if d < best:
            best, row = d, i
    return row, np.sqrt(best)


@_entry
def refine(x, y, ranges, normals, start, step, closed, px, py, gates, pose, information):
    """Point-to-line Gauss-Newton: the pose moves, information (3, 3) is that of the last step.

    ``gates`` (I,): farthest pair of each step, metres. Returns pairs used and their mean square
    distance; 0 pairs where nothing could be done.
    """
    window = int(np.ceil(np.deg2rad(10.0) / step))
    pairs, square = 0, 0.0
    for gate in gates:
        c, s = np.cos(pose[2]), np.sin(pose[2])
        a, g = np.zeros((3, 3)), np.zeros(3)
        j = np.empty(3)
        pairs, square = 0, 0.0
        for k in range(len(px)):
            u, v = c * px[k] - s * py[k], s * px[k] + c * py[k]
            at = beam(np.arctan2(v + pose[1], u + pose[0]), start, step, len(ranges), closed)
            i, d = nearest(x, y, ranges, at, window, closed, u + pose[0], v + pose[1])
            if i < 0 or d > gate or np.isnan(normals[i, 0]):
                continue
            j[0], j[1] = normals[i, 0], normals[i, 1]
            j[2] = j[1] * u - j[0] * v
            e = j[0] * (u + pose[0] - x[i]) + j[1] * (v + pose[1] - y[i])
            w = 1.0 / (1.0 + (e / 0.1) ** 2)
            for m in range(3):
                g[m] += w * j[m] * e
                for n in range(3):
                    a[m, n] += w * j[m] * j[n]
            pairs += 1
            square += w * e * e
        if pairs < 8:
            return 0, 0.0
        information[:, :] = a
        for m in range(3):
            a[m, m] += 1e-3 * pairs
        move = np.linalg.solve(a, g)
        pose[0] -= min(max(move[0], -0.5), 0.5)
        pose[1] -= min(max(move[1], -0.5), 0.5)
        pose[2] -= min(max(move[2], -0.2), 0.2)
        square /= pairs
    return pairs, square


@_entry
def check(x, y, ranges, start, step, closed, px, py, weights, pose, out):
    """Shares of weighted points that agree with a sweep, conflict with it, are hidden or outside.

    A point agrees near a hit; it conflicts where a beam went through it, is hidden behind a hit,
    and outside where no beam looked. ``out`` (5,): the four and the agreeing points' distances.
    """
    count = len(ranges)
    window = int(np.ceil(np.deg2rad(5.0) / step))
    c, s = np.cos(pose[2]), np.sin(pose[2])
    out[:] = 0.0
    for k in range(len(px)):
        u, v = c * px[k] - s * py[k] + pose[0], s * px[k] + c * py[k] + pose[1]
        rho = np.sqrt(u * u + v * v)
        at = beam(np.arctan2(v, u), start, step, count, closed)
        if not closed and (at < -1.0 or at > count):
            out[OUTSIDE] += weights[k]
            continue
        near = 0.15 + 0.01 * rho
        _, d = nearest(x, y, ranges, at, window, closed, u, v)
        if d < near:
            out[AGREE] += weights[k]
            out[RESIDUAL] += weights[k] * d
            continue
        low = int(np.floor(at))
        high = low + 1
        if closed:
            low, high = low % count, high % count
        else:
            low, high = min(max(low, 0), count - 1), min(max(high, 0), count - 1)
        if ranges[low] <= 0.0 or ranges[high] <= 0.0:
            out[OUTSIDE] += weights[k]
        elif rho < min(ranges[low], ranges[high]) - near:
            out[CONFLICT] += weights[k]
        elif rho > max(ranges[low], ranges[high]) + near:
            out[HIDDEN] += weights[k]
        else:
            out[AGREE] += 0.5 * weights[k]
            out[RESIDUAL] += 0.1 * weights[k]


@_entry
def directions(x, y, ranges, closed, out):
    """Normal of the surface at every hit from up to two hits on either side; NaN where there is no
    line to speak of. (n, 2)."""
    count = len(ranges)
    for i in range(count):
        out[i, 0] = out[i, 1] = np.nan
        if not (0.0 < ranges[i] < np.inf):
            continue
        limit = 0.2 + 0.12 * ranges[i]
        n, mx, my, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(i - 2, i + 3):
            j = k % count
            if (not closed and j != k) or not (0.0 < ranges[j] < np.inf):
                continue
            dx, dy = x[j] - x[i], y[j] - y[i]
            if np.sqrt(dx * dx + dy * dy) > limit:
                continue
            n, mx, my = n + 1, mx + dx, my + dy
            xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
        if n < 3:
            continue
        xx, xy, yy = xx - mx * mx / n, xy - mx * my / n, yy - my * my / n
        spread = np.sqrt((xx - yy) ** 2 + 4.0 * xy * xy)
        if xx + yy - spread < 0.1 * (xx + yy + spread):
            along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
            out[i, 0], out[i, 1] = -np.sin(along), np.cos(along)
