"""The paper's string of single fingerprints as descriptor, for signatures with a camera."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.cyclic import align, best_ratios
from fpnav.matching.strings import Strings
from fpnav.systems.base import Features, State
from fpnav.systems.fingerprint import model as models
from fpnav.systems.fingerprint import scoring
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.fitting import fitted
from fpnav.systems.fingerprint.mean import Mean
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.record import CAMERA_ARC, arcs_of
from fpnav.systems.fingerprint.symbols import FEATURE
from fpnav.values import FloatArray, Signature

SCALE = 0.08
"""Spread of the ratio over the candidates of a query on simulated offices, to weigh it against
other channels."""


class LetterChannel:
    """Strings of letters under one model of what they are worth."""

    def __init__(self, params: FingerprintParams) -> None:
        self._params = params
        self._aligner = Aligner(params, models.hand_made(params))

    def fit(self, signatures: Sequence[Signature]) -> State:
        """The model the parameters ask for."""
        return models.saved(fitted(signatures, self._params))

    def use(self, model: State) -> None:
        """Compare under a model that was fitted."""
        self._aligner = Aligner(self._params, models.loaded(model))

    def descriptor(self, signature: Signature) -> Features:
        """Features and arcs; nothing without a camera."""
        arcs = arcs_of(signature)
        if arcs[CAMERA_ARC, 1] <= 0.0:
            return {"letters": np.zeros(0, FEATURE), "letter_arcs": np.zeros((0, 2, 2))}
        return {"letters": signature.parts["features"].copy(), "letter_arcs": arcs[None]}

    def has(self, descriptor: Features) -> bool:
        """Whether there is something to compare."""
        return len(descriptor["letter_arcs"]) > 0

    def stack(self, descriptors: Sequence[Features]) -> Strings:
        """One batch of strings."""
        return self._aligner.pack([self._mean(one) for one in descriptors])

    def compare(
        self, query: Features, members: Strings, rows: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        """Ratios in units of their spread; turns of the best few."""
        one, scores = self.stack([query]), self._aligner.model.scores
        found = best_ratios(one, 0, members, rows, scores)
        turns = np.full(len(rows), np.nan)
        best = np.argsort(-found, kind="stable")[: self._params.headings]
        turns[best] = align(one, 0, members, rows[best], scores, scoring.EMPTY).psi_rad
        return found / SCALE, turns

    def likeness(self, first: Features, second: Features) -> float:
        """prob_matching."""
        return self._aligner.probability(self.stack([first]), self.stack([second]))

    def _mean(self, descriptor: Features) -> Mean:
        features = np.array(descriptor["letters"])
        features["certainty"] = self._aligner.model.certainty(features)
        return Mean(features, descriptor["letter_arcs"][0], 1)
