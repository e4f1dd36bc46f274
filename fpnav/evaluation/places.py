"""Metrics of localization on a map of places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import NO_POSES, Absent, Measure, map_missing, middle, share
from fpnav.geometry import path_length
from fpnav.values import FloatArray, Metric

MISSIONS = 20
SETTLED = 20
MISSION_QUERIES = 50
RECOVERED_M = 3.0
JUMP_M = 2.0
"""A step of the truth longer than this, and than five usual steps, is a kidnapping."""


def place_accuracy(top: int, *, tolerant: bool = False, skip: int = 0) -> Measure:
    """Share of queries whose true place is among the first ``top`` of the ranking.

    Of the queries that stand in a place; ``skip`` leaves out the first queries of the run, in
    which a belief cannot have settled. ``tolerant``: a graph neighbour of the true place counts
    while the query is within 0.5 m of their border.
    """

    def measure(name: str, case: Case) -> Metric | Absent:
        if missing := map_missing(case):
            return missing
        among = case.has_match & (np.arange(len(case.judged)) >= skip)
        if not among.any():
            return Absent("no query stands in a place of the map")
        answers = case.result.places[:, :top]
        return share(name, case.within(answers, tolerant=tolerant), among)

    return measure


def mission_success(*, tolerant: bool = False) -> Measure:
    """Share of missions that end in the right place with every decision on the way right.

    A mission is a stretch of the run, equally many queries each, at least twenty a run; its end is
    the last query that stands in a place, judged by the best answer (systems.md 1.9.2).
    """

    def measure(name: str, case: Case) -> Metric | Absent:
        if missing := map_missing(case):
            return missing
        queries = np.flatnonzero(case.has_match)
        if len(queries) < MISSIONS:
            return Absent(f"{len(queries)} queries stand in a place, 20 missions need 20")
        missions = np.array_split(queries, max(MISSIONS, len(queries) // MISSION_QUERIES))
        best = case.within(case.result.places[:, :1], tolerant=tolerant)
        decision = case.within(case.result.decision[:, None], tolerant=tolerant)
        fine = decision | ~case.decided
        succeeded = np.array([bool(best[rows[-1]] and fine[rows].all()) for rows in missions])
        return share(name, succeeded, np.ones(len(missions), bool), block=1)

    return measure


def kidnap_recovery(name: str, case: Case) -> Metric | Absent:
    """Median metres of travel from a kidnapping to the first right decision after it.

    A kidnapping is a jump of the truth, or the start of another log. ``n`` of ``of``: those
    recovered from before the next one; the median is over these.
    """
    if missing := map_missing(case):
        return missing
    truth = case.result.queries["truth"]
    if np.isnan(truth[:, 0]).all():
        return NO_POSES
    metres = _case_recoveries(case)
    if not len(metres):
        return Absent("nobody is kidnapped in this run")
    if np.isnan(metres).all():
        return Absent(f"no kidnapping of {len(metres)} was recovered from")
    return middle(name, metres, np.ones(len(metres), bool), "m", block=1)


def kidnap_recovered(name: str, case: Case) -> Metric | Absent:
    """Share of kidnappings after which a right decision comes within 3 m of travel."""
    if missing := map_missing(case):
        return missing
    metres = _case_recoveries(case)
    if not len(metres):
        return Absent("nobody is kidnapped in this run, or no truth shows it")
    return share(name, metres <= RECOVERED_M, np.ones(len(metres), bool), block=1)


def _case_recoveries(case: Case) -> FloatArray:
    """Metres to the first right decision after each kidnapping of a run, NaN where none came."""
    truth = case.result.queries["truth"]
    if np.isnan(truth[:, 0]).all():
        return np.zeros(0)
    starts = kidnaps(truth, case.result.queries["session"])
    if not len(starts):
        return np.zeros(0)
    right = case.within(case.result.decision[:, None], tolerant=True)
    return _recoveries(starts, right, truth)


def kidnaps(truth: FloatArray, session: NDArray[np.int32]) -> NDArray[np.int64]:
    """First queries after a kidnapping, increasing."""
    steps = np.hypot(*np.diff(truth[:, :2], axis=0).T)
    usual = float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0
    with np.errstate(invalid="ignore"):
        jumped = (steps > JUMP_M) & (steps > 5.0 * usual)
    return np.flatnonzero(jumped | (np.diff(session) != 0)) + 1


def _recoveries(starts: NDArray[np.int64], right: Bools, truth: FloatArray) -> FloatArray:
    """Metres travelled from each start to the first right decision before the next, else NaN."""
    metres = np.full(len(starts), np.nan)
    for row, (start, end) in enumerate(zip(starts, [*starts[1:], len(right)], strict=True)):
        found = np.flatnonzero(right[start:end])
        if len(found):
            metres[row] = path_length(truth[start : start + found[0] + 1])[-1]
    return metres


def places(name: str, case: Case) -> Metric | Absent:
    """Number of places of the map."""
    if not case.has_map:
        return Absent("made without a map of places")
    number = len(case.result.view.place_ids)
    return Metric(name, float(number), number, number)
