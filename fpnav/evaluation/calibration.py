"""Do stated probabilities hold? Brier skill and expected calibration error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.bootstrap import Statistic, interval
from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import Absent, truth_missing
from fpnav.values import FloatArray, Metric

BINS = 10


def brier_skill(name: str, case: Case) -> Metric | Absent:
    """1 - Brier score / Brier score of always stating the share of right answers (Murphy 1973).

    1 is perfect, 0 no better than the base rate, negative worse.
    """
    used = _stated(case)
    if isinstance(used, Absent):
        return used
    right = case.best_right[used].astype(np.float64)
    if right.min() == right.max():
        return Absent("all answers are right, or all wrong: there is no skill to show")
    squared = (case.result.stated[used] - right) ** 2

    def skill(weights: FloatArray) -> FloatArray:
        drawn = weights[:, used]
        total = drawn.sum(axis=1)
        with np.errstate(all="ignore"):
            rate = (drawn * right).sum(axis=1) / total
            return np.asarray(1.0 - (drawn * squared).sum(axis=1) / total / (rate * (1.0 - rate)))

    return _metric(name, skill, used, case)


def ece(name: str, case: Case) -> Metric | Absent:
    """Mean gap between stated probability and share right, over ten equal bins, weighted by their
    counts (Naeini et al. 2015)."""
    used = _stated(case)
    if isinstance(used, Absent):
        return used
    stated, right = case.result.stated[used], case.best_right[used].astype(np.float64)
    bins = bins_of(stated)

    def error(weights: FloatArray) -> FloatArray:
        drawn = weights[:, used]
        gaps = np.zeros(len(weights))
        for bin_ in range(BINS):
            inside = bins == bin_
            gaps += np.abs((drawn[:, inside] * (stated - right)[inside]).sum(axis=1))
        with np.errstate(all="ignore"):
            return np.asarray(gaps / drawn.sum(axis=1))

    return _metric(name, error, used, case)


def calibration_error(stated: FloatArray, right: Bools) -> float:
    """Expected calibration error of stated probabilities (M,) over ten equal bins."""
    bins = bins_of(stated)
    gaps = np.bincount(bins, weights=stated - right, minlength=BINS)
    return float(np.abs(gaps).sum() / max(len(stated), 1))


def skill(stated: FloatArray, right: Bools) -> float:
    """Brier skill of stated probabilities (M,) against always stating the share right."""
    rate = float(right.mean())
    return float(1.0 - np.mean((stated - right) ** 2) / max(rate * (1.0 - rate), 1e-12))


def bins_of(stated: FloatArray) -> NDArray[np.int64]:
    """Bin 0 .. 9 of each stated probability; 1.0 belongs to the last."""
    return np.minimum((stated * BINS).astype(np.int64), BINS - 1)


def _stated(case: Case) -> Bools | Absent:
    """Judged queries with a stated probability, (Q,)."""
    if missing := truth_missing(case):
        return missing
    used = case.judged & case.answered & np.isfinite(case.result.stated)
    if not used.any():
        return Absent("no probabilities are stated")
    stated = case.result.stated[used]
    if stated.min() < 0.0 or stated.max() > 1.0:
        return Absent("stated values lie outside 0 .. 1: they are no probabilities")
    return np.asarray(used)


def _metric(name: str, figure: Statistic, used: Bools, case: Case) -> Metric:
    value = float(figure(np.ones((1, len(used))))[0])
    low, high = interval(figure, len(used))
    return Metric(name, value, int(used.sum()), int(case.judged.sum()), "", low, high)
