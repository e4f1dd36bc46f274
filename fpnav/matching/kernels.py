# mypy: disable-error-code="no-untyped-def"
"""Alignment kernels compiled by numba: rotations as lanes.

For one pair all rotations of x advance together. With x doubled, what the rotations need of a
symbol of y is one contiguous slice, so the inner loop runs over rotations with no lookup. All
values lie on the score grid (see strings.py), where float32 is exact up to EXACT_SUM: the answers
equal those of the numpy path to the last bit. Compiled code is cached on disk.

The inner loops are written for the vectoriser: lane buffers live in one array at constant
distances and each loop stores to at most two arrays, else its overlap checks send it to scalar
code.
"""

from __future__ import annotations

import numba
import numpy as np

TAU = 2.0 * np.pi
SLACK_RAD = 1e-6
PER_UNIT = 65536.0
ROUND = 1.5 * 2.0**52

LANES_MAX = 256
EXACT_SUM = 250.0
ABOVE, DIAGONAL = 0, 256
BUFFER = 512

_entry = numba.njit(cache=True, nogil=True, error_model="numpy")
_inner = numba.njit(nogil=True, error_model="numpy")


@_inner
def nearest(value):
    """Nearest whole number, ties to even, as numpy's rint; |value| < 2^50."""
    return (value + ROUND) - ROUND


@_inner
def on_grid(value):
    """Nearest multiple of the score grid."""
    return nearest(value * PER_UNIT) / PER_UNIT


@_inner
def doubled(codes, weights, sigma, gap, lanes, worth, half, gaps):
    """String x continued cyclically: sigma of every code with each symbol and half its score
    (C, n + lanes), gap costs (n + lanes,)."""
    n = len(codes)
    for p in range(n + lanes):
        c, w = codes[p % n], weights[p % n]
        gaps[p] = on_grid(gap[c] * w)
        for z in range(len(gap)):
            worth[z, p] = sigma[c, z]
            half[z, p] = on_grid(0.5 * w * sigma[c, z])


@_inner
def plain(worth, half, gaps, codes, weights, gap, row, buffer, table):
    """All rotations of x (prepared by ``doubled``) with one y; the scores are ``table[-1]``."""
    n, lanes = table.shape[0] - 1, table.shape[1]
    for k in range(lanes):
        table[0, k] = 0.0
    for i in range(n):
        for k in range(lanes):
            table[i + 1, k] = table[i, k] - gaps[i + k]
    for j in range(len(codes)):
        c, w = codes[j], weights[j]
        row[-1] = on_grid(gap[c] * w)
        cost = row[-1]
        for p in range(n + lanes):
            row[p] = half[c, p] + on_grid(0.5 * w * worth[c, p])
        for k in range(lanes):
            buffer[DIAGONAL + k] = table[0, k]
            buffer[ABOVE + k] = table[0, k] - cost
            table[0, k] = buffer[ABOVE + k]
        for i in range(1, n + 1):
            for k in range(lanes):
                old = table[i, k]
                best = buffer[DIAGONAL + k] + row[i - 1 + k]
                skip_y = old - cost
                skip_x = buffer[ABOVE + k] - gaps[i - 1 + k]
                best = skip_y if skip_y > best else best
                best = skip_x if skip_x > best else best
                buffer[DIAGONAL + k] = old
                buffer[ABOVE + k] = best
                table[i, k] = best


@_inner
def alike(xarcs, yarcs):
    """Whether every kind of sensor covers as much in both."""
    for kind in range(len(xarcs)):  # noqa: SIM110 (numba has no generator here)
        if abs(xarcs[kind, 1] - yarcs[kind, 1]) > SLACK_RAD:
            return False
    return True


@_inner
def off(angle):
    """Distance to the nearest multiple of 2 pi."""
    return abs(angle - TAU * nearest(angle / TAU))


@_inner
def not_within(first, second, turn):
    """Bit set of the kinds of sensor where neither arc lies within the other after the turn."""
    bits = 0
    for kind in range(len(first)):
        a, b = first[kind, 1], second[kind, 1]
        apart = off(first[kind, 0] + turn - second[kind, 0])
        if not (
            apart <= abs(a - b) / 2.0 + SLACK_RAD
            or min(a, b) <= 0.0
            or max(a, b) >= TAU - SLACK_RAD
        ):
            bits |= 1 << kind
    return bits


