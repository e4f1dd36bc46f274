"""Loops against truth: of one run against its own past, or closed while a map was built."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.case import NEAR_MAPPING_M, Case
from fpnav.evaluation.measure import NO_MATCH, NO_POSES, Absent, share, truth_missing
from fpnav.geometry import path_length
from fpnav.values import FloatArray, Metric

APART_M = 15.0
"""Path between two visits for the second to be a return."""

SAME_M = 1.5
"""A closed loop is right where the robot came within this of an earlier stay in the place."""

STRETCH_M = 1.0
"""A return is at least this much travel along an earlier path; less is a crossing."""

_TWO_RUNS = Absent("query run against reference run: loops are a matter of one run")


def loop_precision(name: str, case: Case) -> Metric | Absent:
    """Share of the loops claimed that are loops in truth."""
    if case.has_map:
        return _map_precision(name, case)
    if missing := _run_missing(case):
        return missing
    made = case.judged & case.decided
    if not made.any():
        return Absent("no loop is claimed: every decision was withheld")
    return share(name, case.decided_right, made)


def loop_recall(name: str, case: Case) -> Metric | Absent:
    """Share of the returns in truth that were claimed, and claimed right."""
    if case.has_map:
        return _map_recall(name, case)
    if missing := _run_missing(case):
        return missing
    if not case.has_match.any():
        return NO_MATCH
    return share(name, case.decided_right, case.has_match)


def _run_missing(case: Case) -> Absent | None:
    if (case.result.candidates >= len(case.result.references)).all():
        return _TWO_RUNS
    return truth_missing(case)


def _map_precision(name: str, case: Case) -> Metric | Absent:
    if missing := _map_missing(case):
        return missing
    stays = returning_stays(case.result.owner)
    if not stays:
        return Absent("no loop was closed while the map was built")
    right = np.array([_is_return(case, first, last) for first, last in stays])
    return share(name, right, np.ones(len(right), bool), block=1)


def _map_recall(name: str, case: Case) -> Metric | Absent:
    if missing := _map_missing(case):
        return missing
    stretches = returns(case.result.references["truth"])
    if not stretches:
        return Absent("the mapping run never returns along an earlier path")
    stays = returning_stays(case.result.owner)
    right = [stay for stay in stays if _is_return(case, *stay)]
    found = [any(a <= last and first <= b for first, last in right) for a, b in stretches]
    return share(name, np.array(found), np.ones(len(found), bool), block=1)


def _map_missing(case: Case) -> Absent | None:
    return NO_POSES if np.isnan(case.result.references["truth"]).all() else None


def returning_stays(owner: NDArray[np.int64]) -> list[tuple[int, int]]:
    """First and last row of every stay in a place that was left before: a loop the map closed."""
    starts = np.flatnonzero(np.diff(owner, prepend=-2))
    ends = np.append(starts[1:], len(owner)) - 1
    seen: set[int] = set()
    stays = []
    for first, last in zip(starts.tolist(), ends.tolist(), strict=True):
        place = int(owner[first])
        if place in seen:
            stays.append((first, last))
        seen.add(place)
    return stays


def _is_return(case: Case, first: int, last: int) -> bool:
    """Whether a stay comes near an earlier member of its place, in truth."""
    truth, owner = case.result.references["truth"], case.result.owner
    here = truth[first : last + 1, :2]
    before = truth[:first, :2][owner[:first] == owner[first]]
    away = np.hypot(*(here[:, None] - before[None]).transpose(2, 0, 1))
    return bool((away <= SAME_M).any())


def returns(truth: FloatArray) -> list[tuple[int, int]]:
    """Stretches of a run, first and last row, that follow an earlier stretch of it.

    A row returns where it lies within 1 m of a row at least 15 m of path earlier; a stretch is a
    run of such rows that is at least 1 m long.
    """
    travelled = path_length(truth)
    back = np.zeros(len(truth), bool)
    for row in range(len(truth)):
        earlier = truth[: np.searchsorted(travelled, travelled[row] - APART_M, side="right"), :2]
        if len(earlier):
            away = np.hypot(*(earlier - truth[row, :2]).T)
            back[row] = bool((away <= NEAR_MAPPING_M).any())
    edges = np.flatnonzero(np.diff(np.concatenate([[0], back.astype(np.int8), [0]])))
    stretches = zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)
    return [(a, b) for a, b in stretches if travelled[b] - travelled[a] >= STRETCH_M]
