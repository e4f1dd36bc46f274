"""From the paper's text beyond its figures: certainty, remapping, the dark."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.calibration import calibration_error, skill
from fpnav.evaluation.case import Case
from fpnav.execution.walk import Run
from fpnav.experiments.study import Outcome
from fpnav.experiments.tapus.office import choice, drive, mapping_log, test_log
from fpnav.experiments.workshop import Workshop
from fpnav.report.figures import likeness
from fpnav.report.study import Illustration
from fpnav.store.tables import Ragged, SignatureTable
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.model import hand_made
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.reliability import (
    by_alignment,
    by_odometry,
    by_truth,
    calibrated,
    sightings,
)
from fpnav.systems.fingerprint.symbols import unsigned
from fpnav.values import FloatArray, Metric, Signature

STANDS = (
    "Seen again: 0.3 to 1 m further on one of its type stands within 3 degrees of where this one "
    "must, by the true motion and its range, its own or that of the wall between the corners "
    "beside it."
)
MATCHED = (
    "Seen again: the alignment matches it, 0.3 to 1 m further on, with one of its type within 15 "
    "degrees after the turn it found. No pose is asked; what passes at the side turns further."
)
MOVED_DEG = np.array([0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0])
SAMPLES = 60
DARK_M = (1.0, 2.0, 3.0, 5.0)
DARK_EVERY_M = 12.0
"""Of this much travel the last part is driven without light or laser."""


def certainty(shop: Workshop, seed: int) -> Outcome:
    """Stated certainty of features against how often they are seen again.

    Calibrated on the mapping run by odometry, held against the test run by its true poses: other
    noise, light and people. Beside it as extracted; and where "again" means matched by the
    alignment, calibrated so as well.
    """
    runs = [shop.run(log(shop, seed), choice()) for log in (mapping_log, test_log)]
    mapping, test = (list(run.table) for run in runs)
    raw = hand_made(FingerprintParams(**runs[0].header["params"]))
    aligned = by_alignment(Aligner(FingerprintParams(**runs[0].header["params"]), raw))
    by_motion = calibrated(raw, sightings(mapping, raw, by_odometry))
    by_matching = calibrated(raw, sightings(mapping, raw, aligned))
    judged = {
        "certainty": (sightings(test, by_motion, by_truth), STANDS),
        "certainty_raw": (sightings(test, raw, by_truth), f"As extracted. {STANDS}"),
        "certainty_aligned": (sightings(test, by_matching, aligned), MATCHED),
    }
    metrics: list[Metric] = []
    for name, (found, _) in judged.items():
        count = len(found.stated)
        metrics += [
            Metric(f"{name}_ece", calibration_error(found.stated, found.again), count, count),
            Metric(f"{name}_brier_skill", skill(found.stated, found.again), count, count),
        ]
    shown = [
        Illustration(
            name,
            "Stated certainty and what came of it",
            f"Features of the test run, by the certainty stated. {meaning}",
            partial(likeness.reliability, found.stated, found.again),
        )
        for name, (found, meaning) in judged.items()
    ]
    return Outcome(metrics, shown, {"preset": "paper", "calibrated on": "the mapping run"})


def remapping(shop: Workshop, seed: int) -> Outcome:
    """Landmarks moved apart: every second feature turned about the robot, the rest left.

    A place whose landmarks changed their relative position is another place (remapping of place
    cells); measured as prob_matching with what was seen before.
    """
    run = shop.run(mapping_log(shop, seed), choice())
    rows = np.unique(np.linspace(0, len(run.table) - 1, SAMPLES).astype(int))
    seen = [run.table[int(row)] for row in rows]
    alike = np.array(
        [
            [run.system.similarity(one, moved_apart(one, float(np.deg2rad(by)))) for one in seen]
            for by in MOVED_DEG
        ]
    )
    other = np.array([run.system.similarity(a, b) for a, b in pairwise(seen)])
    mean, unlike = alike.mean(axis=1), float(np.median(other))
    half = _crossing(MOVED_DEG, mean, 0.5 * (1.0 + unlike))
    metrics = [
        Metric("remapped_at_deg", half, len(seen), len(seen), "deg"),
        Metric("likeness_of_other_places", unlike, len(other), len(other)),
        *(
            Metric(f"likeness_moved_{by:g}_deg", float(value), len(seen), len(seen))
            for by, value in zip(MOVED_DEG, mean, strict=True)
        ),
    ]
    picture = Illustration(
        "remapping",
        "Landmarks moved apart",
        "prob_matching with what was seen before, over how far every second feature moved; band: "
        "the middle half of the samples. Line: how alike different places are.",
        partial(likeness.over_moves, MOVED_DEG, alike, unlike),
    )
    return Outcome(metrics, [picture], {"preset": "paper", "samples": len(seen)})


def moved_apart(signature: Signature, by_rad: float) -> Signature:
    """A fingerprint whose every second feature stands elsewhere by so much."""
    features = signature.parts["features"].copy()
    features["angle_rad"][::2] = unsigned(features["angle_rad"][::2] + by_rad)
    order = np.lexsort((features["type"], features["angle_rad"]))
    return replace(signature, parts={**signature.parts, "features": features[order]})


def dark(shop: Workshop, seed: int) -> Outcome:
    """Belief by odometry alone: nothing is seen on the last metres of every stretch."""
    driven = drive(shop, seed, "default")
    metrics: list[Metric] = []
    for metres in DARK_M:
        run, unlit = blinded(driven.run, metres)
        last = np.flatnonzero(unlit[:-1] & ~unlit[1:])
        found = driven.without_sight(run, unlit)
        metrics.append(_right_at(found.case, last, f"dark_right_after_{metres:g}m"))
    third = next(metric for metric in metrics if metric.name == "dark_right_after_3m")
    metrics.append(replace(third, name="dark_right"))
    return Outcome(metrics, (), {"preset": "default", "stretch_m": DARK_EVERY_M})


def blinded(run: Run, metres: float) -> tuple[Run, NDArray[np.bool_]]:
    """The run with nothing seen on the last metres of every stretch, and the rows of these."""
    travelled = run.table.references["travelled_m"]
    unlit = travelled % DARK_EVERY_M >= DARK_EVERY_M - metres
    return Run(run.header, _without_sight(run.table, unlit), run.system), unlit


def _without_sight(table: SignatureTable, rows: NDArray[np.bool_]) -> SignatureTable:
    records = table.records.copy()
    records[rows] = np.zeros(1, records.dtype)
    parts = {
        name: Ragged.of(
            [part[row][:0] if rows[row] else part[row] for row in range(len(table))],
            part.flat.dtype,
        )
        for name, part in table.parts.items()
    }
    return SignatureTable(table.references, records, parts)


def _right_at(case: Case, rows: NDArray[np.int64], name: str) -> Metric:
    right = case.within(case.result.places[:, :1], tolerant=True)[rows]
    known = case.has_match[rows]
    n, of = int((right & known).sum()), int(known.sum())
    return Metric(name, n / max(of, 1), n, of)


def _crossing(x: FloatArray, falling: FloatArray, level: float) -> float:
    """Where a falling curve first passes a level; its end where it does not."""
    below = np.flatnonzero(falling <= level)
    if not len(below) or below[0] == 0:
        return float(x[-1] if not len(below) else x[0])
    i = int(below[0])
    share: Any = (falling[i - 1] - level) / (falling[i - 1] - falling[i])
    return float(x[i - 1] + share * (x[i] - x[i - 1]))
