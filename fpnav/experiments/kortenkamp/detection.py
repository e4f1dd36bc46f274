"""Gateways found by sonar: where, along which way, of which type (figure 3, the paper's errors)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from fpnav.evaluation.gateways import (
    Survey,
    errors_m,
    errors_rad,
    gateway_found,
    gateway_invented,
    gateway_type_accuracy,
    gateway_within_3_5deg,
    gateway_within_70mm,
    gateways_met,
    surveyed,
)
from fpnav.experiments.kortenkamp.tours import TEST, Traversal, choice, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.report.figures import gateways as drawing
from fpnav.report.study import Illustration
from fpnav.values import Metric


def detection(shop: Workshop, seed: int) -> Outcome:
    """C1: every gateway of eighteen traversals, by two thresholds; and of three by evidence."""
    drives = traversals(shop, seed, choice())
    other = traversals(shop, seed, choice(detector="evidence", side_deg=5.0), runs=[TEST])
    surveys = [drive.survey for drive in drives]
    metrics = [
        *figures_of(surveys),
        *renamed(figures_of([d.survey for d in drives if d.number == TEST]), "test"),
        *renamed(figures_of([drive.survey for drive in other]), "evidence"),
        *renamed([gateway_within_70mm([_by_plan(drive) for drive in drives])], "plan"),
    ]
    facts = {"preset": "paper", "traversals": len(drives)}
    return Outcome(metrics, _pictures(drives), facts, surveys)


def _by_plan(drive: Traversal) -> Survey:
    """The same against the plan's own marks, rooms counted from the middle line of their wall."""
    return surveyed(drive.survey.found, gateways_met(drive.run.header["worlds"][0], drive.route))


def figures_of(surveys: Sequence[Survey]) -> list[Metric]:
    """All figures of merit of some drives."""
    return [
        gateway_found(surveys),
        gateway_invented(surveys),
        gateway_within_70mm(surveys),
        gateway_within_3_5deg(surveys),
        gateway_type_accuracy(surveys),
        _quantile("gateway_error_m_p95", np.abs(errors_m(surveys)), "m"),
        _quantile("gateway_error_deg_p95", np.rad2deg(np.abs(errors_rad(surveys))), "deg"),
    ]


def renamed(metrics: Sequence[Metric], ending: str) -> list[Metric]:
    """The same figures under names of their own."""
    return [
        Metric(f"{m.name}_{ending}", m.value, m.n, m.of, m.unit, m.low, m.high) for m in metrics
    ]


def _quantile(name: str, values: np.ndarray, unit: str) -> Metric:
    value = float(np.quantile(values, 0.95)) if len(values) else float("nan")
    return Metric(name, value, len(values), len(values), unit)


def _pictures(drives: Sequence[Traversal]) -> list[Illustration]:
    world = drives[0].run.header["worlds"][0]
    tests = [drive for drive in drives if drive.number == TEST]
    return [
        Illustration(
            "plan", "Figure 3 here: the experimental space",
            "Walls, the three routes from their starts, and the gateways that the test traversals "
            "found, each with the direction of travel.",
            partial(drawing.plan, world, [(drive.route, drive.survey) for drive in tests]),
        ),
    ]  # fmt: skip


def together(surveys: Sequence[Sequence[Survey]]) -> list[Illustration]:
    """Where the gateways of all worlds were found."""
    flat = [survey for some in surveys for survey in some]
    caption = (
        "Every gateway of eighteen traversals in every world; the box is what the paper's robot "
        "stopped within."
    )
    return [
        Illustration(
            "errors",
            "Where the gateways were found",
            caption,
            partial(drawing.errors, errors_m(flat), errors_rad(flat)),
        )
    ]
