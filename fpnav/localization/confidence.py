"""From a score to a stated probability of being right, learned on the mapping run alone.

Scores of the right place and of the best wrong place are taken as two normal distributions of one
variance, so the probability is a logistic function of the score; half way between the means it
states 0.5, and an answer stated below that is no answer: the query is not localized.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import Memory, System
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Signature

_STEEPEST = 200.0


@dataclass(frozen=True, slots=True)
class Confidence:
    """P(right | score) = 1 / (1 + exp(-slope (score - midpoint)))."""

    midpoint: float
    slope: float

    def stated(self, scores: FloatArray) -> FloatArray:
        """Probability stated for scores of any shape; 0 where the score is -inf."""
        exponent = np.clip(self.slope * (np.asarray(scores) - self.midpoint), -50.0, 50.0)
        return np.asarray(1.0 / (1.0 + np.exp(-exponent)), dtype=np.float64)


def fit_confidence(right: FloatArray, wrong: FloatArray) -> Confidence:
    """Logistic confidence from scores of right answers and of the best wrong ones.

    Without wrong ones (a single place) every score at or above the least right one is trusted;
    without right ones nothing is.
    """
    right, wrong = right[np.isfinite(right)], wrong[np.isfinite(wrong)]
    if len(right) == 0:
        return Confidence(math.inf, _STEEPEST)
    if len(wrong) == 0:
        return Confidence(float(right.min()) - 1.0 / _STEEPEST, _STEEPEST)
    variance = (right.var() * len(right) + wrong.var() * len(wrong)) / (len(right) + len(wrong))
    gap = float(right.mean() - wrong.mean())
    midpoint = float(0.5 * (right.mean() + wrong.mean()))
    if gap <= 0:
        return Confidence(float(max(right.max(), wrong.max())), _STEEPEST)
    return Confidence(midpoint, float(min(gap / max(variance, 1e-12), _STEEPEST)))


HELD_OUT = 4
"""Signatures in a row that are held out together: one alone would be told by its neighbours."""


def mapping_confidence(
    system: System, signatures: Sequence[Signature], topomap: TopoMap, *, every: int = 1
) -> Confidence:
    """Confidence from the mapping run: part of it asked on a memory that learned the rest.

    Each signature asked is scored at its own place and at the best other one. Neighbours of the
    own place count neither way: at a border both are right. Where every place would lose all it
    learned, the signatures are asked on what was learned of themselves.
    """
    owner = topomap.owner(len(signatures))
    asked = (np.arange(len(owner)) // HELD_OUT) % 2 == 1
    asked &= np.isin(owner, owner[~asked])
    if not asked.any():
        learned_rows = rows = np.arange(len(owner))
    else:
        learned_rows, rows = np.flatnonzero(~asked), np.flatnonzero(asked)
    memory = system.memory()
    memory.fit(signatures)
    for row in learned_rows:
        memory.learn(int(owner[row]), signatures[int(row)])
    right, wrong = _held_out_scores(memory, signatures, topomap, rows[::every])
    return fit_confidence(right, wrong)


def _held_out_scores(
    memory: Memory, signatures: Sequence[Signature], topomap: TopoMap, rows: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Scores at the own place and at the best that is neither it nor next to it."""
    owner = topomap.owner(len(signatures))
    recall, _ = memory.recall(
        [signatures[int(row)] for row in rows], len(memory.places), None, None
    )
    right, wrong = [], []
    for query, row in enumerate(rows):
        own = int(owner[row])
        near = {own, *topomap.neighbours(own)}
        ranking, scores = recall.places[query], recall.scores[query]
        right.append(_best(scores[ranking == own]))
        wrong.append(_best(scores[(ranking >= 0) & ~np.isin(ranking, list(near))]))
    return np.array(right), np.array(wrong)


def _best(scores: NDArray[np.float64]) -> float:
    return float(scores.max()) if len(scores) else math.nan
