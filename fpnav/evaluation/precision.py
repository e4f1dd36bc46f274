"""Metrics of precision and recall over every threshold."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fpnav.evaluation.bootstrap import joint_intervals
from fpnav.evaluation.case import Case
from fpnav.evaluation.curve import FIGURES, count, plain, sweep
from fpnav.evaluation.measure import NO_MATCH, NO_POSES, Absent, Measure, truth_missing
from fpnav.values import FloatArray, Metric


def over_curve(figure: str, *, dont_care: bool = False) -> Measure:
    """A figure of the precision-recall curve, by its name in ``curve.FIGURES``.

    ``dont_care``: a wrong best match within 3 m and 90 degrees counts neither way; the recall base
    stays that of all queries with a match. ``n`` of ``of``: queries with a match of those judged.
    """

    def measure(name: str, case: Case) -> Metric | Absent:
        if missing := _missing(case, dont_care):
            return missing
        found = _figures(case, dont_care)
        if not found:
            return Absent("no query has an answer that counts")
        value, low, high = found[figure]
        if not np.isfinite(value):
            return Absent("no best answer is right")
        n, of = int(case.has_match.sum()), int(case.judged.sum())
        return Metric(name, value, n, of, "", low, high)

    return measure


@lru_cache(maxsize=2)
def _figures(case: Case, dont_care: bool) -> dict[str, tuple[float, float, float]]:
    """Every figure of a curve with its interval, from one set of resampled runs; the metrics of a
    case ask for them one after another."""
    answers = sweep(case, ignore=case.dont_care if dont_care else None)
    if not len(answers.ends):
        return {}

    def all_figures(weights: FloatArray) -> FloatArray:
        counts = count(answers, weights)
        return np.array([figure(counts) for figure in FIGURES.values()])

    values = np.array([figure(plain(answers))[0] for figure in FIGURES.values()])
    limits = joint_intervals(all_figures, len(FIGURES), len(case.judged))
    return {
        name: (float(value), *limit)
        for name, value, limit in zip(FIGURES, values, limits, strict=True)
    }


def _missing(case: Case, dont_care: bool) -> Absent | None:
    if missing := truth_missing(case):
        return missing
    if not case.has_match.any():
        return NO_MATCH
    if dont_care and not np.isfinite(case.member_apart_m[case.judged]).any():
        return NO_POSES
    return None
