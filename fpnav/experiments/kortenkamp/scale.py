"""Fifty gateways, ten of them alike: what holds up when places become many."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.gateways import rate, told_apart
from fpnav.execution.stages import make_map
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.kortenkamp.tours import NEAR, TEST, Traversal, choice, job, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.localization.filter import FilterParams, Transitions, filter_belief, make_steps
from fpnav.localization.recall import by_place, recall_all
from fpnav.params import Tables
from fpnav.store.maps import BuiltMap
from fpnav.systems.gateway.params import LATE, PRESETS
from fpnav.systems.gateway.types import NAMES
from fpnav.values import FloatArray, Metric

GATEWAYS, ALIKE = 50, 10
SMALL = 10, 4
"""Gateways, and how many of them are alike; fewer in a small reproduction."""

ROUTE, TRAINING = "route-1", 1
AFTER = 3
"""Gateways the filter has met, set down anywhere, when it must know where it is."""

LIKE = NAMES.index("RIGHT OPENING")


def scale(shop: Workshop, seed: int) -> Outcome:
    """C9: one guided traversal is the map; on the test every gateway alone, and after three."""
    return _scale(shop, seed, choice(), "paper")


def scale_default(shop: Workshop, seed: int) -> Outcome:
    """C9 with what the default preset makes of the same gateways and scenes."""
    ours = {name: getattr(PRESETS["default"], name) for name in LATE}
    return _scale(shop, seed, choice("paper", **ours), "default, on the paper's signatures")


def _scale(shop: Workshop, seed: int, chosen: SystemChoice, preset: str) -> Outcome:
    count, like = SMALL if shop.small else (GATEWAYS, ALIKE)
    tables: Tables = {**NEAR, "world": {"gateways": count, "alike": like}}
    learned, test = traversals(shop, seed, chosen, [ROUTE], (TRAINING, TEST), tables)
    log = shop.log(job(seed, ROUTE, TRAINING, tables))
    likelihood, own, built = _seen(log, learned, test)
    rows = np.flatnonzero(own >= 0)
    alike = rows[np.array([test.run.table.records["type"][row] == LIKE for row in rows], bool)]
    single = told_apart("scale_alone", likelihood[rows], own[rows])
    metrics = [
        single,
        told_apart("scale_alone_alike", likelihood[alike], own[alike]),
        *(_after(likelihood, own, test.run, built, count) for count in (2, AFTER, 5)),
    ]
    found = int((learned.survey.partner >= 0).sum())
    metrics.append(rate("scale_learned", found, len(learned.survey.truth)))
    facts = {"preset": preset, "gateways": count, "alike": like, "guided traversals": 1}
    return Outcome(metrics, (), facts)


def _seen(
    log: Path, learned: Traversal, test: Traversal
) -> tuple[FloatArray, NDArray[np.int64], BuiltMap]:
    """Likelihood of every place at every query (Q, P); the column of its own, -1 none; the map."""
    _, built = make_map(
        learned.run, [log], guided=True, close_loops=False, advance=lambda done: None
    )
    system = learned.run.system
    memory = system.memory()
    memory.load(built.memory)
    queries = test.run.table
    recall = recall_all(memory, queries, len(built.topomap), None, lambda done: None)
    scores, _ = by_place(recall, built.topomap.ids)
    owner = built.topomap.owner(len(built.signatures))
    place = {
        int(gateway): int(owner[row])
        for row, gateway in enumerate(learned.survey.partner.tolist())
        if gateway >= 0
    }
    own = np.array([place.get(gateway, -1) for gateway in test.survey.partner.tolist()])
    column = {int(place): number for number, place in enumerate(built.topomap.ids)}
    return system.likelihood(scores), np.array([column.get(int(p), -1) for p in own]), built


def _after(
    likelihood: FloatArray, own: NDArray[np.int64], run: Run, built: BuiltMap, count: int
) -> Metric:
    """Share of the gateways known after ``count`` of them, the robot set down anywhere before."""
    transitions = Transitions.of(built.topomap, FilterParams())
    references = [signature.reference for signature in run.table]
    headings = np.full(likelihood.shape, np.nan)
    steps = make_steps(transitions, references, headings)
    ends = [row for row in range(count - 1, len(own)) if own[row] >= 0]
    beliefs = [
        filter_belief(likelihood[row - count + 1 : row + 1], steps[row - count + 1 : row])[-1]
        for row in ends
    ]
    return told_apart(f"scale_after_{count}", np.array(beliefs), own[ends])
