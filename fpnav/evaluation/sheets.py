"""Tables as CSV bytes, safe to open in a spreadsheet."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence

from fpnav.evaluation.evaluate import OUTCOMES, QUERY, Evaluation

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def query_sheet(evaluation: Evaluation) -> bytes:
    """One row per query: where it was, what was answered, what became of it."""
    names = list(QUERY.names or ())
    rows: list[list[object]] = [[*names, "label"]]
    labels = evaluation.case.result.queries["label"]
    for query, label in zip(evaluation.table, labels, strict=True):
        cells: list[object] = [query[name].item() for name in names]
        cells[names.index("outcome")] = OUTCOMES[query["outcome"]]
        rows.append([*cells, bytes(label).decode(errors="replace")])
    return sheet(rows)


def sheet(rows: Iterable[Sequence[object]]) -> bytes:
    """Rows of cells as CSV; numbers that are not finite become empty cells."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerows([safe(cell) for cell in row] for row in rows)
    return buffer.getvalue().encode()


def safe(cell: object) -> object:
    """A cell that no spreadsheet takes for a formula: text that could be one gets a quote."""
    if isinstance(cell, str) and cell.startswith(_FORMULA):
        return f"'{cell}"
    if isinstance(cell, float):
        return f"{cell:.9g}" if math.isfinite(cell) else ""
    if isinstance(cell, bool):
        return int(cell)
    return cell
