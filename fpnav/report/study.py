"""The report on the reproduction of a paper: what it claims, what came out, its figures beside."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fpnav import __version__
from fpnav.publish import publish_bytes
from fpnav.report import words
from fpnav.report.context import Picture
from fpnav.report.document import as_json, document, plain
from fpnav.report.entry import Entry, slug
from fpnav.report.figures.style import Drawing, styled
from fpnav.report.page import render
from fpnav.report.sheets import metrics_sheet
from fpnav.report.write import PAGE, make_folder, picture_of, publish_pictures
from fpnav.values import Metric

TEMPLATE = "study.html.jinja"


@dataclass(frozen=True, slots=True)
class Claim:
    """One row of the table: what the paper says, what is to be reached, in which figure of merit.

    ``least`` and ``most`` bound the mean over seeds, ``above`` its whole 95 % interval (the mean
    where there is none); without any the figure is only reported.
    ``meaning`` says how success is defined.
    """

    experiment: str
    metric: str
    what: str
    paper: str
    least: float | None = None
    most: float | None = None
    meaning: str = ""
    above: float | None = None

    def met(self, metric: Metric) -> bool | None:
        """Whether a figure keeps the bounds; None where nothing was asked."""
        kept = []
        if self.least is not None:
            kept.append(metric.value >= self.least)
        if self.most is not None:
            kept.append(metric.value <= self.most)
        if self.above is not None:
            kept.append(_lowest(metric) > self.above)
        return all(kept) if kept else None


def _lowest(metric: Metric) -> float:
    return metric.low if math.isfinite(metric.low) else metric.value


@dataclass(frozen=True, slots=True, eq=False)
class Illustration:
    """A figure still to be drawn, with its words."""

    name: str
    title: str
    caption: str
    draw: Callable[[], Drawing]


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """What an experiment gave for a seed; ``seed`` None = over all seeds."""

    experiment: str
    seed: int | None
    metrics: Mapping[str, Metric]
    pictures: Sequence[Illustration] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """``A3/seed-1``, or ``A3`` over all seeds."""
        return self.experiment if self.seed is None else f"{self.experiment}/seed-{self.seed}"


@dataclass(frozen=True, slots=True, eq=False)
class Heading:
    """What stands above the table, and the system the study is about."""

    name: str
    system: str
    title: str
    paper: str
    introduction: str
    titles: Mapping[str, str]


def write_study(
    heading: Heading,
    claims: Sequence[Claim],
    findings: Sequence[Finding],
    folder: Path,
    *,
    small: bool = False,
) -> None:
    """Write report.json, metrics.csv, the figures and index.html, the page last.

    ``small`` : the routes were shortened, which the page says.

    Raises
    ------
    FpnavError
        The folder cannot be written.
    """
    make_folder(folder)
    entries = [_entry(heading, finding) for finding in findings]
    pictures = {finding.name: _drawn(finding) for finding in findings}
    for drawn in pictures.values():
        publish_pictures(folder, drawn)
    publish_bytes(folder / "metrics.csv", metrics_sheet(entries))
    publish_bytes(folder / "report.json", as_json(document(entries)))
    context = study_context(heading, claims, findings, pictures)
    publish_bytes(folder / PAGE, render({**context, "small": small}, TEMPLATE))


def study_context(
    heading: Heading,
    claims: Sequence[Claim],
    findings: Sequence[Finding],
    pictures: Mapping[str, Sequence[Picture]],
) -> dict[str, Any]:
    """Values of the page."""
    names = dict.fromkeys(finding.experiment for finding in findings)
    return {
        "version": __version__,
        "heading": heading,
        "rows": [row for claim in claims if (row := _row(claim, findings)) is not None],
        "experiments": [_section(heading, name, findings, pictures) for name in names],
    }


def _entry(heading: Heading, finding: Finding) -> Entry:
    header = {
        "system": heading.system,
        "preset": str(finding.facts.get("preset", "")),
        "method": "reproduce",
        "protocol": {"paper": heading.name, **finding.facts},
        "sources": [],
    }
    return Entry(finding.name, slug(finding.name), header, finding.metrics)


def _drawn(finding: Finding) -> list[Picture]:
    drawn = []
    for illustration in finding.pictures:
        with styled():
            drawing = illustration.draw()
        name = f"{slug(finding.name)}-{illustration.name}"
        drawn.append(picture_of(name, illustration.title, illustration.caption, drawing))
    return drawn


def _row(claim: Claim, findings: Sequence[Finding]) -> dict[str, Any] | None:
    """A row of the table, None where its experiment was not run or did not measure it."""
    pooled = [f for f in findings if f.experiment == claim.experiment and f.seed is None]
    if not pooled or claim.metric not in pooled[0].metrics:
        return None
    metric = pooled[0].metrics[claim.metric]
    share = _is_share(claim.experiment, claim.metric, findings)
    met = claim.met(metric)
    return {
        "experiment": claim.experiment,
        "what": claim.what,
        "paper": claim.paper,
        "goal": _goal(claim, metric, share=share),
        "value": _as(metric, metric.value, share=share),
        "range": _range(claim, findings, share=share),
        "counts": f"{words.counts(metric)} in all" if share else "",
        "verdict": "" if met is None else ("met" if met else "missed"),
        "meaning": claim.meaning,
    }


def _is_share(experiment: str, name: str, findings: Sequence[Finding]) -> bool:
    """Whether a figure counts something in every world; its mean over them then is a share too."""
    own = [f for f in findings if f.experiment == experiment and name in f.metrics]
    single = [f for f in own if f.seed is not None] or own
    return all(words.is_rate(finding.metrics[name]) for finding in single)


def _goal(claim: Claim, like: Metric, *, share: bool) -> str:
    bounds = [(claim.least, "\u2265"), (claim.most, "\u2264"), (claim.above, ">")]
    told = (
        f"{sign} {_as(like, value, share=share)}" for value, sign in bounds if value is not None
    )
    return " and ".join(told)


def _range(claim: Claim, findings: Sequence[Finding], *, share: bool) -> str:
    """Least and largest value over the seeds."""
    metrics = [
        f.metrics[claim.metric]
        for f in findings
        if f.experiment == claim.experiment and f.seed is not None and claim.metric in f.metrics
    ]
    if len(metrics) < 2:
        return ""
    low, high = (pick(metric.value for metric in metrics) for pick in (min, max))
    return f"{_as(metrics[0], low, share=share)} to {_as(metrics[0], high, share=share)}"


def _as(like: Metric, value: float, *, share: bool) -> str:
    """A number in the form of a metric of that name, in percent where it is a share."""
    if share:
        return f"{100 * value:.1f}\u202f%"
    return words.number(Metric(like.name, value, 0, 0, like.unit))


def _section(
    heading: Heading,
    name: str,
    findings: Sequence[Finding],
    pictures: Mapping[str, Sequence[Picture]],
) -> dict[str, Any]:
    own = [finding for finding in findings if finding.experiment == name]
    metrics = dict.fromkeys(metric for finding in own for metric in finding.metrics)
    single = [finding for finding in own if finding.seed is not None]
    first = single[0] if single else own[0]
    return {
        "name": name,
        "title": heading.titles.get(name, name),
        "columns": ["mean" if f.seed is None else f"world {f.seed}" for f in own],
        "table": [
            {
                "title": _title(metric),
                "cells": [_cell(f, metric, share=_is_share(name, metric, own)) for f in own],
            }
            for metric in metrics
        ],
        "pictures": [*(pictures[name] if first.name != name else ()), *pictures[first.name]],
        "more": [(f.name, pictures[f.name]) for f in single[1:] if pictures[f.name]],
        "facts": [(key, str(plain(value))) for key, value in first.facts.items()],
    }


def _title(metric: str) -> str:
    """Title of a figure; of one that only a study has, its name with spaces."""
    title = words.title_of(metric)
    return title.replace("_", " ") if title == metric else title


def _cell(finding: Finding, name: str, *, share: bool) -> dict[str, str]:
    if name not in finding.metrics:
        return {"value": "", "counts": ""}
    metric = finding.metrics[name]
    below = words.counts(metric) if share else words.interval(metric)
    return {"value": _as(metric, metric.value, share=share), "counts": below}
