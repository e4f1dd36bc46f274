"""95 % intervals by moving-block bootstrap: neighbouring queries are not independent.

Every figure of a run is resampled alike (one seed), so that figures of results with the same
queries may be compared draw by draw.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

BLOCK = 10
DRAWS = 1000
_SEED = 20_240_501
_CELLS = 2_000_000

Statistic = Callable[[FloatArray], FloatArray]
"""Weights (B, N), how often each unit was drawn, to the figure of each draw (B,)."""


def interval(statistic: Statistic, units: int, block: int = BLOCK) -> tuple[float, float]:
    """The 2.5 and 97.5 % quantiles of a figure over resampled runs (Kuensch 1989).

    Blocks of ``block`` consecutive units are drawn with replacement from every start and cut to
    the length of the run. NaN where there are fewer than two blocks, or no draw has a figure.
    """

    def single(weights: FloatArray) -> FloatArray:
        return statistic(weights)[None, :]

    return joint_intervals(single, 1, units, block)[0]


def joint_intervals(
    statistic: Statistic, figures: int, units: int, block: int = BLOCK
) -> list[tuple[float, float]]:
    """The same for a statistic that gives several figures at once, (figures, B)."""
    if units < 2 * block:
        return [(np.nan, np.nan)] * figures
    draws = np.concatenate([statistic(weights) for weights in _resampled(units, block)], axis=1)
    return [_quantiles(values[np.isfinite(values)]) for values in draws]


def _quantiles(values: FloatArray) -> tuple[float, float]:
    if not len(values):
        return np.nan, np.nan
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


def _resampled(units: int, block: int) -> Iterator[FloatArray]:
    """Weights of DRAWS resampled runs, in slices small enough to hold."""
    random = np.random.default_rng(_SEED)
    blocks = -(-units // block)
    starts = random.integers(units - block + 1, size=(DRAWS, blocks))
    rows = max(1, _CELLS // units)
    for first in range(0, DRAWS, rows):
        yield _weights(starts[first : first + rows], units, block)


def _weights(starts: NDArray[np.int64], units: int, block: int) -> FloatArray:
    """How often each unit is covered: +1 at every start, -1 behind every end, summed up."""
    width = units + 1
    ends = starts + block
    ends[:, -1] -= starts.shape[1] * block - units
    row = np.arange(len(starts))[:, None] * width
    size = len(starts) * width
    edges = np.bincount((row + starts).ravel(), minlength=size).astype(np.float64)
    edges -= np.bincount((row + ends).ravel(), minlength=size)
    return np.asarray(np.cumsum(edges.reshape(len(starts), width), axis=1)[:, :-1])


def ratio(numerator: NDArray[np.generic], denominator: NDArray[np.generic]) -> Statistic:
    """Statistic: sum of one per-unit quantity over sum of another; NaN over zero."""
    top = np.asarray(numerator, dtype=np.float64)
    bottom = np.asarray(denominator, dtype=np.float64)

    def of(weights: FloatArray) -> FloatArray:
        below = (weights * bottom).sum(axis=1)
        above = (weights * top).sum(axis=1)
        out = np.full(len(weights), np.nan)
        np.divide(above, below, out=out, where=below > 0)
        return out

    return of


def median(values: FloatArray, used: NDArray[np.bool_]) -> Statistic:
    """Statistic: median of the units in use, each counted as often as it was drawn."""
    rows = np.flatnonzero(used)
    order = rows[np.argsort(values[rows], kind="stable")]
    ordered = values[order]

    def of(weights: FloatArray) -> FloatArray:
        reached = np.cumsum(weights[:, order], axis=1)
        total = reached[:, -1] if len(order) else np.zeros(len(weights))
        out = np.full(len(weights), np.nan)
        for draw in np.flatnonzero(total > 0):
            low = np.searchsorted(reached[draw], (total[draw] - 1) // 2, side="right")
            high = np.searchsorted(reached[draw], total[draw] // 2, side="right")
            out[draw] = 0.5 * (ordered[low] + ordered[high])
        return out

    return of
