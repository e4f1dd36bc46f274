"""Metrics of the ranking and of the decision."""

from __future__ import annotations

import numpy as np

from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import NO_MATCH, Absent, Measure, share, truth_missing
from fpnav.values import Metric


def recall_at(depth: int, *, every_query: bool = False) -> Measure:
    """Share of queries that find a match among the first ``depth`` of the ranking.

    Of the queries that have a match, or of every judged query. Abstaining changes nothing.
    """

    def measure(name: str, case: Case) -> Metric | Absent:
        if missing := truth_missing(case) or _too_shallow(case, depth):
            return missing
        among = case.judged if every_query else case.has_match
        if not among.any():
            return NO_MATCH
        return share(name, np.asarray(case.right[:, :depth].any(axis=1)), among)

    return measure


def _too_shallow(case: Case, depth: int) -> Absent | None:
    """Why the first ``depth`` cannot be looked at, None where they can."""
    ranks, possible = case.result.places.shape[1], len(np.unique(case.result.owner))
    if ranks < min(depth, possible):
        return Absent(f"the ranking saved is {ranks} deep")
    return None


def not_localized(name: str, case: Case) -> Metric | Absent:
    """Share of decisions withheld, of all queries."""
    if not len(case.decided):
        return Absent("no query")
    return share(name, ~case.decided, np.ones(len(case.decided), bool))


def decision_precision(name: str, case: Case) -> Metric | Absent:
    """Share of the decisions made that are right."""
    if missing := truth_missing(case):
        return missing
    made = case.judged & case.decided
    if not made.any():
        return Absent("every decision was withheld")
    return share(name, case.decided_right, made)


def new_place_recall(name: str, case: Case) -> Metric | Absent:
    """Share of the queries without any match whose decision was withheld."""
    if missing := truth_missing(case):
        return missing
    new = case.judged & ~case.has_match
    if not new.any():
        return Absent("every query has a match in truth")
    return share(name, ~case.decided, new)