@_inner
def covered(angle, arcs, bits):
    """Bit set of the kinds of sensor that cover an angle, added to ``bits``."""
    for kind in range(len(arcs)):
        width = arcs[kind, 1]
        if width > 0.0 and off(angle - arcs[kind, 0]) <= width / 2.0 + SLACK_RAD:
            bits |= 1 << kind
    return bits


@_inner
def look(x, y, k, visible, seen_x, seen_y):
    """Fill in what each could see of the other when x, in the order of its rotation k, begins
    where y does (see coverage.comparable); ones and zeros."""
    xc, _, xa, xarcs, _ = x
    yc, _, ya, yarcs, _ = y
    turn = ya[0] - xa[k]
    bits = not_within(xarcs, yarcs, turn)
    for i in range(len(xc)):
        p = (i + k) % len(xc)
        seen_x[i] = visible[xc[p], covered(xa[p] + turn, yarcs, bits)]
    for j in range(len(yc)):
        seen_y[j] = visible[yc[j], covered(ya[j] - turn, xarcs, bits)]


@_inner
def align_one(x, y, k, scores, seen_x, seen_y, pair, table):
    """Pair scores (n, m) and alignment table (n + 1, m + 1) of rotation k of x with y."""
    xc, xw, _, _, _ = x
    yc, yw, _, _, _ = y
    sigma, gap, _ = scores
    table[0, 0] = 0.0
    for j in range(len(yc)):
        table[0, j + 1] = table[0, j] - seen_y[j] * on_grid(gap[yc[j]] * yw[j])
    for i in range(len(xc)):
        p = (i + k) % len(xc)
        skip_x = seen_x[i] * on_grid(gap[xc[p]] * xw[p])
        table[i + 1, 0] = table[i, 0] - skip_x
        for j in range(len(yc)):
            worth = sigma[xc[p], yc[j]]
            own = seen_x[i] * on_grid(0.5 * xw[p] * worth)
            pair[i, j] = own + seen_y[j] * on_grid(0.5 * yw[j] * worth)
            skip_y = seen_y[j] * on_grid(gap[yc[j]] * yw[j])
            best = max(table[i, j] + pair[i, j], table[i, j + 1] - skip_x)
            table[i + 1, j + 1] = max(best, table[i + 1, j] - skip_y)


@_inner
def partial_ratio(x, y, k, scores, sight):
    """Normalised score of rotation k of x with y where coverage excuses symbols."""
    seen_x, seen_y, pair, table = sight
    n, m = len(x[0]), len(y[0])
    look(x, y, k, scores[2], seen_x, seen_y)
    align_one(x, y, k, scores, seen_x, seen_y, pair, table)
    total = 0.0
    for i in range(n):
        total += seen_x[i] * x[1][(i + k) % n]
    for j in range(m):
        total += seen_y[j] * y[1][j]
    return table[n, m] / (0.5 * total) if total > 0.0 else 0.0


