"""Cyclic alignment in numpy: every rotation of one string against others, exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.matching import linear
from fpnav.matching.bounds import most
from fpnav.matching.coverage import alike, comparable
from fpnav.matching.strings import Scores, Strings
from fpnav.values import FloatArray

BLOCK = 32

__all__ = ["best_ratios", "most", "partners", "rotation_ratios"]


def best_ratios(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    bounds: FloatArray,
    keep: int,
    scores: Scores,
) -> FloatArray:
    """Best normalised score of string i of x with each named string of y, over all rotations.

    ``bounds`` (T,) descend and are upper bounds of the answers; those that cannot be among the
    best ``keep`` stay -inf; 0 leaves out nothing.

    Returns
    -------
    (T,) in [-1, 1] for gap shares up to 1; 0 where neither string weighs anything.
    """
    out = np.full(len(rows), -np.inf)
    for start in range(0, len(rows), BLOCK):
        if 0 < keep <= start and bounds[start] < np.partition(out[:start], -keep)[-keep]:
            break
        block = slice(start, start + BLOCK)
        out[block] = rotation_ratios(x, i, y, rows[block], scores).max(axis=1)
    return out


def rotation_ratios(
    x: Strings, i: int, y: Strings, rows: NDArray[np.int64], scores: Scores
) -> FloatArray:
    """Normalised score of string i of x, cut before each symbol, with each named string of y.

    Returns
    -------
    (T, n), or (T, 1) where x is empty; -inf but for the first where both strings are fixed.
    """
    out = np.zeros((len(rows), max(int(x.lengths[i]), 1)))
    plain = alike(x.arcs[i], y.arcs[rows]) | (x.lengths[i] == 0) | (y.lengths[rows] == 0)
    if plain.any():
        out[plain] = _plain_ratios(x.take([i]), y.take(rows[plain]), scores)
    for at in np.flatnonzero(~plain):
        out[at] = _masked_ratios(x, i, y, int(rows[at]), scores)
    if x.fixed[i]:
        out[y.fixed[rows], 1:] = -np.inf
    return out


def partners(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    cuts: NDArray[np.int64],
    scores: Scores,
) -> NDArray[np.int64]:
    """Symbol of string i of x matched for a gain with each symbol of the named strings of y.

    Returns
    -------
    (T, M) positions in x when it is cut before symbol ``cuts[t]``; -1 where there is none.
    """
    out = np.full((len(rows), int(y.lengths[rows].max(initial=0))), -1, np.int64)
    for t, (row, cut) in enumerate(zip(rows, cuts, strict=True)):
        one = _partners(x, i, y, int(row), int(cut), scores)
        out[t, : len(one)] = one
    return out


def _plain_ratios(x: Strings, y: Strings, scores: Scores) -> FloatArray:
    """(B, n) of the one string of x with every string of y, nothing masked."""
    y_codes, y_weights, _, real = y.padded()
    halves = linear.pair_scores(x.codes, x.weights, y_codes, y_weights, scores)
    pair = np.where(real[:, None, :], halves, -np.inf).transpose(2, 0, 1)
    pair = np.ascontiguousarray(np.concatenate([pair, pair], axis=2))
    gaps_x = np.tile(linear.gap_costs(x.codes, x.weights, scores), 2)
    gaps_y = np.where(real, linear.gap_costs(y_codes, y_weights, scores), 0.0)
    count = len(x.codes)
    total = np.repeat(linear.cumulated(gaps_y.T)[..., None], max(count, 1), axis=2)
    row = -total
    for step in range(count):
        turned = slice(step, step + count)
        row = linear.next_row(row, pair[..., turned], gaps_x[turned], total)
    return _divided(row[-1], (0.5 * (x.totals[0] + y.totals))[:, None])


def _masked_ratios(x: Strings, i: int, y: Strings, j: int, scores: Scores) -> FloatArray:
    """(n,) of one pair where a field of view is partial."""
    cx, wx, cy, wy = *_symbols(x, i), *_symbols(y, j)
    seen_x, seen_y = comparable(x, i, y, j, scores)
    count = len(cx)
    turned = (np.arange(count)[:, None] + np.arange(count)[None, :]) % count
    weights_x, weights_y = np.take_along_axis(wx * seen_x, turned, axis=1), wy * seen_y
    pair = linear.pair_scores(cx[turned], weights_x, cy[None, :], weights_y, scores)
    pair = np.ascontiguousarray(pair.transpose(1, 2, 0))
    gaps_x = linear.gap_costs(cx[turned], weights_x, scores).T
    total = linear.cumulated(linear.gap_costs(cy[None, :], weights_y, scores).T)
    row = -total
    for step in range(count):
        row = linear.next_row(row, pair[step], gaps_x[step], total)
    return _divided(row[-1], 0.5 * (weights_x.sum(axis=1) + weights_y.sum(axis=1)))


def _partners(
    x: Strings, i: int, y: Strings, j: int, cut: int, scores: Scores
) -> NDArray[np.int64]:
    cx, wx, cy, wy = *_symbols(x, i), *_symbols(y, j)
    if len(cx) and len(cy) and not alike(x.arcs[i], y.arcs[j]):
        seen_x, seen_y = comparable(x, i, y, j, scores)
        wx, wy = wx * seen_x[cut], wy * seen_y[cut]
    turned = np.roll(np.arange(len(cx)), -cut)
    pair = linear.pair_scores(cx[turned], wx[turned], cy, wy, scores)
    gaps_x = linear.gap_costs(cx[turned], wx[turned], scores)
    gaps_y = linear.gap_costs(cy, wy, scores)
    found = linear.traceback(linear.table(pair, gaps_x, gaps_y), pair, gaps_x)
    gained = np.flatnonzero(found >= 0)
    gained = gained[pair[found[gained], gained] > 0.0]
    out = np.full(len(cy), -1, np.int64)
    out[gained] = turned[found[gained]]
    return out


def _symbols(strings: Strings, i: int) -> tuple[NDArray[np.uint8], FloatArray]:
    where = slice(strings.offsets[i], strings.offsets[i + 1])
    return strings.codes[where], strings.weights[where]


def _divided(values: FloatArray, total: FloatArray) -> FloatArray:
    return np.asarray(np.where(total > 0.0, values / np.where(total > 0.0, total, 1.0), 0.0))
