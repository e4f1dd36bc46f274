"""Some right and some wrong matches of a result, one row each, to look at."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from fpnav.evaluation.evaluate import OUTCOMES, Evaluation
from fpnav.report.chosen import chosen
from fpnav.report.entry import Entry
from fpnav.report.looks import Look
from fpnav.store.tables import Result


def right_and_wrong(
    entry: Entry, looks: Mapping[int, Look] = MappingProxyType({})
) -> list[dict[str, Any]]:
    """The chosen queries, one row each; ``looks`` by query row, of those there are."""
    if entry.evaluation is None:
        return []
    return [{**_row(entry.evaluation, q), "look": looks.get(q)} for q in chosen(entry.evaluation)]


def _row(evaluation: Evaluation, query: int) -> dict[str, Any]:
    row, result = evaluation.table[query], evaluation.case.result
    on_map = evaluation.case.has_map
    return {
        "outcome": OUTCOMES[row["outcome"]],
        "query": int(row["index"]),
        "travelled": _number(row["travelled_m"], 1),
        "answer": f"place {row['decision']}" if on_map else f"frame {row['best_member']}",
        "truth": _truth(evaluation, query),
        "score": _number(row["score"], 3),
        "stated": _number(100 * row["stated"], 0, "\u202f%"),
        "error": _number(row["position_error_m"], 2, "\u202fm"),
        "query_strip": _strip(result.query_strips, query),
        "answer_strip": _answer_strip(result, query),
    }


def _truth(evaluation: Evaluation, query: int) -> str:
    """What would have been right, the first few of it."""
    case = evaluation.case
    accepted = case.accepted[query]
    if not len(accepted):
        return "nothing: a new place"
    if case.has_map:
        return ", ".join(f"place {place}" for place in accepted[:3])
    frames = case.result.references["index"][accepted]
    if len(frames) <= 3:
        return "frame " + ", ".join(str(frame) for frame in frames)
    return f"{len(frames)} frames, {frames.min()} to {frames.max()}"


def _answer_strip(result: Result, query: int) -> str:
    """Readable signature of the place decided on, or of the frame where it was a query too."""
    if len(result.view.place_ids):
        rows = np.flatnonzero(result.view.place_ids == result.decision[query])
        return _strip(result.view.strips, int(rows[0])) if len(rows) else ""
    if (result.candidates >= len(result.references)).all():
        return ""
    frame = result.references[result.decision[query]]
    same = result.queries["index"] == frame["index"]
    rows = np.flatnonzero(same & (result.queries["session"] == frame["session"]))
    return _strip(result.query_strips, int(rows[0])) if len(rows) else ""


def _strip(strips: tuple[str, ...], row: int) -> str:
    return strips[row] if row < len(strips) else ""


def _number(value: float, digits: int, unit: str = "") -> str:
    return f"{value:.{digits}f}{unit}" if math.isfinite(value) else ""
