"""Thresholds that travel: chosen on one run, reported on another.

The score at which one run reached a precision is carried over by its quantile among that run's best
scores (quantile transfer, as in arXiv 2602.04401), so that scores may be larger or smaller all over
on the other run. The carried threshold uses no truth of the run it is reported on, but all of its
scores: it is known once that run is over, and right as far as both runs revisit equally often.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fpnav.evaluation import curve
from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import NO_MATCH, Absent, Measure, share, truth_missing
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Metric

NOT_NAMED = Absent("no other run was named to choose a threshold on (--threshold-from)")


@dataclass(frozen=True, slots=True)
class Carried:
    """A threshold: ``chosen`` on the other run, where a share ``accepted`` of its best answers
    reaches it, and ``here``; infinite where no answer may be accepted."""

    chosen: float
    accepted: float
    here: float


def threshold_at_precision(answers: curve.Sweep, least: float) -> float | None:
    """Highest score at which recall is largest with a precision of at least ``least``; None where
    none reaches it."""
    counts = curve.plain(answers)
    right = np.where(curve.reaches(counts, least)[0], counts.right[0], 0.0)
    return float(answers.scores[right.argmax()]) if right.any() else None


def share_reaching(scores: FloatArray, threshold: float) -> float:
    """Share of the scores (A,) that are at least the threshold."""
    return float((scores >= threshold).mean())


def threshold_at_share(scores: FloatArray, accepted: float) -> float:
    """Lowest of the scores (A,) that at most the given share of them reaches, infinite if none:
    equal scores are accepted together or not at all."""
    distinct, count = np.unique(scores, return_counts=True)
    reaching = np.cumsum(count[::-1])
    fits = np.flatnonzero(reaching <= accepted * len(scores) + 1e-9)
    return float(distinct[::-1][fits[-1]]) if len(fits) else math.inf


def carry(case: Case, least: float) -> Carried | Absent:
    """The threshold chosen on ``case.chosen_on`` for a precision of at least ``least``."""
    other = case.chosen_on
    if other is None:
        return NOT_NAMED
    if differ := _differ(case.result, other.result):
        return Absent(differ)
    chosen = threshold_at_precision(curve.sweep(other), least)
    if chosen is None:
        return Absent(
            f"the run that thresholds come from never reaches {100 * least:g} % precision"
        )
    if not case.answered.any():
        return Absent("no query has an answer")
    accepted = share_reaching(_best_scores(other), chosen)
    return Carried(chosen, accepted, threshold_at_share(_best_scores(case), accepted))


def carried_precision(least: float) -> Measure:
    """Share right of the best answers that reach the carried threshold."""

    def measure(name: str, case: Case) -> Metric | Absent:
        found = _reaching(case, least)
        if isinstance(found, Absent):
            return found
        if not (found & case.judged).any():
            return Absent("no answer reaches the threshold carried over")
        return share(name, case.best_right, found & case.judged)

    return measure


def carried_recall(least: float) -> Measure:
    """Share of the queries with a match whose best answer is right and reaches the threshold."""

    def measure(name: str, case: Case) -> Metric | Absent:
        found = _reaching(case, least)
        if isinstance(found, Absent):
            return found
        if not case.has_match.any():
            return NO_MATCH
        return share(name, case.best_right & found, case.has_match)

    return measure


def _reaching(case: Case, least: float) -> Bools | Absent:
    """Whether each best answer reaches the carried threshold, (Q,)."""
    carried = carry(case, least)
    if isinstance(carried, Absent):
        return carried
    if missing := truth_missing(case):
        return missing
    out = np.zeros(len(case.judged), bool)
    out[case.answered] = _best_scores(case) >= carried.here
    return out


def _best_scores(case: Case) -> FloatArray:
    """Scores of the best answers, judged or not, (A,)."""
    rows = np.flatnonzero(case.answered)
    return np.asarray(case.result.scores[rows, 0] if len(rows) else np.zeros(0))


def _differ(result: Result, other: Result) -> str:
    """Why no threshold can be carried between two results; empty where it can."""
    if result.header.get("sources") == other.header.get("sources"):
        return "thresholds were to come from this very run"
    mine, theirs = _making(result), _making(other)
    if mine != theirs:
        return f"thresholds come from a run by {theirs}; this one is by {mine}"
    return ""


def _making(result: Result) -> str:
    """System, preset and method: what must agree for scores to mean the same."""
    header: dict[str, Any] = dict(result.header)
    return ", ".join(str(header.get(key, "")) for key in ("system", "preset", "method"))
