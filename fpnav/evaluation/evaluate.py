"""From a result to its evaluation: every figure or the reason it is absent, and one row a query."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.case import Case, judge
from fpnav.evaluation.measure import Absent
from fpnav.evaluation.table import METRICS
from fpnav.store.tables import Result
from fpnav.values import Metric

OUTCOMES = ("right", "wrong", "not localized", "not judged")
"""What became of a query; index of the table's ``outcome`` column."""

QUERY = np.dtype(
    [
        ("index", "<i8"),
        ("session", "<i4"),
        ("stamp_ns", "<i8"),
        ("travelled_m", "<f8"),
        ("x_m", "<f8"),
        ("y_m", "<f8"),
        ("heading_rad", "<f8"),
        ("matches", "<i8"),
        ("true_place", "<i8"),
        ("best_place", "<i8"),
        ("best_member", "<i8"),
        ("score", "<f8"),
        ("decision", "<i8"),
        ("outcome", "<i1"),
        ("best_right", "?"),
        ("rank_of_match", "<i8"),
        ("stated", "<f8"),
        ("entropy", "<f8"),
        ("position_error_m", "<f8"),
        ("heading_error_deg", "<f8"),
        ("near_miss", "?"),
    ]
)
"""One row per query. ``best_member`` and ``index`` count primary messages before thinning;
``rank_of_match`` is 1 for the first, 0 where no match is in the ranking."""


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Figures of one result.

    ``metrics`` and ``absent`` share the names of the table; ``table`` (Q,) is of dtype QUERY;
    ``chain`` leads from the result's header back to the log.
    """

    metrics: Mapping[str, Metric]
    absent: Mapping[str, str]
    table: NDArray[Any]
    chain: tuple[Mapping[str, Any], ...]
    case: Case


def evaluate(result: Result, chosen_on: Case | None = None) -> Evaluation:
    """Measure everything that can be measured of a result; thresholds chosen on another run are
    carried over from it.

    Raises
    ------
    TruthError
        The truth saved in the result does not fit it.
    """
    case = replace(judge(result), chosen_on=chosen_on)
    measured = {name: entry.measure(name, case) for name, entry in METRICS.items()}
    return Evaluation(
        metrics={name: value for name, value in measured.items() if isinstance(value, Metric)},
        absent={
            name: value.reason for name, value in measured.items() if isinstance(value, Absent)
        },
        table=query_table(case),
        chain=(result.header, *result.header.get("chain", ())),
        case=case,
    )


def query_table(case: Case) -> NDArray[Any]:
    """One row a query, (Q,) QUERY."""
    result = case.result
    table = np.zeros(len(result.queries), QUERY)
    for name in ("index", "session", "stamp_ns", "travelled_m"):
        table[name] = result.queries[name]
    table["x_m"], table["y_m"], table["heading_rad"] = result.queries["truth"].T
    table["matches"] = np.diff(case.accepted.offsets)
    table["true_place"] = case.true_place
    table["best_place"] = _first(result.places, -1)
    table["best_member"] = _member_index(result)
    table["score"] = _first(result.scores, np.nan)
    table["decision"] = result.decision
    table["outcome"] = outcomes(case)
    table["best_right"] = case.best_right
    table["rank_of_match"] = np.where(case.right.any(axis=1), _rank(case), 0)
    table["stated"], table["entropy"] = result.stated, result.entropy
    table["position_error_m"] = case.position_error_m
    table["heading_error_deg"] = np.rad2deg(case.heading_error_rad)
    table["near_miss"] = case.dont_care
    return table


def outcomes(case: Case) -> NDArray[np.int8]:
    """Index into OUTCOMES of each query, by its decision, (Q,)."""
    decided = np.where(case.decided_right, 0, 1)
    spoken = np.where(case.decided, decided, 2)
    return np.where(case.judged | ~case.decided, spoken, 3).astype(np.int8)


def _rank(case: Case) -> NDArray[np.int64]:
    if not case.right.shape[1]:
        return np.zeros(len(case.judged), np.int64)
    return np.asarray(np.argmax(case.right, axis=1) + 1)


def _first(columns: NDArray[Any], padding: float) -> NDArray[Any]:
    return columns[:, 0] if columns.shape[1] else np.full(len(columns), padding)


def _member_index(result: Result) -> NDArray[np.int64]:
    """Primary message index of each best member, -1 where there is none."""
    member = _first(result.members, -1).astype(np.int64)
    index = np.append(result.references["index"], -1)
    return np.asarray(index[np.where(member >= 0, member, len(index) - 1)])
