# mypy: disable-error-code="no-untyped-def"
"""Scene matching compiled by numba; the columns are those of scenes.Scenes."""

from __future__ import annotations

import numba
import numpy as np

FACING, DIRECTION, COLUMN, CELLS, CLASS = range(5)
X, TOP, BOTTOM, DISTANCE, STRENGTH, WEIGHT = range(6)
FAR, UNKNOWN = 3, 4
FACINGS, CELL_COUNT = 8, 25
MIDDLE_PX = 240.0
LOG_DISTANCE = 0.7
"""Two distances a factor of two apart count for nothing."""

_jit = numba.njit(cache=True, nogil=True)


@_jit
def compatible(a, b, first_m, second_m, share):
    """Whether two distances, of classes a and b, may be of one thing: within a share of the larger;
    the unknown may be far or unknown."""
    if a == UNKNOWN or b == UNKNOWN:
        return min(a, b) >= FAR
    return abs(first_m - second_m) <= share * max(first_m, second_m)


@_jit
def by_features(whole, real, t0, t1, stored_whole, stored_real, s0, s1, looked, share):
    """Share of the stored cues that a cue of their own matches: the nearest not yet used."""
    used = np.zeros(t1 - t0, np.bool_)
    total, matched = 0, 0
    for s in range(s0, s1):
        if not looked >> stored_whole[s, FACING] & 1:
            continue
        total += 1
        best, nearest = -1, np.inf
        for t in range(t0, t1):
            if used[t - t0] or whole[t, FACING] != stored_whole[s, FACING]:
                continue
            if whole[t, DIRECTION] != stored_whole[s, DIRECTION]:
                continue
            if abs(whole[t, COLUMN] - stored_whole[s, COLUMN]) > 1:
                continue
            away = abs(real[t, X] - stored_real[s, X])
            if away < nearest and compatible(
                whole[t, CLASS], stored_whole[s, CLASS],
                np.float32(real[t, DISTANCE]), np.float32(stored_real[s, DISTANCE]), share,
            ):  # fmt: skip
                best, nearest = t, away
        if best >= 0:
            used[best - t0] = True
            matched += 1
    return matched / total if total else 0.0


@_jit
def holders(whole, real, r0, r1, out):
    """The strongest cue of every cell, by facing and cell, out (FACINGS, CELL_COUNT); -1 none."""
    out[:] = -1
    for r in range(r0, r1):
        for cell in range(CELL_COUNT):
            if not whole[r, CELLS] >> cell & 1:
                continue
            held = out[whole[r, FACING], cell]
            if held < 0 or real[r, STRENGTH] > real[held, STRENGTH]:
                out[whole[r, FACING], cell] = r


@_jit
def by_cells(whole, real, shown, stored_whole, stored_real, kept, looked, method, share):
    """Share of the occupied stored cells whose like holds a cue that fits."""
    total, matched = 0, 0
    for facing in range(FACINGS):
        if not looked >> facing & 1:
            continue
        for cell in range(CELL_COUNT):
            s, t = kept[facing, cell], shown[facing, cell]
            if s < 0:
                continue
            total += 1
            if t < 0:
                continue
            if method < 4 and whole[t, DIRECTION] != stored_whole[s, DIRECTION]:
                continue
            if method == 2 and not compatible(
                whole[t, CLASS], stored_whole[s, CLASS],
                np.float32(real[t, DISTANCE]), np.float32(stored_real[s, DISTANCE]), share,
            ):  # fmt: skip
                continue
            matched += 1
    return matched / total if total else 0.0


