"""What a query and its answer looked like: thumbnails, and scans laid over each other."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fpnav.evaluation.evaluate import OUTCOMES, Evaluation
from fpnav.execution.sights import FrameKey, Sight, sights_of
from fpnav.report.chosen import chosen
from fpnav.report.entry import Entry
from fpnav.report.figures.match import draw_match
from fpnav.report.figures.style import as_png, styled
from fpnav.store.header import Header
from fpnav.store.tables import Result
from fpnav.systems.registry import system_class


@dataclass(frozen=True, slots=True)
class Look:
    """The picture of one query with its answer: file name without ending, words, PNG."""

    name: str
    alt: str
    png: bytes

    @property
    def uri(self) -> str:
        """The picture for the page."""
        return f"data:image/png;base64,{base64.b64encode(self.png).decode()}"


Looks = Mapping[str, Mapping[int, Look]]
"""By the slug of an entry, then by the row of the query."""


def looks_of(entries: Sequence[Entry], logs: Sequence[Path]) -> Looks:
    """Pictures of the listed right and wrong matches, as far as the logs hold their frames.

    Raises
    ------
    UsageError
        A log is not one that the results were made from.
    LogError
        A log cannot be read.
    """
    if not logs:
        return {}
    wanted = [
        (entry.slug, entry.evaluation, query, *_keys(entry.evaluation.case.result, query))
        for entry in entries
        if entry.evaluation is not None
        for query in chosen(entry.evaluation)
    ]
    sights = sights_of(logs, {key for *_, asked, answer in wanted for key in (asked, answer)})
    looks: dict[str, dict[int, Look]] = {}
    for slug, evaluation, query, asked, answer in wanted:
        if asked in sights or answer in sights:
            look = _look(slug, evaluation, query, sights.get(asked), sights.get(answer))
            looks.setdefault(slug, {})[query] = look
    return looks


def _keys(result: Result, query: int) -> tuple[FrameKey, FrameKey]:
    """The frame of a query, and the frame that stands for its answer."""
    chain = result.header["chain"]
    asked, known = result.queries[query], result.references[answer_row(result, query)]
    return _key(result.header, chain[-1], asked), _key(result.header, chain[0], known)


def _key(header: Header, made_from: Header, row: Any) -> FrameKey:
    logs = _digests(made_from)
    session = int(row["session"])
    frames_on = tuple(system_class(header["system"]).NEEDS.frames_on)
    return FrameKey(logs[session] if session < len(logs) else "", frames_on, int(row["index"]))


def _digests(header: Header) -> list[str]:
    """Digests of the logs behind a file, in the order of its sessions."""
    if header["chain"]:
        return [digest for earlier in header["chain"] for digest in _digests(earlier)]
    return [str(source.get("sha256", "")) for source in header["sources"]]


def answer_row(result: Result, query: int) -> int:
    """The reference row that stands for an answer: its best member, else the place's middle one."""
    best = int(result.members[query, 0])
    if best >= 0:
        return best
    rows = np.flatnonzero(result.owner == result.decision[query])
    return int(rows[len(rows) // 2]) if len(rows) else 0


def _look(
    slug: str, evaluation: Evaluation, query: int, asked: Sight | None, answer: Sight | None
) -> Look:
    result = evaluation.case.result
    outcome = OUTCOMES[evaluation.table[query]["outcome"]]
    index = int(result.queries[query]["index"])
    with styled():
        figure, shown = draw_match(asked, answer, _apart(result, query), outcome)
        png = as_png(figure, dpi=110)
    return Look(f"{slug}-query-{index}", f"Query {index}, {outcome}: {shown}.", png)


def _apart(result: Result, query: int) -> tuple[float, float, float]:
    """The query as seen from its answer: x, y, heading; no shift where only a turn is known."""
    x, y, heading = (float(value) for value in result.relative[query])
    if math.isfinite(x):
        return x, y, heading
    turn = float(result.headings_rad[query, 0]) if result.members[query, 0] >= 0 else math.nan
    return 0.0, 0.0, turn
