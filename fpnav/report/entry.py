"""One result as a report sees it: its name, its header and its evaluation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fpnav.evaluation.case import Case, judge
from fpnav.evaluation.evaluate import Evaluation, evaluate
from fpnav.store.tables import Result
from fpnav.values import Metric


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A row of the report.

    ``slug`` names its files. ``evaluation`` is None for an entry that has figures of merit alone,
    such as one of several runs taken together. ``chosen_on`` names the run whose thresholds are
    carried over, if any.
    """

    name: str
    slug: str
    header: Mapping[str, Any]
    metrics: Mapping[str, Metric]
    absent: Mapping[str, str] = field(default_factory=dict)
    evaluation: Evaluation | None = None
    chosen_on: str = ""

    @property
    def result(self) -> Result | None:
        """The saved result behind it, if any."""
        return None if self.evaluation is None else self.evaluation.case.result

    @property
    def protocol(self) -> Mapping[str, Any]:
        """How the result was made: radius, exclusion, thinning."""
        protocol: Mapping[str, Any] = self.header.get("protocol", {})
        return protocol

    @property
    def method(self) -> str:
        """How queries were answered: match, filter, smooth, recognize."""
        return str(self.header.get("method", ""))


def entries_of(
    results: Sequence[tuple[str, Result]], chosen_on: tuple[str, Result] | None = None
) -> list[Entry]:
    """Entries of named results, evaluated; equal names are told apart by a number. ``chosen_on``:
    the run whose thresholds are carried over to them."""
    other = (chosen_on[0], judge(chosen_on[1])) if chosen_on else ("", None)
    names = distinct([name for name, _ in results])
    slugs = distinct([slug(name) for name in names])
    return [
        _entry(name, file, result, *other)
        for name, file, (_, result) in zip(names, slugs, results, strict=True)
    ]


def _entry(name: str, file: str, result: Result, other: str, chosen_on: Case | None) -> Entry:
    found = evaluate(result, chosen_on)
    return Entry(name, file, result.header, found.metrics, found.absent, found, other)


def distinct(names: Sequence[str]) -> list[str]:
    """The names, a repeated one with ``-2``, ``-3`` ... behind it; none is given twice."""
    taken = set(names)
    seen: set[str] = set()
    out = []
    for name in names:
        new, number = name, 2
        while new in seen or (new != name and new in taken):
            new, number = f"{name}-{number}", number + 1
        seen.add(new)
        out.append(new)
    return out


def slug(name: str) -> str:
    """A file name part: letters, digits, dot, dash and underscore, never empty or hidden."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")
    return plain[:80] or "result"
