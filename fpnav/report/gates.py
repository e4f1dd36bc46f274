"""Gates a user sets on figures: the report is written first, then they are checked."""

from __future__ import annotations

from collections.abc import Sequence

from fpnav.errors import GateError
from fpnav.evaluation.table import METRICS
from fpnav.report.entry import Entry


def check_gates(entries: Sequence[Entry], gates: Sequence[tuple[str, float]]) -> None:
    """Refuse results that miss a gate: a figure below it, or above it where lower is better.

    Raises
    ------
    GateError
        One line with every gate missed; an absent figure misses its gate.
    """
    missed = [
        _miss(entry, name, bound)
        for name, bound in gates
        for entry in entries
        if _misses(entry, name, bound)
    ]
    if missed:
        raise GateError("gate not met: " + "; ".join(missed))


def _misses(entry: Entry, name: str, bound: float) -> bool:
    if name not in entry.metrics:
        return True
    value = entry.metrics[name].value
    return value > bound if METRICS[name].better == "lower" else value < bound


def _miss(entry: Entry, name: str, bound: float) -> str:
    if name not in entry.metrics:
        return f"{entry.name}: {name} is absent: {entry.absent.get(name, 'not measured')}"
    metric = entry.metrics[name]
    word = "at most" if METRICS[name].better == "lower" else "at least"
    return (
        f"{entry.name}: {name} is {metric.value:.4g} ({metric.n} of {metric.of}), "
        f"expected {word} {bound:g}"
    )
