"""What symbols are worth to one memory: hand-made, or learned from a mapping run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.strings import Scores
from fpnav.systems.fingerprint import presence, scoring
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.symbols import ALPHABET, C, V, codes
from fpnav.values import FloatArray

GROUPS = ("edges", "corners", "colours")
KNOTS = 9

STATE = ("sigma", "gap", "weights", "curves", "evidence")
"""What a saved model must have; one saved before there was ``lean`` leans on nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Worth and certainty of symbols.

    ``scores`` what matches and gaps are worth; ``weights`` (20,) tau of each code. For edges,
    corners and colours: ``lean`` (3, presence.COLUMNS + 1) weights and bias of a logistic of what
    is known of a feature, all 0 = its certainty as extracted; ``curves`` (3, 2, KNOTS) from that
    to the probability of seeing such a feature again, piecewise linear. ``evidence`` (4,) what it
    was learned from: pairs of one place, pairs of two, symbols of them, features followed; 0 where
    hand-made.
    """

    scores: Scores
    weights: FloatArray
    lean: FloatArray
    curves: FloatArray
    evidence: NDArray[np.int64]

    def certainty(self, features: NDArray[Any]) -> FloatArray:
        """Certainty of each feature of one fingerprint, (F,), by its group's logistic and curve."""
        group = groups_of(features)
        stated = features["certainty"].astype(np.float64)
        known = presence.table(features) if self.lean.any() else np.zeros((len(features), 0))
        out = stated.copy()
        for number, (lean, (knots, values)) in enumerate(zip(self.lean, self.curves, strict=True)):
            same = group == number
            says = presence.probability(known[same], lean) if lean.any() else stated[same]
            out[same] = np.interp(says, knots, values)
        return out


def hand_made(params: FingerprintParams) -> Model:
    """The model of the parameters alone; ``plain`` scores are Needleman and Wunsch's."""
    curves = np.tile(np.linspace(0.0, 1.0, KNOTS), (len(GROUPS), 2, 1))
    if params.certainty == "flat":
        curves[:, 1] = 1.0
    scores, weights = scoring.score_table(params), scoring.type_weights(params)
    if params.scores == "plain":
        size = len(ALPHABET)
        identity = 2.0 * np.eye(size) - 1.0
        scores = Scores(identity, np.full(size, 0.5), scores.visible)
        weights = np.ones(size)
    return Model(scores, weights, _no_lean(), curves, np.zeros(4, np.int64))


def groups_of(features: NDArray[Any]) -> NDArray[np.int64]:
    """Number of the group of each feature, of GROUPS."""
    kinds = codes(features["type"])
    return np.where(kinds == V, 0, np.where(kinds == C, 1, 2)).astype(np.int64)


def saved(model: Model) -> dict[str, NDArray[Any]]:
    """The model as named arrays, provenance included."""
    return {
        "sigma": model.scores.sigma,
        "gap": model.scores.gap,
        "weights": model.weights,
        "lean": model.lean,
        "curves": model.curves,
        "evidence": model.evidence,
    }


def loaded(state: Mapping[str, NDArray[Any]]) -> Model:
    """The model that was saved."""
    return Model(
        Scores(np.array(state["sigma"]), np.array(state["gap"]), scoring.visible_table()),
        np.array(state["weights"]),
        np.array(state.get("lean", _no_lean())),
        np.array(state["curves"]),
        np.array(state["evidence"]),
    )


def _no_lean() -> FloatArray:
    return np.zeros((len(GROUPS), len(presence.COLUMNS) + 1))
