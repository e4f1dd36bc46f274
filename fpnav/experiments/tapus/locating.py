"""A3, A4, A6, A7: a robot located by matching alone, by belief, and after it was kidnapped."""

from __future__ import annotations

from fpnav.experiments.study import Outcome
from fpnav.experiments.tapus import pictures
from fpnav.experiments.tapus.office import JUMPS, drive, figures
from fpnav.experiments.workshop import Workshop
from fpnav.localization.locate import Method
from fpnav.values import Metric

ACCURACY = (
    "place_accuracy_top1",
    "place_accuracy_top1_tolerant",
    "place_accuracy_top3",
    "place_accuracy_top3_tolerant",
)
BELIEF = (
    "mission_success",
    "mission_success_tolerant",
    "place_accuracy_settled",
    "place_accuracy_settled_tolerant",
)


def matching(shop: Workshop, seed: int) -> Outcome:
    """A3, A6, A7 with the published algorithm: every sample matched on its own."""
    return _matching(shop, seed, "paper")


def matching_default(shop: Workshop, seed: int) -> Outcome:
    """The same with what this project would use."""
    return _matching(shop, seed, "default")


def _matching(shop: Workshop, seed: int, preset: str) -> Outcome:
    (found,) = drive(shop, seed, preset).located(Method.MATCH)
    metrics = figures(found, *ACCURACY, "heading_error_median_deg", "field_rho", "places", "ece")
    plan = pictures.located_plan(f"A3 {preset}", found)
    return Outcome(metrics, [plan], {"preset": preset, "samples": len(found.table)})


def belief(shop: Workshop, seed: int) -> Outcome:
    """A4: the same run with a belief carried along, filtered and smoothed."""
    return _belief(shop, seed, "paper")


def belief_default(shop: Workshop, seed: int) -> Outcome:
    """The same with what this project would use."""
    return _belief(shop, seed, "default")


def _belief(shop: Workshop, seed: int, preset: str) -> Outcome:
    filtered, smoothed = drive(shop, seed, preset).located(Method.FILTER, Method.SMOOTH)
    metrics = [*figures(filtered, *BELIEF), *figures(smoothed, *BELIEF, suffix="_smooth")]
    shown = [pictures.belief_over_run(filtered), pictures.located_plan("By filter", filtered)]
    return Outcome(metrics, shown, {"preset": preset})


def set_down_elsewhere(shop: Workshop, seed: int) -> Outcome:
    """The robot set down elsewhere ten times: how soon does the belief know?"""
    metrics: list[Metric] = []
    for preset, suffix in (("paper", ""), ("default", "_default")):
        found = drive(shop, seed, preset).set_down(2 if shop.small else JUMPS)
        metrics += figures(found, "kidnap_recovered_3m", "kidnap_recovery_m", suffix=suffix)
    return Outcome(metrics, (), {"preset": "paper", "belief": "filter"})
