"""Place fields along a line: how active each place is where, and what follows (B1-B4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import TruthError
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Metric

WINDOW = 11
"""Samples of the moving average that roughness is measured against."""

FIELD_SHARE = 0.25
"""Share of the peak at which a place field ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Fields:
    """Activity of places along a line.

    ``position_m`` (Q,) of the samples, ``activity`` (Q, P), ``learned_m`` (P,) where each place
    was learned, ascending.
    """

    position_m: FloatArray
    activity: FloatArray
    learned_m: FloatArray

    @property
    def active(self) -> NDArray[np.bool_]:
        """Samples at which any place is active, (Q,)."""
        return np.asarray((self.activity > 0.0).any(axis=1))

    @property
    def winner(self) -> NDArray[np.int64]:
        """Most active place of each sample, ties by order, (Q,)."""
        return np.asarray(np.argmax(self.activity, axis=1), dtype=np.int64)

    @property
    def nearest(self) -> NDArray[np.int64]:
        """Place learned nearest to each sample, (Q,)."""
        apart = np.abs(self.position_m[:, None] - self.learned_m[None, :])
        return np.asarray(np.argmin(apart, axis=1), dtype=np.int64)

    def between(self, low_m: float, high_m: float) -> Fields:
        """The samples within a stretch of the line."""
        inside = (self.position_m >= low_m) & (self.position_m <= high_m)
        return Fields(self.position_m[inside], self.activity[inside], self.learned_m)


def fields_of(result: Result) -> Fields:
    """Fields of a run that was located by matching on a map of places along a line.

    Positions are the truths of queries and of each place's first reference, measured along the
    line from the first to the last place.

    Raises
    ------
    TruthError
        Queries or references have no poses in truth.
    """
    queries, references = result.queries["truth"][:, :2], result.references["truth"][:, :2]
    if not (np.isfinite(queries).all() and np.isfinite(references).all()):
        raise TruthError("place fields need the true pose of every query and reference")
    places = np.unique(result.owner)
    first = references[[int(np.argmax(result.owner == place)) for place in places]]
    way = first[-1] - first[0]
    way = way / max(float(np.hypot(*way)), 1e-9)
    order = np.argsort(first @ way, kind="stable")
    column = np.full(int(places.max()) + 2, -1)
    column[places[order]] = np.arange(len(places))
    activity = np.zeros((len(queries), len(places)))
    rows, ranks = np.nonzero(np.isfinite(result.scores) & (result.places >= 0))
    activity[rows, column[result.places[rows, ranks]]] = result.scores[rows, ranks]
    along = queries @ way
    by_position = np.argsort(along, kind="stable")
    start = float(first[order[0]] @ way)
    return Fields(along[by_position] - start, activity[by_position], (first @ way)[order] - start)


def nearest_wins(fields: Fields) -> Metric:
    """Share of the samples with any activity at which the nearest place is the most active."""
    active = fields.active
    right = int((fields.winner == fields.nearest)[active].sum())
    return _share("nearest_wins", right, int(active.sum()))


def silent(fields: Fields) -> Metric:
    """Share of the samples at which no place is active."""
    return _share("silent_samples", int((~fields.active).sum()), len(fields.active))


def peak_error(fields: Fields) -> Metric:
    """Largest distance from where a place was learned to where it is most active."""
    peaks = fields.position_m[np.argmax(fields.activity, axis=0)]
    worst = float(np.max(np.abs(peaks - fields.learned_m)))
    return Metric("peak_error_m", worst, len(peaks), len(peaks), "m")


def widths(fields: Fields, share: float) -> FloatArray:
    """Width (P,) of the stretch about each peak where activity stays above a share of the peak."""
    return np.array([_width(fields, place, share) for place in range(len(fields.learned_m))])


def half_width(fields: Fields) -> float:
    """Mean width at half height, m."""
    return float(widths(fields, 0.5).mean())


def half_width_ratio(soft: Fields, strict: Fields) -> Metric:
    """Mean width at half height of the fields of one run over that of another."""
    ratio = half_width(soft) / max(half_width(strict), 1e-9)
    return Metric("half_width_ratio", ratio, len(soft.learned_m), len(soft.learned_m))


def roughness(fields: Fields) -> float:
    """RMS of activity about its moving average over WINDOW samples, all places together."""
    half = WINDOW // 2
    if len(fields.position_m) <= WINDOW:
        return math.nan
    weights = np.ones(WINDOW) / WINDOW
    rough = [
        column[half:-half] - np.convolve(column, weights, mode="valid")
        for column in fields.activity.T
    ]
    return float(np.sqrt(np.mean(np.square(rough))))


def roughness_ratio(smooth: Fields, rough: Fields) -> Metric:
    """Roughness of one run over that of another along the same line."""
    ratio = roughness(smooth) / max(roughness(rough), 1e-12)
    return Metric("roughness_ratio", ratio, len(smooth.position_m), len(smooth.position_m))


def learned_activity(fields: Fields) -> Metric:
    """Least activity of any place at the sample nearest to where it was learned."""
    at = np.argmin(np.abs(fields.position_m[:, None] - fields.learned_m[None, :]), axis=0)
    least = float(fields.activity[at, np.arange(len(at))].min())
    return Metric("learned_activity", least, len(at), len(at))


def field_slope(scales: FloatArray, diameters_m: FloatArray) -> Metric:
    """Slope of log diameter over log size of the world: 1 where fields grow with it."""
    slope = float(np.polyfit(np.log(scales), np.log(diameters_m), 1)[0])
    return Metric("field_slope", slope, len(scales), len(scales))


def occlusion(hidden: Fields, free: Fields, from_m: float) -> tuple[Metric, Metric]:
    """What is left of the peaks and of the winners once part of the view is hidden.

    Returns
    -------
    occlusion_peak_ratio : mean over the places learned beyond ``from_m`` of their peak there,
        hidden over free
    occlusion_winner : share of the samples beyond at which the winner is that without hiding
    """
    late = free.learned_m >= from_m
    beyond_hidden, beyond_free = hidden.between(from_m, np.inf), free.between(from_m, np.inf)
    peaks = beyond_hidden.activity.max(axis=0) / np.maximum(beyond_free.activity.max(axis=0), 1e-9)
    ratio = Metric("occlusion_peak_ratio", float(peaks[late].mean()), int(late.sum()), len(late))
    at = np.argmin(np.abs(beyond_hidden.position_m[:, None] - beyond_free.position_m), axis=1)
    same = beyond_hidden.active & (beyond_hidden.winner == beyond_free.winner[at])
    return ratio, _share("occlusion_winner", int(same.sum()), len(same))


def _share(name: str, n: int, of: int) -> Metric:
    return Metric(name, n / of if of else math.nan, n, of)


def _width(fields: Fields, place: int, share: float) -> float:
    """Width of one field, its ends interpolated between samples, cut at the ends of the line."""
    x, y = fields.position_m, fields.activity[:, place]
    peak = int(np.argmax(y))
    level = share * y[peak]
    if y[peak] <= 0.0:
        return 0.0
    low = high = peak
    while low > 0 and y[low - 1] >= level:
        low -= 1
    while high < len(y) - 1 and y[high + 1] >= level:
        high += 1
    left = x[low] if low == 0 else _crossing(x, y, low - 1, low, level)
    right = x[high] if high == len(y) - 1 else _crossing(x, y, high + 1, high, level)
    return float(right - left)


def _crossing(x: FloatArray, y: FloatArray, below: int, above: int, level: float) -> float:
    share = (level - y[below]) / (y[above] - y[below])
    return float(x[below] + share * (x[above] - x[below]))