@_jit
def hard(present, stored, method, share, out):
    """Scores (Q, N) by one of the paper's algorithms."""
    whole, real, offsets, facings = present
    stored_whole, stored_real, stored_offsets, _ = stored
    kept = np.zeros((out.shape[1], FACINGS, CELL_COUNT), np.int64)
    for n in range(out.shape[1]):
        holders(stored_whole, stored_real, stored_offsets[n], stored_offsets[n + 1], kept[n])
    shown = np.zeros((FACINGS, CELL_COUNT), np.int64)
    for q in range(out.shape[0]):
        t0, t1, looked = offsets[q], offsets[q + 1], facings[q]
        holders(whole, real, t0, t1, shown)
        for n in range(out.shape[1]):
            s0, s1 = stored_offsets[n], stored_offsets[n + 1]
            if method == 1:
                out[q, n] = by_features(
                    whole, real, t0, t1, stored_whole, stored_real, s0, s1, looked, share
                )
            else:
                out[q, n] = by_cells(
                    whole, real, shown, stored_whole, stored_real, kept[n], looked, method, share
                )


@_jit
def likeness(whole, real, t, stored_whole, stored_real, s, unknown):
    """How alike two cues are but for where they stand across, in [0, 1]."""
    if whole[t, FACING] != stored_whole[s, FACING]:
        return 0.0
    if whole[t, DIRECTION] != stored_whole[s, DIRECTION]:
        return 0.0
    top = max(real[t, TOP], stored_real[s, TOP])
    bottom = min(real[t, BOTTOM], stored_real[s, BOTTOM])
    if bottom < top:
        return 0.0
    reach = max(real[t, BOTTOM], stored_real[s, BOTTOM]) - min(real[t, TOP], stored_real[s, TOP])
    tall = np.sqrt((bottom - top + 1.0) / (reach + 1.0))
    if whole[t, CLASS] == UNKNOWN or stored_whole[s, CLASS] == UNKNOWN:
        return tall * unknown
    apart = abs(np.log(real[t, DISTANCE] / stored_real[s, DISTANCE]))
    return tall * max(0.0, 1.0 - apart / LOG_DISTANCE)


@_jit
def aligned(alike, real, t0, stored_real, s0, shift, scale, width, total, beta, looked):
    """F measure of the best partners at one shift and scale; ``looked`` marks the stored cues."""
    stored, shown = 0.0, 0.0
    n, m = alike.shape
    taken = np.zeros(n)
    for s in range(m):
        best = 0.0
        for t in range(n):
            if alike[t, s] == 0.0:
                continue
            x = MIDDLE_PX + scale * (real[t0 + t, X] - MIDDLE_PX) + shift
            worth = alike[t, s] * (1.0 - abs(x - stored_real[s0 + s, X]) / width)
            best, taken[t] = max(best, worth), max(taken[t], worth)
        if looked[s]:
            stored += stored_real[s0 + s, WEIGHT] * best
    for t in range(n):
        shown += taken[t]
    recall, precision = stored / total, shown / n
    below = beta * beta * precision + recall
    return (1.0 + beta * beta) * precision * recall / below if below > 0.0 else 0.0


@_jit
def soft(present, stored, shifts, scales, cost, rule, out):
    """Scores (Q, N) by the fifth algorithm; ``rule`` : width, worth of the unknown, beta."""
    whole, real, offsets, facings = present
    stored_whole, stored_real, stored_offsets, _ = stored
    for q in range(out.shape[0]):
        t0, t1 = offsets[q], offsets[q + 1]
        for n in range(out.shape[1]):
            s0, s1 = stored_offsets[n], stored_offsets[n + 1]
            alike, looked = np.zeros((t1 - t0, s1 - s0)), np.zeros(s1 - s0, np.bool_)
            total = 0.0
            for s in range(s0, s1):
                looked[s - s0] = facings[q] >> stored_whole[s, FACING] & 1
                total += stored_real[s, WEIGHT] * looked[s - s0]
                for t in range(t0, t1):
                    alike[t - t0, s - s0] = likeness(
                        whole, real, t, stored_whole, stored_real, s, rule[1]
                    )
            if total <= 0.0 or t1 == t0:
                continue
            for i in range(len(shifts)):
                for k in range(len(scales)):
                    value = cost[i, k] * aligned(
                        alike, real, t0, stored_real, s0, shifts[i], scales[k], rule[0], total,
                        rule[2], looked,
                    )  # fmt: skip
                    out[q, n] = max(out[q, n], value)
