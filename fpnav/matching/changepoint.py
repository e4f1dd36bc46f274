"""Where a stream of views changes: penalised segmentation by exact dynamic programming.

The cost of a segment is its scatter in the space of the similarity taken as a kernel: its length
less the mean of its similarities times its length (kernel change-point detection; Harchaoui and
Cappe 2007, Arlot, Celisse and Harchaoui 2019).
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

    Entry [i, d] compares i with i + d; 1 for d = 0, 0 past the end.
    """
    band = np.zeros((count, max(1, min(longest, count))))
    for i in range(count):
        band[i, 0] = 1.0
        for d in range(1, min(band.shape[1], count - i)):
            band[i, d] = similarity(i, i + d)
    return band


def segment_by_penalty(band: FloatArray, penalty: float, least: int = 1) -> NDArray[np.int64]:
    """First view of every segment of the segmentation of least cost plus penalty per segment.

    Parameters
    ----------
    band : (N, longest) as from ``similarity_band``; no segment is longer than its width
    penalty : what one more segment must save
    least : views in the shortest segment; the last may be shorter where nothing else fits

    Returns
    -------
    (S,) increasing, from 0; of equal segmentations the one with the longer last segments.
    """
    count = len(band)
    within = _row_sums(band)
    best = np.full(count + 1, np.inf)
    best[0] = -penalty
    start = np.zeros(count + 1, dtype=np.int64)
    for stop in range(1, count + 1):
        first, costs = _costs_ending(within, stop)
        total = best[first:stop] + costs + penalty
        total = _barred(total, first, stop, count, least)
        start[stop] = first + int(np.argmin(total))
        best[stop] = total.min()
    starts, stop = [], count
    while stop > 0:
        stop = int(start[stop])
        starts.append(stop)
    return np.array(starts[::-1], dtype=np.int64)


def segment_by_count(band: FloatArray, segments: int, least: int = 1) -> NDArray[np.int64]:
    """First view of every segment of the cheapest segmentation into so many.

    As few more as needed are made where segments as long as the band cannot cover the stream, as
    few less where ``least`` leaves no room.
    """
    count = len(band)
    within = _row_sums(band)
    most = max(1, min(segments, count // max(1, least)))
    fewest = -(-count // band.shape[1]) if count else 1
    rounds = max(most, fewest)
    best = np.full((rounds + 1, count + 1), np.inf)
    best[0, 0] = 0.0
    start = np.zeros((rounds + 1, count + 1), dtype=np.int64)
    for stop in range(1, count + 1):
        first, costs = _costs_ending(within, stop)
        costs = _barred(costs, first, stop, count, least)
        total = best[:-1, first:stop] + costs[None]
        start[1:, stop] = first + np.argmin(total, axis=1)
        best[1:, stop] = total.min(axis=1)
    possible = np.flatnonzero(np.isfinite(best[:, count]))
    used = int(possible[np.abs(possible - most).argmin()]) if count else 0
    starts, stop = [], count
    for segment in range(used, 0, -1):
        stop = int(start[segment, stop])
        starts.append(stop)
    return np.array(starts[::-1], dtype=np.int64)


def _row_sums(band: FloatArray) -> FloatArray:
    """[i, d]: similarity of i with itself plus twice that with i + 1 .. i + d."""
    return np.asarray(2.0 * np.cumsum(band, axis=1) - band[:, :1])


def _costs_ending(within: FloatArray, stop: int) -> tuple[int, FloatArray]:
    """Cost of every segment [s, stop), s from ``first``, by length no more than the band."""
    first = max(0, stop - within.shape[1])
    rows = np.arange(first, stop)
    sums = np.cumsum(within[rows, stop - 1 - rows][::-1])[::-1]
    length = stop - rows
    return first, np.asarray(length - sums / length)


def _barred(total: FloatArray, first: int, stop: int, count: int, least: int) -> FloatArray:
    """Costs with segments shorter than ``least`` ruled out, unless they end the stream."""
    length = stop - np.arange(first, stop)
    short = length < (least if stop < count else 1)
    return np.where(short, np.inf, total)
