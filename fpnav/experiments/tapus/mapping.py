"""A1, A2, A5: the map of a building, where its places start, and whether its loops close."""

from __future__ import annotations

from pathlib import Path

from fpnav.evaluation.evaluate import Evaluation
from fpnav.execution.walk import SystemChoice
from fpnav.experiments.study import Outcome
from fpnav.experiments.tapus import pictures
from fpnav.experiments.tapus.office import (
    choice,
    figures,
    located,
    loop_log,
    mapping_log,
    sampled,
)
from fpnav.experiments.workshop import Workshop
from fpnav.localization.locate import Method
from fpnav.values import Metric

_STARTS = ("node_precision", "node_precision_front", "node_recall", "node_recall_front",
           "nodes_at_closed_doors", "nodes_at_closed_doors_front")  # fmt: skip
PLACEMENT = (*(name for start in _STARTS for name in (start, f"{start}_chance")), "places")
"""Where places start, each figure beside what chance gives."""


def mapping_run(shop: Workshop, seed: int) -> Outcome:
    """A1: 75 m, 500 data sets, and the shape of the map that comes of them."""
    log, chosen = mapping_log(shop, seed), choice()
    mapped = shop.map(log, chosen)
    found = _of_map(shop, log, chosen)
    sets = len(mapped[1].signatures)
    metrics = [
        *figures(found, "places", "topology_equal"),
        Metric("data_sets", float(sets), sets, sets),
        Metric("travelled_m", float(mapped[1].signatures.references["travelled_m"][-1]), 1, 1, "m"),
    ]
    shown = [
        pictures.generation(log, mapped),
        pictures.new_node(log, mapped),
        pictures.floor_plan(log, mapped),
        pictures.scan_map(log, mapped),
    ]
    return Outcome(metrics, shown, {"preset": "paper", "theta": mapped[1].threshold})


def node_placement(shop: Workshop, seed: int) -> Outcome:
    """A2: do places start at doors and changes, and nowhere because of a closed door?"""
    metrics: list[Metric] = []
    for preset, suffix in (("paper", ""), ("default", "_default")):
        found = _of_map(shop, mapping_log(shop, seed), choice(preset))
        metrics += figures(found, *PLACEMENT, suffix=suffix)
    return Outcome(metrics, (), {"preset": "paper"})


def loops(shop: Workshop, seed: int) -> Outcome:
    """A5: a way that comes back; each seed another one of the five."""
    log = loop_log(shop, seed)
    found = _of_map(shop, log, choice())
    metrics = figures(found, "loop_recall", "loop_precision", "places")
    plan = pictures.loop_plan(log, shop.map(log, choice()))
    return Outcome(metrics, [plan], {"preset": "paper", "way": log.name.split("-")[2]})


def _of_map(shop: Workshop, log: Path, chosen: SystemChoice) -> Evaluation:
    """What can be said of a map; asked on it is a little of its own run."""
    (found,) = located(sampled(shop.run(log, chosen), 20), shop.map(log, chosen), Method.MATCH)
    return found
