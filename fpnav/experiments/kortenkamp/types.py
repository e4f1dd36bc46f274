"""All 25 types of gateways, each met in a building of its own (the paper names four)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from fpnav.errors import LogError
from fpnav.evaluation.gateways import Gateways, Survey, confusion, gateways_met, surveyed
from fpnav.execution.walk import SystemChoice
from fpnav.experiments.kortenkamp.detection import figures_of, renamed
from fpnav.experiments.kortenkamp.tours import choice, found_in, world_of_job
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.report.figures import gateways as drawing
from fpnav.report.study import Illustration
from fpnav.sim.record import Job
from fpnav.sim.worlds.gateway_types import ROUTES
from fpnav.systems.gateway.types import KINDS
from fpnav.values import Metric

WORLD = "gateway_types"
NAMES = tuple(kind.name for kind in KINDS)
FEW = 5
"""Every so manieth type is met in a small reproduction."""

NOTHING = Gateways(np.zeros((0, 3)), (), ())


def types(shop: Workshop, seed: int) -> Outcome:
    """C8: found and classified, by two thresholds and by evidence."""
    surveys = _surveys(shop, seed, choice())
    table = confusion(surveys, NAMES)
    seen = int((np.diag(table) > 0).sum())
    metrics = [
        *figures_of(surveys),
        _accuracy("type_accuracy_of_all", table),
        Metric("types_told", seen / len(NAMES), seen, len(NAMES)),
        *renamed(figures_of(_surveys(shop, seed, choice("default"))), "default"),
    ]
    return Outcome(metrics, (), {"preset": "paper", "world": WORLD}, table)


def together(tables: Sequence[Any]) -> list[Illustration]:
    """The confusion table over all worlds."""
    total = np.sum(tables, axis=0)
    title = "Types over all worlds"
    caption = "Down the side the true type, across what the two thresholds made of it."
    return [Illustration("types", title, caption, partial(drawing.confusion, total, NAMES))]


def _accuracy(name: str, table: Any) -> Metric:
    """Right of all there are, those not found counted as wrong."""
    right, total = int(np.trace(table)), int(table.sum())
    return Metric(name, right / total, right, total)


def _surveys(shop: Workshop, seed: int, chosen: SystemChoice) -> list[Survey]:
    routes = ROUTES[::FEW] if shop.small else ROUTES
    jobs = [job_of(WORLD, route, seed, 1) for route in routes]
    shop.make(jobs, chosen)
    return [_survey(shop, job, chosen) for job in jobs]


def _survey(shop: Workshop, job: Job, chosen: SystemChoice) -> Survey:
    """What was found on a route; a log without any gateway has no signatures."""
    truth = gateways_met(world_of_job(job), job.route)
    try:
        return surveyed(found_in(shop.run(shop.log(job), chosen)), truth)
    except LogError:
        return surveyed(NOTHING, truth)
