"""The compiled kernels behind the same functions as rotations.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching import kernels
from fpnav.matching.bounds import Bags
from fpnav.matching.strings import Scores, Strings
from fpnav.values import FloatArray


def fits(x: Strings, i: int, y: Strings, scores: Scores) -> bool:
    """Whether the kernels can take string i of x: not too long, all sums exact in float32."""
    largest = float(x.totals[i] + y.totals.max(initial=0.0)) * max(1.0, float(scores.gap.max()))
    return int(x.lengths[i]) <= kernels.LANES_MAX and largest <= kernels.EXACT_SUM


def most(x: Bags, i: int, y: Bags, rows: NDArray[np.int64], scores: Scores) -> FloatArray:
    """See bounds.most."""
    out = np.empty(len(rows))
    other = np.where(np.eye(len(scores.gap), dtype=bool), -np.inf, scores.sigma)
    ranking = np.argsort(-other, axis=1, kind="stable")[:, :-1]
    kernels.upper_bounds(
        x.counts[i], x.best[i], y.counts, y.best, rows, scores.gap, scores.sigma, ranking, out
    )
    return out


def best_ratios(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    bounds: FloatArray,
    keep: int,
    scores: Scores,
) -> FloatArray:
    """See rotations.best_ratios."""
    out = np.full(len(rows), -np.inf)
    none = np.zeros((0, max(int(x.lengths[i]), 1)))
    kernels.ratios(_one(x, i), _many(y), rows, bounds, keep, _tables(scores), out, none)
    return out


def rotation_ratios(
    x: Strings, i: int, y: Strings, rows: NDArray[np.int64], scores: Scores
) -> FloatArray:
    """See rotations.rotation_ratios."""
    out = np.zeros((len(rows), max(int(x.lengths[i]), 1)))
    best, bounds = np.zeros(len(rows)), np.zeros(len(rows))
    kernels.ratios(_one(x, i), _many(y), rows, bounds, 0, _tables(scores), best, out)
    return out


def partners(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    cuts: NDArray[np.int64],
    scores: Scores,
) -> NDArray[np.int64]:
    """See rotations.partners."""
    out = np.full((len(rows), int(y.lengths[rows].max(initial=0))), -1, np.int64)
    kernels.partners(_one(x, i), _many(y), rows, cuts, _tables(scores), out)
    return out


def _one(strings: Strings, i: int) -> tuple[Any, ...]:
    where = slice(strings.offsets[i], strings.offsets[i + 1])
    return (
        strings.codes[where],
        strings.weights[where],
        strings.angles_rad[where],
        strings.arcs[i],
        bool(strings.fixed[i]),
    )


def _many(strings: Strings) -> tuple[Any, ...]:
    return (
        strings.codes,
        strings.weights,
        strings.angles_rad,
        strings.offsets,
        strings.arcs,
        strings.fixed,
    )


def _tables(scores: Scores) -> tuple[Any, ...]:
    return scores.sigma, scores.gap, scores.visible
