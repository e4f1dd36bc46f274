"""What the page template is given: plain values, words already chosen, pictures as data URIs."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from fpnav import __version__
from fpnav.evaluation.table import METRICS
from fpnav.report import words
from fpnav.report.document import plain
from fpnav.report.entry import Entry
from fpnav.report.lists import right_and_wrong
from fpnav.report.looks import Look, Looks
from fpnav.values import Metric

_LARGEST_SVG = 350_000


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure as it is published: its file names, its bytes, its words."""

    name: str
    title: str
    caption: str
    alt: str
    wide: bool
    whole: bool
    svg: bytes
    png: bytes

    @property
    def uri(self) -> str:
        """The figure for the page: SVG, or PNG where the SVG is too large to carry along."""
        vector = len(self.svg) <= max(_LARGEST_SVG, len(self.png))
        kind, data = ("svg+xml", self.svg) if vector else ("png", self.png)
        return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def page_context(
    entries: Sequence[Entry],
    pictures: Mapping[str, Sequence[Picture]],
    compared: Sequence[Picture],
    looks: Looks = MappingProxyType({}),
) -> dict[str, Any]:
    """Values of the page; ``pictures`` and ``looks`` by the slug of their entry."""
    return {
        "version": __version__,
        "title": _title(entries),
        "entries": [
            _section(entry, pictures.get(entry.slug, ()), looks.get(entry.slug, {}))
            for entry in entries
        ],
        "compared": compared,
        "table": _table(entries),
        "definitions": _definitions(entries),
    }


def _title(entries: Sequence[Entry]) -> str:
    return entries[0].name if len(entries) == 1 else f"{len(entries)} results side by side"


def _section(
    entry: Entry, pictures: Sequence[Picture], looks: Mapping[int, Look]
) -> dict[str, Any]:
    return {
        "name": entry.name,
        "slug": entry.slug,
        "system": entry.header.get("system", ""),
        "preset": entry.header.get("preset", ""),
        "method": entry.method,
        "summary": words.summary(entry),
        "verdict": words.verdict(entry),
        "same_place": words.same_place(entry),
        "labels": words.labels(entry),
        "warnings": words.warnings(entry),
        "headlines": [_figure(metric) for metric in words.headlines(entry)],
        "metrics": [_figure(metric) for metric in entry.metrics.values()],
        "absent": _absent(entry),
        "pictures": pictures,
        "looks": bool(looks),
        "matches": right_and_wrong(entry, looks),
        "protocol": _facts(entry.protocol),
        "chain": [_link(header) for header in _chain(entry)],
        "ledger": _ledger(entry.header),
    }


def _figure(metric: Metric) -> dict[str, Any]:
    return {
        "name": metric.name,
        "title": words.title_of(metric.name),
        "value": words.number(metric),
        "interval": words.interval(metric),
        "counts": words.counts(metric),
    }


def _absent(entry: Entry) -> list[dict[str, Any]]:
    """Reasons with the metrics that share them, in the order met."""
    grouped: dict[str, list[str]] = {}
    for name, reason in entry.absent.items():
        grouped.setdefault(reason, []).append(words.title_of(name))
    return [{"reason": reason, "titles": titles} for reason, titles in grouped.items()]


def _table(entries: Sequence[Entry]) -> list[dict[str, Any]]:
    """Rows of the side-by-side table: metrics that some result has, headlines first."""
    names = [
        name
        for name in dict.fromkeys([*words.HEADLINES, *METRICS])
        if any(name in entry.metrics for entry in entries)
    ]
    for entry in entries:
        names += [name for name in entry.metrics if name not in names]
    return [
        {
            "name": name,
            "title": words.title_of(name),
            "cells": [
                _figure(entry.metrics[name]) if name in entry.metrics else None for entry in entries
            ],
            "best": _best(name, entries),
            "headline": name in words.HEADLINES,
        }
        for name in names
    ]


def _best(name: str, entries: Sequence[Entry]) -> list[bool]:
    """Which results are best in a metric; none where there is nothing to compare."""
    values = [entry.metrics[name].value if name in entry.metrics else None for entry in entries]
    known = [value for value in values if value is not None]
    better = METRICS[name].better if name in METRICS else "neither"
    if len(known) < 2 or better == "neither" or len(set(known)) == 1:
        return [False] * len(values)
    best = max(known) if better == "higher" else min(known)
    return [value == best for value in values]


def _definitions(entries: Sequence[Entry]) -> list[dict[str, str]]:
    names = [n for n in METRICS if any(n in e.metrics or n in e.absent for e in entries)]
    return [
        {
            "name": name,
            "title": METRICS[name].title,
            "meaning": METRICS[name].meaning,
            "counts": METRICS[name].counts,
        }
        for name in names
    ]


def _facts(mapping: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys and values in a readable form, in their order; empty ones left out."""
    return [(str(key), _value(item)) for key, item in mapping.items() if item not in (None, {}, [])]


def _value(item: Any) -> str:
    if isinstance(item, str):
        return item
    if isinstance(item, float):
        return f"{item:.6g}"
    if isinstance(item, list) and all(isinstance(part, str) for part in item):
        return ", ".join(item)
    return json.dumps(plain(item), sort_keys=True, ensure_ascii=False)


def _chain(entry: Entry) -> list[Mapping[str, Any]]:
    """The result's header and those it was made from, back to the logs; each once."""
    found: list[Mapping[str, Any]] = []

    def walk(header: Mapping[str, Any]) -> None:
        if header not in found:
            found.append(header)
        for earlier in header.get("chain", ()):
            walk(earlier)

    walk(entry.header)
    return found


def _link(header: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "format": str(header.get("format", "")).removeprefix("fpnav/"),
        "version": header.get("fpnav", ""),
        "system": header.get("system", ""),
        "preset": header.get("preset", ""),
        "sources": [
            {
                "name": str(source.get("name", "")),
                "sha256": str(source.get("sha256", "")),
                "bytes": f"{source.get('bytes', 0):,}".replace(",", "\u202f"),
                "integrity": str(source.get("integrity", "")),
            }
            for source in header.get("sources", ())
        ],
        "params": _facts(header.get("params", {})),
    }


def _ledger(header: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Rows of the ledger of losses; numbered topics that fared alike share one."""
    rows: dict[str, dict[str, Any]] = {}
    for row in _ledger_topics(header):
        facts = {key: value for key, value in row.items() if key != "topic"}
        stem = re.sub(r"\d+$", "", row["topic"])
        key = json.dumps([stem, plain(facts)], sort_keys=True)
        first = rows.setdefault(key, {**row, "first": row["topic"], "number": 0})
        first["number"] += 1
        if first["number"] > 1:
            first["topic"] = f"{first['first']} and {first['number'] - 1} like it"
    return list(rows.values())


def _ledger_topics(header: Mapping[str, Any]) -> list[dict[str, Any]]:
    ledgers = header.get("ledger") or []
    rows = []
    for ledger in ledgers if isinstance(ledgers, list) else [ledgers]:
        logs = ", ".join(str(log.get("name", "")) for log in ledger.get("inputs", ()))
        for topic in ledger.get("topics", ()):
            skipped = topic.get("skipped", {})
            rows.append(
                {
                    "log": logs,
                    "topic": str(topic.get("topic", "")),
                    "in_file": topic.get("in_file", ""),
                    "used": topic.get("used", ""),
                    "skipped": _facts(skipped) if isinstance(skipped, Mapping) else [],
                    "unread": topic.get("unread", 0),
                }
            )
    return rows
