"""Fingerprints as strings for the aligner, under one model of what symbols are worth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.cyclic import align, best_ratios
from fpnav.matching.strings import Strings
from fpnav.systems.fingerprint import scoring
from fpnav.systems.fingerprint.mean import FuseRule, Mean, fuse
from fpnav.systems.fingerprint.model import Model
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.record import arcs_of, insertion
from fpnav.systems.fingerprint.symbols import symbols_of, unsigned
from fpnav.values import FloatArray, Signature


class Aligner:
    """Packs, compares and fuses fingerprints."""

    def __init__(self, params: FingerprintParams, model: Model) -> None:
        self.params, self.model = params, model
        p = params
        self._rule = FuseRule(
            float(np.deg2rad(p.merge_deg)), p.settle, p.certainty_min, p.features_max
        )
        self._insertion = insertion(params)
        if params.certainty == "flat":
            self._insertion["certainty_n"] = 1.0

    def observation(self, signature: Signature) -> Mean:
        """One fingerprint as a mean of itself, its certainties by the model."""
        features = signature.parts["features"].copy()
        features["certainty"] = self.model.certainty(features)
        features["seen"] = 1  # from here on: by how many of a place's fingerprints
        return Mean(features, arcs_of(signature), 1)

    def symbols(self, mean: Mean) -> NDArray[Any]:
        """Symbols of a mean; those of an open view from its right edge where cuts say so."""
        rows = symbols_of(mean.features, mean.arcs, **self._insertion)
        return scoring.cut_open(rows, mean.arcs) if self.params.cuts == "view" else rows

    def pack(self, means: Sequence[Mean]) -> Strings:
        """Means as a batch of strings."""
        return self._packed([self.symbols(mean) for mean in means], [m.arcs for m in means])

    def strings(self, signatures: Sequence[Signature]) -> Strings:
        """Signatures as a batch of strings."""
        return self.pack([self.observation(signature) for signature in signatures])

    def probability(self, x: Strings, y: Strings) -> float:
        """prob_matching of the first string of each batch, in [0, 1]."""
        ratio = best_ratios(x, 0, y, np.zeros(1, np.int64), self.model.scores)[0]
        return float(np.clip(ratio, 0.0, 1.0))

    def fused(self, mean: Mean, other: Mean, *, turn_rad: float | None = None) -> Mean:
        """The mean after another one was aligned to it and fused.

        ``turn_rad`` is the turn to the mean's frame where it is known already.
        """
        rows = self.symbols(other), self.symbols(mean)
        x, y = (self._packed([one], [of.arcs]) for one, of in zip(rows, (other, mean), strict=True))
        found = align(x, 0, y, np.zeros(1, np.int64), self.model.scores, scoring.EMPTY)
        mates = np.flatnonzero(found.partner[0] >= 0)
        pairs = np.column_stack(
            [rows[1]["feature"][mates], rows[0]["feature"][found.partner[0, mates]]]
        ).astype(np.int64)
        turn = float(np.nan_to_num(found.psi_rad[0])) if turn_rad is None else turn_rad
        matched = self._near(pairs[(pairs >= 0).all(axis=1)], mean, other, turn)
        return fuse(mean, other.features, other.arcs, matched, turn, self._rule, other.observations)

    def turn(self, mean: Mean, other: Mean) -> float:
        """Turn that brings the other one into the mean's frame, 0 where nothing tells it."""
        x, y = self.pack([other]), self.pack([mean])
        found = align(x, 0, y, np.zeros(1, np.int64), self.model.scores, scoring.EMPTY)
        return float(np.nan_to_num(found.psi_rad[0]))

    def _near(
        self, pairs: NDArray[np.int64], mean: Mean, other: Mean, turn_rad: float
    ) -> NDArray[np.int64]:
        """Pairs whose angles agree after the turn, where the gate asks for it."""
        if self.params.fuse_gate_deg <= 0.0:
            return pairs
        first = mean.features["angle_rad"][pairs[:, 0]]
        off = other.features["angle_rad"][pairs[:, 1]] + turn_rad - first
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(pairs[np.abs(off) <= np.deg2rad(self.params.fuse_gate_deg)])

    def _packed(self, rows: Sequence[NDArray[Any]], arcs: Sequence[FloatArray]) -> Strings:
        return scoring.strings_of(rows, arcs, self.model.weights, self.params.cuts)


def turned(mean: Mean, turn_rad: float) -> Mean:
    """The mean in a frame turned by so much."""
    features, arcs = mean.features.copy(), mean.arcs.copy()
    features["angle_rad"] = unsigned(features["angle_rad"] + turn_rad)
    arcs[:, 0] += turn_rad
    return Mean(features, arcs, mean.observations)
