"""What each part of the method is worth, and how much hangs on its weakest assumptions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from fpnav.execution.stages import make_map
from fpnav.execution.walk import Run, SystemChoice, make_system
from fpnav.experiments.study import Outcome
from fpnav.experiments.tapus.office import (
    choice,
    figures,
    located,
    mapping_log,
    renamed,
    sampled,
    test_log,
)
from fpnav.experiments.workshop import Workshop
from fpnav.localization.locate import Method
from fpnav.store.tables import Ragged, SignatureTable
from fpnav.systems.fingerprint import Fingerprint
from fpnav.values import Metric

FEWER = 250
"""Samples of the test run that are asked here: variants are compared with one another."""

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    "paper": {},
    "without_uncertainty": {"certainty": "flat"},
    "without_f": {"use_f": False},
    "without_colour": {"use_colour": False},
    "plain_needleman_wunsch": {"scores": "plain", "certainty": "flat"},
    "learned_scores": {"scores": "learned"},
    "exemplars": {"exemplars": 3},
}

SENSITIVITY: Mapping[str, Mapping[str, Any]] = {
    "n_15_deg": {"delta_n_deg": 15.0},
    "n_30_deg": {"delta_n_deg": 30.0},
    "f_within_2_deg": {"pair_deg": 2.0},
    "f_within_5_deg": {"pair_deg": 5.0},
    "gamma_0.25": {"gamma": 0.25},
    "gamma_0.9": {"gamma": 0.9},
}
"""Of systems.md 4.9: the quantum of n, the place of f, the scores; theta beside them."""


def ablations(shop: Workshop, seed: int) -> Outcome:
    """Matching alone without and with parts of the method."""
    metrics: list[Metric] = []
    for name, changes in ABLATIONS.items():
        metrics += _matched(shop, seed, name, choice(**changes))
    return Outcome(metrics, (), {"preset": "paper", "samples": FEWER})


def sensitivity(shop: Workshop, seed: int) -> Outcome:
    """Matching alone with other values where the paper gives none."""
    theta = msgspec.structs.asdict(Fingerprint.PRESETS["paper"])["theta"]
    metrics: list[Metric] = []
    for by in (-0.05, 0.05):
        chosen = choice(theta=round(theta + by, 6))
        metrics += _matched(shop, seed, f"theta_{by:+.2f}", chosen)
    for name, changes in SENSITIVITY.items():
        metrics += _matched(shop, seed, name, choice(**changes))
    return Outcome(metrics, (), {"preset": "paper", "samples": FEWER, "theta": theta})


def _matched(shop: Workshop, seed: int, name: str, chosen: SystemChoice) -> list[Metric]:
    """Matching alone under other parameters, on what was extracted once.

    Places are cut anew; only the way back over known ground is joined, no long loops.
    """
    log = mapping_log(shop, seed)
    header, built = make_map(
        _variant(shop, log, chosen),
        [log],
        guided=False,
        close_loops=True,
        tables={"loops": {"rounds": 0}},
        advance=lambda done: None,
    )
    run = sampled(_variant(shop, test_log(shop, seed), chosen), FEWER)
    (found,) = located(run, (header, built), Method.MATCH)
    return [*_accuracy(found.metrics, name), *figures(found, "places", suffix=f"_{name}")]


def _variant(shop: Workshop, log: Path, chosen: SystemChoice) -> Run:
    """The paper's features under other parameters: symbols are put in anew, hues left out."""
    run = shop.run(log, choice())
    system, preset = make_system(chosen)
    params = msgspec.to_builtins(system.params)
    table = run.table if params["use_colour"] else _without_colour(run.table)
    return Run({**run.header, "preset": preset, "params": params}, table, system)


def _without_colour(table: SignatureTable) -> SignatureTable:
    features = table.parts["features"]
    rows = [row[row["type"] >= b"a"] for row in (features[i] for i in range(len(features)))]
    kept = Ragged.of(rows, features.flat.dtype)
    return SignatureTable(table.references, table.records, {**table.parts, "features": kept})


def _accuracy(metrics: Mapping[str, Metric], name: str) -> list[Metric]:
    wanted = {"place_accuracy_top1": "strict", "place_accuracy_top1_tolerant": "tolerant"}
    return [
        renamed(metrics[metric], f"top1_{kind}_{name}")
        for metric, kind in wanted.items()
        if metric in metrics
    ]
