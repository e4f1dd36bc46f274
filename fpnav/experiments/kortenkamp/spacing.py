"""Scenes only where sonar says so, against scenes at regular spacing as in homing by views."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import TruthError
from fpnav.evaluation.gateways import rate, told_apart
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.kortenkamp.learned import learned
from fpnav.experiments.kortenkamp.recognition import OURS, ROUTE, recognition
from fpnav.experiments.kortenkamp.tours import TEST, choice, job, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.params import Tables
from fpnav.systems.gateway.evidence import scene_scores
from fpnav.systems.gateway.model import observed
from fpnav.systems.gateway.params import LATE
from fpnav.values import FloatArray, Metric, Signature

TRAINING = 1
SPACING_M = 1.0
ALL_ALONG: Tables = {"capture": {"images_every": 20, "images_near_m": 0.0}}
"""A picture every twentieth data set, a metre."""


def spacing(shop: Workshop, seed: int) -> Outcome:
    """C12: one guided traversal stored both ways, the next one told by its scenes."""
    ours = {name: getattr(OURS, name) for name in LATE}
    drives = traversals(shop, seed, choice(**ours), [ROUTE], (TRAINING, TEST))
    places = learned(drives, OURS)
    at_gateways = recognition(places, OURS)
    own = np.arange(len(places.names))
    spaced = choice(keep="spacing", spacing_m=SPACING_M, look="always", **ours)
    stored, test = _runs(shop, seed, spaced)
    models = [observed(None, one, OURS) for one in stored.table]
    scores = scene_scores(list(test.table), models, OURS)
    near = _apart(test.table, stored.table)[np.arange(len(scores)), scores.argmax(axis=1)]
    known = int((near <= SPACING_M).sum())
    metrics = [
        told_apart("gateways_by_scene", at_gateways.vision, own),
        told_apart("gateways_by_both", at_gateways.both, own),
        rate("spaced_by_scene", known, len(scores)),
        Metric("scenes_at_gateways", float(len(own)), len(own), len(own), "scenes"),
        Metric("scenes_spaced", float(len(models)), len(models), len(models), "scenes"),
    ]
    facts = {"preset": "default, on the paper's signatures", "guided traversals": 1}
    return Outcome(metrics, (), facts)


def _runs(shop: Workshop, seed: int, chosen: SystemChoice) -> list[Run]:
    return shop.runs([job(seed, ROUTE, run, ALL_ALONG) for run in (TRAINING, TEST)], chosen)


def _apart(first: Sequence[Signature], second: Sequence[Signature]) -> FloatArray:
    """Distance between where scenes were taken, (N, M); those taken another way are far apart."""
    ours, theirs = _poses(first), _poses(second)
    away = np.hypot(*(ours[:, None, :2] - theirs[None, :, :2]).transpose(2, 0, 1))
    turned = np.cos(ours[:, None, 2] - theirs[None, :, 2]) < np.sqrt(0.5)
    return np.where(turned, np.inf, away)


def _poses(signatures: Sequence[Signature]) -> NDArray[np.float64]:
    truths = [signature.reference.truth for signature in signatures]
    if any(truth is None for truth in truths):
        raise TruthError("scenes are compared by the true pose of the robot; the log has none")
    return np.array([(t.x_m, t.y_m, t.heading_rad) for t in truths if t is not None])
