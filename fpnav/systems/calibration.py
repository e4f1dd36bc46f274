"""What a system's scores are worth: log-likelihood ratios learned on the mapping run, no truth.

Consecutive signatures show the same place, signatures far apart in the run mostly another one. The
scores of both are taken as normal of one variance, so the ratio is linear in the score.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import System
from fpnav.values import FloatArray, Signature

ANCHORS = 100
"""Signatures of the run, evenly spaced, that are learned as places of their own."""

APART = 0.1
"""Share of the run beyond which two signatures count as different places."""

LARGEST = 12.0
"""Largest log-likelihood ratio one observation may claim."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """log p(score | right) - log p(score | wrong) = slope (score - midpoint)."""

    slope: float = 0.0
    midpoint: float = 0.0

    def ratios(self, scores: FloatArray) -> FloatArray:
        """Log-likelihood ratios of scores of any shape; 0 where there is none (-inf)."""
        known = np.where(np.isfinite(scores), scores, self.midpoint)
        return np.clip(self.slope * (known - self.midpoint), -LARGEST, LARGEST)

    def saved(self) -> FloatArray:
        """As an array (2,)."""
        return np.array([self.slope, self.midpoint])

    @staticmethod
    def of(array: NDArray[np.float64]) -> Evidence:
        """From ``saved``."""
        return Evidence(float(array[0]), float(array[1]))


def evidence_of(system: System, run: Sequence[Signature]) -> Evidence:
    """What a system's scores are worth on a mapping run; nothing where the run is too short."""
    if len(run) < 8:
        return Evidence()
    rows = np.unique(np.linspace(0, len(run) - 2, min(ANCHORS, len(run) // 2)).astype(int))
    memory = system.memory()
    memory.fit(run)
    for place, row in enumerate(rows.tolist()):
        memory.learn(place, run[row])
    found, _ = memory.recall([run[row + 1] for row in rows.tolist()], len(rows), None, None)
    scores = np.full((len(rows), len(rows)), np.nan)
    asked, ranks = np.nonzero(found.places >= 0)
    scores[asked, found.places[asked, ranks]] = found.scores[asked, ranks]
    far = np.abs(rows[:, None] - rows[None, :]) > APART * len(run)
    return fit_evidence(np.diag(scores), scores[far])


def fit_evidence(right: FloatArray, wrong: FloatArray) -> Evidence:
    """Linear log-likelihood ratio of two samples; nothing where they do not differ as expected."""
    right, wrong = right[np.isfinite(right)], wrong[np.isfinite(wrong)]
    if min(len(right), len(wrong)) < 4:
        return Evidence()
    variance = 0.5 * float(right.var() + wrong.var())
    gap = float(right.mean() - wrong.mean())
    if gap <= 0.0 or variance <= 0.0:
        return Evidence()
    return Evidence(gap / variance, 0.5 * float(right.mean() + wrong.mean()))
