"""The model of a mapping run: certainties calibrated and scores learned where asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.learning import learned_scores
from fpnav.systems.fingerprint.model import Model, hand_made
from fpnav.systems.fingerprint.pairs import far_pairs, near_pairs
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.reliability import (
    Rule,
    by_alignment,
    by_odometry,
    calibrated,
    sightings,
)
from fpnav.values import Signature


def fitted(signatures: Sequence[Signature], params: FingerprintParams) -> Model:
    """Model of the parameters, with what they ask to be learned from the run.

    A run too short to hold pairs of both kinds leaves the hand-made scores.
    """
    model = hand_made(params)
    if params.certainty == "calibrated":
        model = _calibrated(signatures, params, model)
    if params.scores == "learned":
        model = _rescored(signatures, params, model)
    return model


def following_rule(signatures: Sequence[Signature], aligner: Aligner) -> Rule:
    """How features of a run are followed: by odometry and ranges, else by the alignment."""
    placed = all(one.reference.odometry is not None for one in signatures)
    ranged = any(np.isfinite(one.parts["features"]["range_m"]).any() for one in signatures)
    return by_odometry if placed and ranged else by_alignment(aligner)


def _calibrated(signatures: Sequence[Signature], params: FingerprintParams, model: Model) -> Model:
    rule = following_rule(signatures, Aligner(params, model))
    return calibrated(model, sightings(signatures, model, rule))


def _rescored(signatures: Sequence[Signature], params: FingerprintParams, model: Model) -> Model:
    references = [one.reference for one in signatures]
    near, far = near_pairs(references), far_pairs(references)
    if len(near) == 0 or len(far) == 0:
        return model
    bare = Aligner(params, replace(model, weights=np.ones(len(model.weights))))
    scores, weights, symbols = learned_scores(
        bare.strings(signatures), near, far, model.scores, model.weights
    )
    evidence = np.array([len(near), len(far), symbols, model.evidence[3]], np.int64)
    return replace(model, scores=scores, weights=weights, evidence=evidence)
