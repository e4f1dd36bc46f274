"""Plain language: figures, results and their origin in words a person reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from fpnav.evaluation.table import METRICS
from fpnav.report.entry import Entry
from fpnav.values import Metric

METHODS = {
    "match": "each query on its own, no memory of the run",
    "filter": "a belief over places carried along the run, using the past only",
    "smooth": "the whole run at once, the future included",
    "recognize": "frame to frame, each query on its own",
    "recognize-smooth": "frame to frame, smoothed along the run, what came later included",
    "navigate": "each query on its own, on trips that a policy decided",
}
NON_CAUSAL = ("smooth", "recognize-smooth")
"""Methods that look ahead of a query; a robot on the move cannot."""

HEADLINES = (
    "place_accuracy_top1",
    "mission_success",
    "recall_at_1",
    "average_precision",
    "recall_at_100_precision",
    "position_error_median_m",
    "heading_error_median_deg",
    "not_localized",
    "places",
)
_MOST_HEADLINES = 6
_HIDDEN_ON_A_MAP = ("recall_at_1", "average_precision", "recall_at_100_precision")

FEW = 60
"""Below this many queries with a match the page says that figures are shaky."""

_UNITS = {"m": "m", "deg": "\u00b0"}
_WHOLE = ("places", "nodes_at_closed_doors", "nodes_at_closed_doors_front", "data_sets")


def title_of(name: str) -> str:
    """Title of a metric; its own name where the table does not know it."""
    return METRICS[name].title if name in METRICS else name


def number(metric: Metric) -> str:
    """A figure with its unit: shares that count something in percent, the rest as they are."""
    if metric.name in _WHOLE:
        return f"{metric.value:.0f}"
    if metric.unit:
        return (
            f"{metric.value:.{_digits(metric.value)}f}\u202f{_UNITS.get(metric.unit, metric.unit)}"
        )
    return f"{100 * metric.value:.1f}\u202f%" if is_rate(metric) else f"{metric.value:.3f}"


def interval(metric: Metric) -> str:
    """The 95 % interval in the same form, empty where there is none."""
    if not math.isfinite(metric.low) or not math.isfinite(metric.high):
        return ""
    if metric.unit:
        digits = _digits(metric.value)
        return f"{metric.low:.{digits}f} to {metric.high:.{digits}f}"
    if is_rate(metric):
        return f"{100 * metric.low:.0f} to {100 * metric.high:.0f}\u202f%"
    return f"{metric.low:.2f} to {metric.high:.2f}"


def counts(metric: Metric) -> str:
    """``n`` of ``of``; nothing where the value is itself the count."""
    return "" if metric.name in _WHOLE else f"{metric.n} of {metric.of}"


def is_rate(metric: Metric) -> bool:
    """Whether the value is the share ``n`` of ``of`` and reads well as percent; a count is none,
    though none at all be counted."""
    if metric.unit or metric.of <= 0 or metric.name in _WHOLE:
        return False
    return math.isclose(metric.value, metric.n / metric.of)


def headlines(entry: Entry) -> list[Metric]:
    """The figures a reader wants first."""
    on_map = "place_accuracy_top1" in entry.metrics
    names = [name for name in HEADLINES if not (on_map and name in _HIDDEN_ON_A_MAP)]
    return [entry.metrics[name] for name in names if name in entry.metrics][:_MOST_HEADLINES]


def summary(entry: Entry) -> str:
    """One sentence: how many queries, against what, by which method."""
    if entry.result is None:
        return "Several runs taken together."
    result = entry.result
    queries = f"{len(result.queries)} queries"
    if len(result.view.place_ids):
        against = f"located on a map of {len(result.view.place_ids)} places"
    else:
        against = f"matched with {len(result.references)} reference frames"
    how = METHODS.get(entry.method, entry.method)
    return (
        f"{queries} {against}{_exclusion(entry.protocol)}: {how}."
        if how
        else f"{queries} {against}."
    )


def verdict(entry: Entry) -> str:
    """What came out, in one or two sentences without a technical term."""
    if entry.evaluation is None:
        return ""
    case = entry.evaluation.case
    withheld = int((~case.decided).sum())
    if not case.judged.any():
        return f"A decision was made for {len(case.decided) - withheld} queries."
    first = "recall_at_1" if not case.has_map else "place_accuracy_top1"
    told = []
    if first in entry.metrics:
        metric = entry.metrics[first]
        what = "stand in a mapped place" if case.has_map else "show a place seen before"
        told.append(
            f"Of {metric.of} queries that {what}, {metric.n} "
            f"({100 * metric.value:.0f}\u202f%) have the right answer ranked first."
        )
    made = case.judged & case.decided
    right = int((case.decided_right & made).sum())
    told.append(
        f"{int(made.sum())} decisions were made, {right} of them right; {withheld} were withheld."
    )
    return " ".join(told)


def _exclusion(protocol: Mapping[str, Any]) -> str:
    parts = []
    if protocol.get("exclude_path_m"):
        parts.append(f"at least {protocol['exclude_path_m']:g} m of path")
    if protocol.get("exclude_frames"):
        parts.append(f"{protocol['exclude_frames']} frames")
    return f" of the same run, {' and '.join(parts)} earlier" if parts else ""


def same_place(entry: Entry) -> str:
    """What counts as right, in words."""
    if entry.result is None:
        return ""
    truth = entry.result.truth
    if truth.kind == "none":
        return "There is no ground truth: nothing can be called right or wrong."
    if truth.kind == "pairs":
        return f"Right is what the ground truth lists as accepted ({truth.source})."
    if len(entry.result.view.place_ids):
        return (
            "Right is the place that owns the mapping pose nearest to the true pose, at most 1 m "
            f"away (truth: {truth.source})."
        )
    heading = entry.protocol.get("heading_deg", 45)
    turned = "any heading" if heading == "any" else f"at most {heading:g}\u00b0 turned"
    radius = entry.protocol.get("radius_m", 1.5)
    return f"Right is a reference within {radius:g} m, {turned} (truth: {truth.source})."


def labels(entry: Entry) -> list[tuple[str, str]]:
    """Honest labels of a result: short word and what it means."""
    found = []
    synthetic = entry.header.get("synthetic")
    if synthetic is True:
        found.append(("simulated", "The recording was made by a simulator, not by a robot."))
    elif synthetic is False:
        found.append(("recorded", "The recording comes from a robot."))
    if entry.method in NON_CAUSAL:
        found.append(("not causal", "Answers use what comes after the query as well."))
    elif entry.protocol.get("causal") is False:
        found.append(("not causal", "Statistics of the whole run were used, the future included."))
    return found


def warnings(entry: Entry) -> list[str]:
    """What a reader should bear in mind about these figures."""
    if entry.evaluation is None:
        return []
    found = []
    case = entry.evaluation.case
    positives, judged = int(case.has_match.sum()), int(case.judged.sum())
    if 0 < positives < FEW:
        found.append(f"Only {positives} queries have a match: every figure hangs on a few of them.")
    if 0 < judged < len(case.judged):
        found.append(f"{len(case.judged) - judged} queries have no ground truth and count nowhere.")
    near = int(case.dont_care.sum())
    if near:
        found.append(
            f"{near} wrong best matches lie within 3 m and 90 degrees of the query; the figures "
            "marked \u201cnear misses aside\u201d leave them out."
        )
    return found


def _digits(value: float) -> int:
    return 2 if abs(value) < 10 else 1
