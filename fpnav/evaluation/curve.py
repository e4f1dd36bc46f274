"""Precision and recall over every threshold of the best match per query.

One answer a query: right and accepted counts for, wrong and accepted against; a query that has a
match but whose best answer is wrong or withheld is missing from recall. Queries without any match
are negatives. Thresholds are exact: every distinct score is one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.case import Case
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Answers sorted by score, best first.

    ``order`` (A,) query rows that count for or against; ``right`` (A,); ``ends`` (T,) position of
    the last answer of each distinct score; ``scores`` (T,); ``has_match`` (Q,).
    """

    order: NDArray[np.int64]
    right: Bools
    ends: NDArray[np.int64]
    scores: FloatArray
    has_match: Bools


@dataclass(frozen=True, slots=True, eq=False)
class Counts:
    """Running sums at each threshold for B weightings: ``right``, ``accepted`` (B, T); ``base``,
    ``correct`` (B,): queries with a match, right best answers in all."""

    right: FloatArray
    accepted: FloatArray
    base: FloatArray
    correct: FloatArray

    @property
    def precision(self) -> FloatArray:
        """(B, T); before the first accepted answer that of the first one."""
        out = np.full(self.right.shape, np.nan)
        np.divide(self.right, self.accepted, out=out, where=self.accepted > 0)
        first = np.argmax(self.accepted > 0, axis=1)
        lead = out[np.arange(len(out)), first][:, None]
        return np.where(np.isnan(out), lead, out)

    def recall(self, over: FloatArray) -> FloatArray:
        """(B, T) right answers over the given totals (B,); NaN over zero."""
        out = np.full(self.right.shape, np.nan)
        np.divide(self.right, over[:, None], out=out, where=over[:, None] > 0)
        return out


def sweep(case: Case, *, ignore: Bools | None = None) -> Sweep:
    """Sort the best answers of a case by score; ``ignore`` (Q,) drops some, neither way."""
    used = case.judged & case.answered
    if ignore is not None:
        used &= ~ignore
    rows = np.flatnonzero(used)
    scores = case.result.scores[rows, 0] if len(rows) else np.zeros(0)
    order = np.argsort(-scores, kind="stable")
    ordered = scores[order]
    last = np.append(ordered[1:] != ordered[:-1], True)[: len(ordered)]
    return Sweep(
        order=rows[order],
        right=case.best_right[rows[order]],
        ends=np.flatnonzero(last),
        scores=ordered[last],
        has_match=case.has_match,
    )


def count(answers: Sweep, weights: FloatArray) -> Counts:
    """Running sums of a sweep for weights (B, Q): how often each query counts."""
    drawn = weights[:, answers.order]
    right = np.cumsum(drawn * answers.right, axis=1)
    accepted = np.cumsum(drawn, axis=1)
    return Counts(
        right=right[:, answers.ends],
        accepted=accepted[:, answers.ends],
        base=weights[:, answers.has_match].sum(axis=1),
        correct=right[:, -1] if right.shape[1] else np.zeros(len(weights)),
    )


def plain(answers: Sweep) -> Counts:
    """Running sums with every query counted once, (1, T)."""
    return count(answers, np.ones((1, len(answers.has_match))))


Figure = Callable[[Counts], FloatArray]
"""One figure (B,) of the running sums."""


def average_precision(counts: Counts) -> FloatArray:
    """Step sum: precision at each threshold times the gain of recall (as scikit-learn's)."""
    recall = counts.recall(counts.base)
    steps = np.diff(recall, axis=1, prepend=0.0)
    return np.asarray((steps * counts.precision).sum(axis=1))


def area(counts: Counts) -> FloatArray:
    """Trapezoid under precision over recall, anchored at recall 0 with the first precision."""
    return _trapezoid(counts, counts.recall(counts.base))


def area_of_correct(counts: Counts) -> FloatArray:
    """The same with the recall of VPR-Bench: over the right best answers only, misses ignored."""
    return _trapezoid(counts, counts.recall(counts.correct))


def reaches(counts: Counts, least: float) -> Bools:
    """Whether precision is at least ``least`` at each threshold, (B, T)."""
    # accepted * least is compared, not the quotient: 99 of 100 must reach 0.99 exactly.
    return np.asarray(counts.right >= counts.accepted * least - 1e-9)


def recall_at_precision(least: float) -> Figure:
    """Largest recall at a precision of at least ``least``; 0 where none reaches it."""

    def of(counts: Counts) -> FloatArray:
        recall = np.where(reaches(counts, least), counts.recall(counts.base), 0.0)
        return np.asarray(recall.max(axis=1, initial=0.0))

    return of


def extended_precision(counts: Counts) -> FloatArray:
    """(P at R0 + R at P100) / 2 as VPR-Bench has it: recall over the right best answers.

    P at R0 is the precision among the highest scored answers.
    """
    perfect = counts.right >= counts.accepted
    recall = np.where(perfect, np.nan_to_num(counts.recall(counts.correct)), 0.0)
    return np.asarray(0.5 * (counts.precision[:, 0] + recall.max(axis=1, initial=0.0)))


def _trapezoid(counts: Counts, recall: FloatArray) -> FloatArray:
    precision = counts.precision
    widths = np.diff(recall, axis=1, prepend=0.0)
    before = np.concatenate([precision[:, :1], precision[:, :-1]], axis=1)
    return np.asarray((widths * 0.5 * (precision + before)).sum(axis=1))


FIGURES: dict[str, Figure] = {
    "average_precision": average_precision,
    "area": area,
    "area_of_correct": area_of_correct,
    "recall_at_100": recall_at_precision(1.0),
    "recall_at_99": recall_at_precision(0.99),
    "extended_precision": extended_precision,
}
"""The figures of a curve that metrics are made of."""
