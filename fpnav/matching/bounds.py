"""How well two cyclic strings can align at best, from their bags of symbols alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.coverage import alike
from fpnav.matching.strings import SCORE_GRID, Scores, Strings
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Bags:
    """Bags of symbols of B strings.

    ``counts`` (B, C); ``best`` (B, C, L + 1): weight of the k heaviest symbols of each code.
    """

    counts: NDArray[np.int64]
    best: FloatArray

    @property
    def totals(self) -> FloatArray:
        """Weight of each code, (B, C)."""
        return np.asarray(self.best[:, :, -1])


def bags(strings: Strings, scores: Scores) -> Bags:
    """Bags of a batch of strings."""
    size, codes = len(strings), len(scores.gap)
    owner = np.repeat(np.arange(size), strings.lengths)
    cell = owner * codes + strings.codes
    order = np.lexsort((-strings.weights, cell))
    counts = np.bincount(cell, minlength=size * codes)
    deepest = int(counts.max(initial=0))
    place = np.arange(len(cell)) - np.repeat(np.cumsum(counts) - counts, counts)
    sorted_weights = np.zeros((size * codes, deepest + 1))
    sorted_weights[cell[order], place + 1] = strings.weights[order]
    best = np.cumsum(sorted_weights, axis=1)
    return Bags(counts.reshape(size, codes), best.reshape(size, codes, deepest + 1))


def most(x: Bags, i: int, y: Bags, rows: NDArray[np.int64], scores: Scores) -> FloatArray:
    """Most that string i of x and each named string of y can earn together, (T,).

    Of each code the k = min(count) heaviest symbols of a string earn at most half their weight,
    every other one at most ``rho`` of it: half the best sigma with another code present in the
    other string, or the loss of a gap, whichever is more (systems.md 1.13, I-A1, whose rho holds
    for positive sigma only).
    """
    shared = np.minimum(x.counts[i][None, :], y.counts[rows])
    there = np.broadcast_to(x.counts[i], shared.shape)
    one = np.full(len(rows), i)
    return _side(x, one, shared, y.counts[rows], scores) + _side(y, rows, shared, there, scores)


def ratio_bounds(
    x: Strings, i: int, y: Strings, rows: NDArray[np.int64], earned: FloatArray
) -> FloatArray:
    """Upper bounds of normalised scores from those of scores, (T,).

    A little above them, by what rounding to the score grid can add; +inf where coverage excuses
    symbols, since weights then depend on the rotation.
    """
    total = 0.5 * (x.totals[i] + y.totals[rows])
    slack = SCORE_GRID * (x.lengths[i] + y.lengths[rows])
    out = np.where(total > 0.0, (earned + slack) / np.where(total > 0.0, total, 1.0), 0.0)
    return np.where(alike(x.arcs[i], y.arcs[rows]), out, np.inf)


def _side(
    of: Bags,
    rows: NDArray[np.int64],
    shared: NDArray[np.int64],
    other: NDArray[np.int64],
    scores: Scores,
) -> FloatArray:
    """Most that the symbols of one side can earn, (T,)."""
    sigma = np.where(np.eye(len(scores.gap), dtype=bool), -np.inf, scores.sigma)
    rho = np.where((other > 0)[:, None, :], 0.5 * sigma, -np.inf).max(axis=2)
    rho = np.maximum(rho, -scores.gap)
    heavy = np.take_along_axis(of.best[rows], shared[:, :, None], axis=2)[:, :, 0]
    return np.asarray((0.5 * heavy + rho * (of.totals[rows] - heavy)).sum(axis=1))
