"""Gateways found against those a route meets, and places told by scene and gateway (C1 to C6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import angular_distance, wrap_array
from fpnav.matching.scenes import unique_best
from fpnav.values import FloatArray, Metric

NEAR_M = 1.0
SAME_RAD = np.pi / 4.0
"""A gateway found farther than this from one of truth, or along another way, is another."""

POSITION_M = 0.07
HEADING_RAD = np.deg2rad(3.5)
"""What the paper's robot stopped within."""


SPREAD = 0.025
"""How well a robot without odometry repeats a lap, as a share of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Gateways:
    """Gateways in travel order.

    ``poses`` (N, 3) : centre (metres) and direction of travel (rad) in the frame of truth;
    ``types``, ``names`` (N,) : a name may be empty
    """

    poses: FloatArray
    types: tuple[str, ...]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.types)


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """What was found beside what there is.

    ``partner`` (F,) : the gateway of truth each found one is, -1 none
    ``along_m``, ``turned_rad`` (F,) : errors along the way and of its direction, NaN without
    """

    truth: Gateways
    found: Gateways
    partner: NDArray[np.int64]
    along_m: FloatArray
    turned_rad: FloatArray


def gateways_met(world: Mapping[str, Any], route: str) -> Gateways:
    """The gateways a route meets, from a log's ``world.json``."""
    met = [one for one in world["gateways"] if one["route"] == route]
    poses = [(one["x_m"], one["y_m"], one["axis_rad"]) for one in met]
    return Gateways(
        np.array(poses, dtype=np.float64).reshape(-1, 3),
        tuple(str(one["type"]) for one in met),
        tuple(str(one["name"]) for one in met),
    )


def surveyed(found: Gateways, truth: Gateways) -> Survey:
    """Found gateways paired with those of truth one to one, the nearest first."""
    apart = np.hypot(*(found.poses[:, None, :2] - truth.poses[None, :, :2]).transpose(2, 0, 1))
    turned = angular_distance(found.poses[:, None, 2], truth.poses[None, :, 2])
    apart = np.where((apart <= NEAR_M) & (turned <= SAME_RAD), apart, np.inf)
    partner = np.full(len(found), -1, dtype=np.int64)
    taken = np.zeros(len(truth), dtype=bool)
    rows, columns = np.nonzero(np.isfinite(apart))
    for at in np.lexsort((columns, rows, apart[rows, columns])):
        if partner[rows[at]] < 0 and not taken[columns[at]]:
            partner[rows[at]], taken[columns[at]] = columns[at], True
    there = np.vstack([truth.poses, np.full((1, 3), np.nan)])[partner]
    off = found.poses - there
    along = off[:, 0] * np.cos(there[:, 2]) + off[:, 1] * np.sin(there[:, 2])
    return Survey(truth, found, partner, along, wrap_array(off[:, 2]))


def gateway_found(surveys: Sequence[Survey]) -> Metric:
    """Share of the gateways met that were found."""
    n = sum(int((survey.partner >= 0).sum()) for survey in surveys)
    return rate("gateway_found", n, sum(len(survey.truth) for survey in surveys))


def gateway_invented(surveys: Sequence[Survey]) -> Metric:
    """Share of the gateways reported that are none."""
    n = sum(int((survey.partner < 0).sum()) for survey in surveys)
    return rate("gateway_invented", n, sum(len(survey.found) for survey in surveys))


def gateway_within_70mm(surveys: Sequence[Survey]) -> Metric:
    """Share of those found whose centre is right to 70 mm along the way."""
    off = np.abs(errors_m(surveys))
    return rate("gateway_within_70mm", int((off <= POSITION_M).sum()), len(off))


def gateway_within_3_5deg(surveys: Sequence[Survey]) -> Metric:
    """Share of those found whose direction is right to 3.5 degrees."""
    off = np.abs(errors_rad(surveys))
    return rate("gateway_within_3_5deg", int((off <= HEADING_RAD).sum()), len(off))


