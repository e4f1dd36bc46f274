"""Which place is it? Scenes alone, gateways alone, both (tables 1 to 3), and a gateway misread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fpnav.evaluation.gateways import error_corrected, least_margin, told_apart
from fpnav.experiments.kortenkamp.learned import Learned, learned
from fpnav.experiments.kortenkamp.tours import choice, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.report.figures import gateways as drawing
from fpnav.report.study import Illustration
from fpnav.systems.gateway.bayes import normalised, posterior, vision_likelihood
from fpnav.systems.gateway.memory import GatewayMemory
from fpnav.systems.gateway.params import PRESETS, GatewayParams
from fpnav.values import FloatArray, Metric

PARAMS: GatewayParams = PRESETS["paper"]
OURS: GatewayParams = PRESETS["default"]
ROUTE = "route-1"
"""The route that meets all seven gateways: one forward scene and one type for each of them."""

ALIKE, UNIQUE = ("B", "C", "D"), ("A", "E", "F", "G")
MISREAD, MISREAD_AS = "D", "RIGHT ROOM"
Facts = Mapping[str, Any]
FACTS: Facts = {"preset": "paper", "route": ROUTE, "places": 7, "guided traversals": 5}


@dataclass(frozen=True, slots=True, eq=False)
class Recognition:
    """Likelihoods of seven places (columns) at each of them (rows), in the paper's order."""

    names: tuple[str, ...]
    vision: FloatArray
    sonar: FloatArray
    both: FloatArray


def vision_only(shop: Workshop, seed: int) -> Outcome:
    """C3, table 1: the scene alone."""
    seen = recognition(_places(shop, seed))
    picture = _table("vision", "Table 1 here: scenes only", seen.names, seen.vision)
    return Outcome([_told("vision_only", seen.vision)], [picture], FACTS)


def sonar_only(shop: Workshop, seed: int) -> Outcome:
    """C4, table 2: the type of the gateway alone."""
    seen = recognition(_places(shop, seed))
    picture = _table("sonar", "Table 2 here: gateways only", seen.names, seen.sonar)
    own = _told("sonar_only", seen.sonar)
    return Outcome([own, _alike_told(seen)], [picture], FACTS)


def combined(shop: Workshop, seed: int) -> Outcome:
    """C5, table 3: both, weighed equally."""
    return _combined(_places(shop, seed), PARAMS, {**FACTS, "preset": "paper"})


def combined_default(shop: Workshop, seed: int) -> Outcome:
    """C5 with the soft matcher, its scores to a power learned on other worlds."""
    return _combined(_places(shop, seed), OURS, {**FACTS, "preset": "default"})


def sonar_error(shop: Workshop, seed: int) -> Outcome:
    """C6: D misread as RIGHT ROOM, which E is."""
    return _misread(_places(shop, seed), PARAMS, {**FACTS, "preset": "paper"})


def sonar_error_default(shop: Workshop, seed: int) -> Outcome:
    """C6 with the soft matcher."""
    return _misread(_places(shop, seed), OURS, {**FACTS, "preset": "default"})


def _combined(places: Learned, params: GatewayParams, facts: Facts) -> Outcome:
    seen = recognition(places, params)
    told = _told("combined", seen.both)
    rows = [seen.names.index(name) for name in UNIQUE]
    alike = np.array([seen.names.index(name) for name in ALIKE])
    metrics = [
        told,
        _told("vision_only", seen.vision),
        Metric("combined_all", float(told.n == told.of), int(told.n == told.of), 1),
        Metric("posterior_unique_least", float(seen.both[rows, rows].min()), 1, 1),
        least_margin("posterior_alike_margin", seen.both[alike], alike),
        Metric("product_rule_gap", _gap(places, seen, params), 7, 7),
    ]
    picture = _table("both", "Table 3 here: scenes and gateways", seen.names, seen.both)
    return Outcome(metrics, [picture], facts)


def _misread(places: Learned, params: GatewayParams, facts: Facts) -> Outcome:
    plain = recognition(places, params)
    seen = recognition(places.misread(MISREAD, MISREAD_AS), params)
    row, other = seen.names.index(MISREAD), seen.names.index("E")
    metrics = [
        error_corrected(seen.both[row], row),
        Metric("posterior_D", float(seen.both[row, row]), 1, 1),
        Metric("posterior_E", float(seen.both[row, other]), 1, 1),
        Metric("sonar_D", float(seen.sonar[row, row]), 1, 1),
        Metric("sonar_E", float(seen.sonar[row, other]), 1, 1),
    ]
    rows = np.array([plain.both[row], seen.vision[row], seen.sonar[row], seen.both[row]])
    labels = ("read right, both", "scene", "gateway misread", "misread, both")
    caption = "Likelihoods of the seven places where the robot stands at D."
    title = "The misread gateway here"
    picture = Illustration(
        "misread", title, caption, partial(drawing.likelihoods, rows, labels, seen.names)
    )
    return Outcome(metrics, [picture], {**facts, "misread": f"{MISREAD} as {MISREAD_AS}"})


def normalisation(shop: Workshop, seed: int) -> Outcome:
    """C7: match percentages become likelihoods as in the paper's example."""
    found = vision_likelihood([0.25, 0.90, 0.75], PARAMS.floor)
    # The paper prints .3947 as .40, so that its three numbers add up to one.
    gap = float(np.abs(found - [0.13, 0.47, 0.40]).max())
    return Outcome([Metric("normalisation_gap", gap, 3, 3)], (), {"preset": "paper"})


def recognition(places: Learned, params: GatewayParams = PARAMS) -> Recognition:
    """The three tables of the paper, from what was learned and seen."""
    order = np.argsort(np.array(places.names), kind="stable")
    square = np.ix_(order, order)
    scenes = vision_likelihood(places.scores(params), params.floor)
    vision = normalised(scenes**params.vision_power)[square]
    sonar = normalised(places.sonar(params) ** params.sonar_power)[square]
    both = posterior(np.ones(len(order)), vision, sonar)
    missing = [test is None for test in places.tests]
    for table in (vision, sonar, both):
        table[np.array(missing)[order]] = 0.0
    return Recognition(tuple(places.names[row] for row in order), vision, sonar, both)


def _places(shop: Workshop, seed: int) -> Learned:
    return learned(traversals(shop, seed, choice(), [ROUTE]), PARAMS)


def _told(name: str, table: FloatArray) -> Metric:
    return told_apart(name, table, np.arange(len(table)))


def _alike_told(seen: Recognition) -> Metric:
    """Of B, C and D those sonar tells: none, unless their types were misread."""
    rows = np.array([seen.names.index(name) for name in ALIKE])
    return told_apart("sonar_alike_told", seen.sonar[rows], rows)


def _gap(places: Learned, seen: Recognition, params: GatewayParams) -> float:
    """Largest difference of what the system answers from the product of the two tables."""
    order = np.argsort(np.array(places.names), kind="stable")
    memory = GatewayMemory(params)
    memory.load(places.memory.save())
    gap = 0.0
    for row, place in enumerate(order):
        test = places.tests[int(place)]
        if test is None:
            continue
        recall, _ = memory.recall([test], len(order), None, None)
        answer = np.zeros(len(order))
        answer[recall.places[0]] = np.exp(recall.scores[0] - recall.scores[0].max())
        gap = max(gap, float(np.abs(answer[order] / answer.sum() - seen.both[row]).max()))
    return gap


def _table(name: str, title: str, names: tuple[str, ...], table: FloatArray) -> Illustration:
    caption = "Down the side where the robot is, across the top the stored places."
    return Illustration(name, title, caption, partial(drawing.likelihoods, table, names, names))
