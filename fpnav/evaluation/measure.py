"""What a metric is: a function of a judged case that gives a figure, or says why it cannot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.bootstrap import BLOCK, interval, median, ratio
from fpnav.evaluation.case import Case
from fpnav.values import FloatArray, Metric


@dataclass(frozen=True, slots=True)
class Absent:
    """A metric that cannot be computed, and why, in a form a person can act on."""

    reason: str


Measure = Callable[[str, Case], Metric | Absent]
"""Name and case to the figure."""

NO_TRUTH = Absent("no ground truth: the result was made without --truth and the log has none")
NO_MATCH = Absent("no query has a match in truth")
NO_MAP = Absent("made without a map of places")
NO_POSES = Absent("truth holds accepted pairs, not poses")


def truth_missing(case: Case) -> Absent | None:
    """Why nothing can be judged, None where something can."""
    if not case.judged.any():
        return NO_TRUTH
    return None


def map_missing(case: Case) -> Absent | None:
    """Why places cannot be judged, None where they can."""
    if not case.has_map:
        return NO_MAP
    return truth_missing(case)


def share(name: str, hits: Bools, among: Bools, block: int = BLOCK) -> Metric:
    """Rate of the units ``among`` (N,) that are ``hits`` (N,), with its interval."""
    n, of = int((hits & among).sum()), int(among.sum())
    low, high = interval(ratio(hits & among, among), len(among), block)
    return Metric(name, n / of, n, of, "", low, high)


def middle(
    name: str, values: FloatArray, among: Bools, unit: str, block: int = BLOCK
) -> Metric | Absent:
    """Median of ``values`` (N,) over those ``among`` (N,) that are known, with its interval."""
    used = among & np.isfinite(values)
    if not used.any():
        return Absent("no query for which both sides are known")
    low, high = interval(median(values, used), len(values), block)
    value = float(np.median(values[used]))
    return Metric(name, value, int(used.sum()), int(among.sum()), unit, low, high)
