"""Alignment that minds angles: a second pass once the turn is known (systems.md 1.13, I-A5).

The first pass tries every rotation by order alone and gives the turn; in the second, a match costs
the more the further it is off after that turn, so that views alike in order only come apart. With
the turn fixed the scores depend on the two symbols alone, which the recurrence needs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.matching import cyclic, linear
from fpnav.matching.coverage import alike, comparable
from fpnav.matching.strings import SCORE_GRID, Scores, Strings, on_grid
from fpnav.values import FloatArray


def angled_ratios(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    scores: Scores,
    silent: NDArray[np.bool_],
    width_rad: float,
) -> FloatArray:
    """Normalised scores of string i of x with each named string of y, angles minded.

    A pair that is off by d after the turn loses ``2 (1 - cos d) / width^2`` of its weight, which is
    ``(d / width)^2`` for small d; it never loses more than leaving both out would cost twice over.
    Where no feature tells the turn the first pass stands.

    Returns
    -------
    (T,) in [-1, 1] for gap shares up to 1.
    """
    if len(rows) == 0 or x.lengths[i] == 0:
        return cyclic.best_ratios(x, i, y, rows, scores)
    found = cyclic.align(x, i, y, rows, scores, silent)
    start, count = int(x.offsets[i]), int(x.lengths[i])
    at = start + (found.cuts[:, None] + np.arange(count)[None, :]) % count
    others = y.take(rows)
    codes, weights_y, angles_y, real = others.padded()
    weights_x, weights_y = _seen(x, i, others, found.cuts, x.weights[at], weights_y, scores)
    off = angles_y[:, None, :] - x.angles_rad[at][:, :, None] - found.psi_rad[:, None, None]
    weight = 0.5 * (weights_x[:, :, None] + weights_y[:, None, :])
    pair = linear.pair_scores(x.codes[at], weights_x, codes, weights_y, scores)
    pair = on_grid(np.maximum(pair - weight * 2.0 * (1.0 - np.cos(off)) / width_rad**2,
                              -2.0 * weight), SCORE_GRID)  # fmt: skip
    pair = np.where(real[:, None, :], pair, -np.inf)
    gaps_x = linear.gap_costs(x.codes[at], weights_x, scores)
    gaps_y = np.where(real, linear.gap_costs(codes, weights_y, scores), 0.0)
    total = 0.5 * (weights_x.sum(axis=1) + weights_y.sum(axis=1))
    values = _aligned(pair, gaps_x, gaps_y) / np.where(total > 0.0, total, 1.0)
    known = np.isfinite(found.psi_rad) & (total > 0.0)
    return np.where(known, values, found.ratios)


def _aligned(pair: FloatArray, gaps_x: FloatArray, gaps_y: FloatArray) -> FloatArray:
    """Scores of T linear alignments from pair scores (T, n, m) and gap costs (T, n), (T, m)."""
    lanes = np.ascontiguousarray(pair.transpose(1, 2, 0))
    total = linear.cumulated(gaps_y.T)
    row = -total
    for step in range(lanes.shape[0]):
        row = linear.next_row(row, lanes[step], gaps_x[:, step], total)
    return np.asarray(row[-1])


def _seen(
    x: Strings,
    i: int,
    y: Strings,
    cuts: NDArray[np.int64],
    weights_x: FloatArray,
    weights_y: FloatArray,
    scores: Scores,
) -> tuple[FloatArray, FloatArray]:
    """Weights (T, n), (T, m) under each cut, nought where the other's sensors saw nothing."""
    weights_x, weights_y = weights_x.copy(), weights_y.copy()
    count = weights_x.shape[1]
    partial = ~alike(x.arcs[i], y.arcs) & (y.lengths > 0)
    for t in np.flatnonzero(partial):
        seen_x, seen_y = comparable(x, i, y, int(t), scores)
        weights_x[t] *= seen_x[cuts[t], (cuts[t] + np.arange(count)) % count]
        weights_y[t, : y.lengths[t]] *= seen_y[cuts[t]]
    return weights_x, weights_y