def gateway_type_accuracy(surveys: Sequence[Survey]) -> Metric:
    """Share of those found that were classified right."""
    pairs = [pair for survey in surveys for pair in typed(survey)]
    return rate("gateway_type_accuracy", sum(a == b for a, b in pairs), len(pairs))


def errors_m(surveys: Sequence[Survey]) -> FloatArray:
    """Errors along the way of all found."""
    return np.concatenate([np.zeros(0), *(s.along_m[s.partner >= 0] for s in surveys)])


def errors_rad(surveys: Sequence[Survey]) -> FloatArray:
    """Errors of direction of all found."""
    return np.concatenate([np.zeros(0), *(s.turned_rad[s.partner >= 0] for s in surveys)])


def typed(survey: Survey) -> list[tuple[str, str]]:
    """True type and type classified of every gateway found."""
    return [
        (survey.truth.types[partner], survey.found.types[row])
        for row, partner in enumerate(survey.partner.tolist())
        if partner >= 0
    ]


def confusion(surveys: Sequence[Survey], types: Sequence[str]) -> NDArray[np.int64]:
    """How often each type (row) was classified as each (column); the last column counts those
    not found or classified as none of them, (T, T + 1)."""
    index = {name: number for number, name in enumerate(types)}
    table = np.zeros((len(types), len(types) + 1), dtype=np.int64)
    for survey in surveys:
        for true, told in typed(survey):
            table[index[true], index.get(told, len(types))] += 1
        missed = set(range(len(survey.truth))) - set(survey.partner.tolist())
        for row in missed:
            table[index[survey.truth.types[row]], len(types)] += 1
    return table


def told_apart(name: str, likelihood: FloatArray, own: NDArray[np.int64]) -> Metric:
    """Share of the queries (Q,) whose own place alone is the most likely; a tie is no answer.

    ``likelihood`` : (Q, P), any scale that is not negative; ``own`` : (Q,) columns
    """
    right = unique_best(likelihood) == own
    return rate(name, int(right.sum()), len(own))


def least_margin(name: str, likelihood: FloatArray, own: NDArray[np.int64]) -> Metric:
    """Least ratio over the queries of the likelihood of the own place to that of the best other."""
    rows = np.arange(len(own))
    others = likelihood.copy()
    others[rows, own] = 0.0
    ratio = likelihood[rows, own] / np.maximum(others.max(axis=1), 1e-12)
    return Metric(name, float(np.minimum(ratio, 1e3).min()), len(own), len(own), "times")


def error_corrected(posterior: FloatArray, own: int) -> Metric:
    """Whether a place whose gateway was misread is the most likely one (posterior (P,))."""
    return told_apart("error_corrected", posterior[None, :], np.array([own]))


def lap_period(at: FloatArray, likeness: FloatArray, least: float) -> float:
    """Period at which like gateways come again, in the unit of ``at``; NaN of fewer than two.

    Every pair of gateways speaks for the lag between them, as much as the two are alike, spread
    normally by SPREAD of the lag; the lag for which most is said, allowing for how many pairs so
    far apart there can be.

    Parameters
    ----------
    at : (N,) where or when each gateway was met, increasing
    likeness : (N, N) in [0, 1]
    least : no lap is shorter
    """
    rows, columns = np.triu_indices(len(at), 1)
    lags, weights = at[columns] - at[rows], likeness[rows, columns]
    if len(at) < 2 or lags.max() <= least:
        return float("nan")
    tried = np.arange(least, 0.6 * lags.max(), 0.001 * lags.max())
    away = (lags[None, :] - tried[:, None]) / (SPREAD * tried[:, None])
    said = (weights * np.exp(-0.5 * away**2)).sum(axis=1) / (1.0 - tried / lags.max())
    return float(tried[np.argmax(said / tried)]) if len(tried) else float("nan")


def rate(name: str, n: int, of: int) -> Metric:
    """A share with its counts, NaN of nothing."""
    return Metric(name, n / of if of else float("nan"), n, of)
