"""Where a stream of views changes: penalised segmentation by exact dynamic programming.

Views of a stream grow unlike with the distance between them, change or no change. What tells a
change is that the views just before and just after a border are less alike than views of the
stream that far apart usually are. The cost of a segmentation is a penalty for each border less
what is gained there; the cheapest one is found exactly.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray


def similarity_band(
    count: int, longest: int, similarity: Callable[[int, int], float]
) -> FloatArray:
    """Similarities of each view with those that follow it, (count, longest).

    Entry [i, d] compares i with i + d; 1 for d = 0, NaN past the end.
    """
    band = np.full((count, max(1, longest)), np.nan)
    for i in range(count):
        band[i, 0] = 1.0
        for d in range(1, min(band.shape[1], count - i)):
            band[i, d] = similarity(i, i + d)
    return band


def contrast(band: FloatArray) -> FloatArray:
    """How much less alike the views on the two sides of each border are than usual, (N,).

    Entry t is the mean over all pairs i < t <= i + d of ``band`` (N, W + 1) of the usual
    similarity of views d apart, the mean of the stream, less theirs. 0 for the first view, before
    which there is nothing.
    """
    count, width = band.shape
    seen = np.isfinite(band)
    usual = np.where(seen, band, 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    less = np.where(seen, usual - band, 0.0)
    total, pairs = np.zeros(count + 1), np.zeros(count + 1)
    for d in range(1, width):
        for back in range(d):  # the border stands ``back + 1`` views after the first of the pair
            stop = count - back - 1
            total[back + 1 : count] += less[:stop, d]
            pairs[back + 1 : count] += seen[:stop, d]
    return np.asarray((total / np.maximum(pairs, 1.0))[:count])


def segment_by_contrast(gains: FloatArray, penalty: float, least: int) -> NDArray[np.int64]:
    """First view of every segment: the borders whose gain less the penalty adds up to most.

    Parameters
    ----------
    gains : (N,) as from ``contrast``
    penalty : what a border must gain at least
    least : views in the shortest segment but the last

    Returns
    -------
    (S,) increasing, from 0; of equal segmentations the one with fewer and earlier borders.
    """
    count, least = len(gains), max(1, least)
    if count == 0:
        return np.zeros(0, dtype=np.int64)
    best = np.zeros(count)  # most gained by borders up to each view
    taken = np.zeros(count, dtype=bool)
    for t in range(1, count):
        best[t] = best[t - 1]
        if t < least:
            continue
        with_border = best[t - least] + gains[t] - penalty
        if with_border > best[t] + 1e-12:
            best[t], taken[t] = with_border, True
    borders, t = [], count - 1
    while t > 0:
        if taken[t]:
            borders.append(t)
            t -= least
        else:
            t -= 1
    return np.array([0, *borders[::-1]], dtype=np.int64)
