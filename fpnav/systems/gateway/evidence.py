"""How well places fit what is seen: evidence of the scene and of the gateway, and their product."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fpnav.matching.scenes import Scenes, Soft, match_scores, scenes_of, soft_scores
from fpnav.systems.gateway import asr
from fpnav.systems.gateway.bayes import log_evidence
from fpnav.systems.gateway.model import PlaceModel, shown
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.types import NONE, sonar_weights
from fpnav.values import FloatArray, Signature

SONAR = sonar_weights()


def evidence_of(
    signatures: Sequence[Signature], places: Sequence[PlaceModel], params: GatewayParams
) -> FloatArray:
    """Log evidence (Q, P) of every place: scene and gateway, each to its power; finite."""
    vision = vision_evidence(signatures, places, params)
    sonar = sonar_evidence(signatures, places, params)
    return params.vision_power * vision + params.sonar_power * log_evidence(sonar)


def vision_evidence(
    signatures: Sequence[Signature], places: Sequence[PlaceModel], params: GatewayParams
) -> FloatArray:
    """Log evidence (Q, P) of the scenes; 0 throughout where a signature has none."""
    if params.likelihoods == "learned":
        values = _cell_evidence(signatures, places)
    else:
        scores = scene_scores(signatures, places, params)
        values = log_evidence(np.where(scores > 0.0, scores, params.floor))
    looked = np.array([int(one.record["facings"]) != 0 for one in signatures], bool)
    return np.where(looked[:, None], values, 0.0)


def scene_scores(
    signatures: Sequence[Signature], places: Sequence[PlaceModel], params: GatewayParams
) -> FloatArray:
    """Match scores (Q, P) of the signatures' scenes with the stable cues of the places."""
    kept = [asr.stable(place.scene, params) for place in places]
    stored = scenes_of(
        [cues for cues, _ in kept],
        [place.scene.facings for place in places],
        [weights for _, weights in kept],
    )
    return _compare(_scenes(signatures), stored, params)


def sonar_evidence(
    signatures: Sequence[Signature], places: Sequence[PlaceModel], params: GatewayParams
) -> FloatArray:
    """Likelihood (Q, P) of the gateways' classification, not normalised; 1 where there is none."""
    codes = np.array([int(one.record["type"]) for one in signatures], dtype=np.int64)
    types = np.array([place.type for place in places], dtype=np.int64)
    table = SONAR[np.ix_(codes, types)] + params.smooth
    if params.likelihoods == "learned":
        table = _classified(codes, places, params)
    silent = (codes == NONE)[:, None] | (types == NONE)[None, :]
    return np.where(silent, 1.0, table)


def likeness(first: Signature, second: Signature, params: GatewayParams) -> float:
    """How alike two signatures are, in [0, 1]: scenes both ways, times the sonar table."""
    both = _scenes([first, second])
    scores = _compare(both, both, params)
    sonar = SONAR[int(first.record["type"]), int(second.record["type"])]
    own = float(np.sqrt(scores[0, 0] * scores[1, 1]))
    if own > 0.0:
        scene = min(1.0, 0.5 * float(scores[0, 1] + scores[1, 0]) / own)
    else:
        scene = float(len(first.parts["cues"]) == len(second.parts["cues"]))
    return float(sonar) * max(scene, params.floor)


def _scenes(signatures: Sequence[Signature]) -> Scenes:
    return scenes_of(
        [one.parts["cues"] for one in signatures],
        [int(one.record["facings"]) for one in signatures],
    )


def _compare(present: Scenes, stored: Scenes, params: GatewayParams) -> FloatArray:
    if params.matcher == "soft":
        soft = Soft(
            width_px=params.soft_width_px,
            shift_px=params.soft_shift_px,
            off=params.soft_off,
            beta=params.soft_beta,
        )
        return soft_scores(present, stored, soft)
    return match_scores(present, stored, params.matcher, params.distance_share)


def _cell_evidence(signatures: Sequence[Signature], places: Sequence[PlaceModel]) -> FloatArray:
    """Log probability (Q, P) of which cells hold edges, each cell on its own: Beta(1, 1) over the
    visits that did and did not show an edge there (systems.md 3.11, I-C4), a mean per cell."""
    out = np.zeros((len(signatures), len(places)))
    seen = [shown(one.parts["cues"]).astype(bool) for one in signatures]
    for p, place in enumerate(places):
        visits = place.scene.visits[:, None, None]
        log_shown = np.log((place.shown + 1.0) / (visits + 2.0))
        log_empty = np.log((visits - place.shown + 1.0) / (visits + 2.0))
        for q, one in enumerate(signatures):
            looked = int(one.record["facings"]) >> np.arange(len(visits)) & 1
            terms = np.where(seen[q], log_shown, log_empty).sum(axis=(1, 2))
            out[q, p] = float(terms @ looked) / max(int(looked.sum()), 1)
    return out


def _classified(
    codes: np.ndarray, places: Sequence[PlaceModel], params: GatewayParams
) -> FloatArray:
    """Dirichlet mean of each place being classified as the given types, the table as prior."""
    out = np.ones((len(codes), len(places)))
    for p, place in enumerate(places):
        if place.type != NONE:
            row = SONAR[place.type, 1:] + params.smooth
            prior = params.confusion * row / row.sum()
            mean = (place.types[1:] + prior) / (place.types.sum() + params.confusion)
            out[:, p] = np.concatenate([[1.0], mean])[codes]
    return out
