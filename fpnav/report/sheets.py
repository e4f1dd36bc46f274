"""metrics.csv: the figures of all results in one table."""

from __future__ import annotations

from collections.abc import Sequence

from fpnav.evaluation.sheets import sheet
from fpnav.report.entry import Entry


def metrics_sheet(entries: Sequence[Entry]) -> bytes:
    """One row per result and metric, absent ones with their reason."""
    rows: list[list[object]] = [
        ["result", "metric", "value", "n", "of", "unit", "low", "high", "absent"]
    ]
    for entry in entries:
        for name, metric in entry.metrics.items():
            figures = [metric.value, metric.n, metric.of, metric.unit, metric.low, metric.high]
            rows.append([entry.name, name, *figures, ""])
        rows += [[entry.name, name, *[""] * 6, reason] for name, reason in entry.absent.items()]
    return sheet(rows)