@_inner
def workspace(x, scores):
    """String x prepared, and the buffers every pair of it uses."""
    xc, xw, _, _, _ = x
    sigma, gap, _ = scores
    n, lanes = len(xc), -(-max(len(xc), 1) // 8) * 8
    worth = np.zeros((len(gap), n + lanes))
    half = np.zeros((len(gap), n + lanes), np.float32)
    gaps = np.zeros(n + lanes, np.float32)
    doubled(xc, xw, sigma, gap, lanes, worth, half, gaps)
    row, buffer = np.zeros(n + lanes + 1, np.float32), np.zeros(BUFFER, np.float32)
    return worth, half, gaps, row, buffer, np.zeros((n + 1, lanes), np.float32)


@_inner
def string(y, r):
    """String r of a batch."""
    yc, yw, ya, yo, yarcs, fixed = y
    a, b = yo[r], yo[r + 1]
    return yc[a:b], yw[a:b], ya[a:b], yarcs[r], fixed[r]


@_inner
def sights(x, y, rows):
    """Buffers for partial views: masks, pair scores and table up to the longest y."""
    n, longest = len(x[0]), 0
    for t in range(len(rows)):
        longest = max(longest, y[3][rows[t] + 1] - y[3][rows[t]])
    return (
        np.ones(n),
        np.ones(longest),
        np.zeros((n, longest)),
        np.zeros((n + 1, longest + 1)),
    )


@_inner
def pair_ratios(x, y, scores, work, sight, out):
    """``out[k]`` = normalised score of one pair when x is cut before its symbol k."""
    xc, xw, _, xarcs, x_fixed = x
    yc, yw, _, yarcs, y_fixed = y
    worth, half, gaps, row, buffer, table = work
    n, m = len(xc), len(yc)
    count = 1 if n == 0 or (x_fixed and y_fixed) else n
    for k in range(count, n):
        out[k] = -np.inf
    if n > 0 and m > 0 and not alike(xarcs, yarcs):
        for k in range(count):
            out[k] = partial_ratio(x, y, k, scores, sight)
        return
    total = 0.0
    for i in range(n):
        total += xw[i]
    for j in range(m):
        total += yw[j]
    plain(worth, half, gaps, yc, yw, scores[1], row, buffer, table)
    for k in range(count):
        out[k] = table[n, k] / (0.5 * total) if total > 0.0 else 0.0


@_inner
def inserted(leaders, value):
    """Put a value among the best so far, which ascend."""
    place = 0
    while place + 1 < len(leaders) and leaders[place + 1] < value:
        leaders[place] = leaders[place + 1]
        place += 1
    leaders[place] = max(leaders[place], value)


@_entry
def ratios(x, y, rows, bounds, keep, scores, best, by_rotation):
    """``best[t]`` = best normalised score of x with string ``rows[t]`` of y over all rotations,
    ``by_rotation[t]`` all of them where it has rows.

    ``bounds`` descend; once ``keep`` scores are above the next bound the rest is left as it was,
    since nothing there can be among the best ``keep``; 0 leaves out nothing.
    """
    work, sight = workspace(x, scores), sights(x, y, rows)
    out, leaders = np.zeros(max(len(x[0]), 1)), np.zeros(max(keep, 1))
    for place in range(len(leaders)):
        leaders[place] = -np.inf
    for t in range(len(rows)):
        if keep > 0 and bounds[t] < leaders[0]:
            return
        pair_ratios(x, string(y, rows[t]), scores, work, sight, out)
        best[t] = out[0]
        for k in range(len(out)):
            best[t] = max(best[t], out[k])
            if len(by_rotation):
                by_rotation[t, k] = out[k]
        inserted(leaders, best[t])


@_entry
def partners(x, y, rows, cuts, scores, out):
    """``out[t, j]`` = symbol of x matched for a gain with symbol j of string ``rows[t]`` of y when
    x is cut before its symbol ``cuts[t]``, else -1 (see linear.traceback)."""
    xc, xw, _, xarcs, _ = x
    seen_x, seen_y, pair, table = sights(x, y, rows)
    n = len(xc)
    for t in range(len(rows)):
        one = string(y, rows[t])
        m, k = len(one[0]), cuts[t]
        partial = n > 0 and m > 0 and not alike(xarcs, one[3])
        for i in range(n):
            seen_x[i] = 1.0
        for j in range(m):
            seen_y[j] = 1.0
        if partial:
            look(x, one, k, scores[2], seen_x, seen_y)
        align_one(x, one, k, scores, seen_x, seen_y, pair, table)
        i, j = n, m
        while i > 0 and j > 0:
            p = (i - 1 + k) % n
            skip_x = seen_x[i - 1] * on_grid(scores[1][xc[p]] * xw[p])
            if table[i, j] == table[i - 1, j - 1] + pair[i - 1, j - 1]:
                i, j = i - 1, j - 1
                if pair[i, j] > 0.0:
                    out[t, j] = p
            elif table[i, j] == table[i - 1, j] - skip_x:
                i -= 1
            else:
                j -= 1


@_inner
def side_bound(counts, best, other, gap, sigma, ranking):
    """Most that the symbols of one string can earn on one side (see bounds.upper_bounds)."""
    value = 0.0
    for c in range(len(counts)):
        if counts[c] == 0:
            continue
        rho = -gap[c]
        for z in ranking[c]:
            if other[z] > 0:
                rho = max(rho, 0.5 * sigma[c, z])
                break
        heavy = best[c, min(counts[c], other[c])]
        value += 0.5 * heavy + rho * (best[c, -1] - heavy)
    return value


@_entry
def upper_bounds(x_counts, x_best, y_counts, y_best, rows, gap, sigma, ranking, out):
    """``out[t]`` = most that the two strings can earn together."""
    for t in range(len(rows)):
        r = rows[t]
        out[t] = side_bound(x_counts, x_best, y_counts[r], gap, sigma, ranking) + side_bound(
            y_counts[r], y_best[r], x_counts, gap, sigma, ranking
        )
