"""Scores and certainties learned from a mapping run.

Neighbouring fingerprints of a run show one place, distant ones two. What the aligner does with
pairs of either kind tells what a match, a substitution and a gap are worth: the log of how much
likelier they are between fingerprints of one place (BLOSUM, Henikoff and Henikoff 1992, with the
alignments of different places as background; systems.md 1.13, I-A2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.cyclic import align
from fpnav.matching.strings import Scores, Strings, on_grid
from fpnav.systems.fingerprint import scoring
from fpnav.systems.fingerprint.pairs import Pairs
from fpnav.systems.fingerprint.symbols import ALPHABET, COLOURS
from fpnav.values import FloatArray

PRIOR = 20.0
GAP_LIMITS = (0.1, 1.0)
ROUNDS = 2
HUES = np.arange(COLOURS)


@dataclass(frozen=True, slots=True, eq=False)
class Tally:
    """What became of symbols in many alignments: ``matched`` (20, 20) symmetric, both sides of
    every pair counted, by certainty; ``missed`` (20,)."""

    matched: FloatArray
    missed: FloatArray

    @property
    def total(self) -> float:
        """All symbols counted."""
        return float(self.matched.sum() + self.missed.sum())


def tally(strings: Strings, pairs: Pairs, scores: Scores) -> Tally:
    """Outcomes of aligning the named pairs of strings."""
    size = len(ALPHABET)
    matched, missed = np.zeros((size, size)), np.zeros(size)
    for first in np.unique(pairs[:, 0]):
        others = pairs[pairs[:, 0] == first, 1]
        found = align(strings, int(first), strings, others, scores, scoring.EMPTY)
        for partner, second in zip(found.partner, others, strict=True):
            _count(strings, int(first), int(second), partner, matched, missed)
    return Tally(matched, missed)


def learned_scores(
    strings: Strings, near: Pairs, far: Pairs, scores: Scores, weights: FloatArray
) -> tuple[Scores, FloatArray, int]:
    """Scores and type weights by log-odds of one place against two.

    ``strings`` are weighted by certainty alone; the alignments start from the hand-made scores and
    are made again with what was learned.

    Returns
    -------
    scores, weights, number of symbols counted.
    """
    counted = 0.0
    for _ in range(ROUNDS):
        weighted = _weighted(strings, weights)
        same, other = tally(weighted, near, scores), tally(weighted, far, scores)
        scores, weights = _from_odds(same, other, scores)
        counted = same.total + other.total
    return scores, weights, int(counted)


def _from_odds(same: Tally, other: Tally, scores: Scores) -> tuple[Scores, FloatArray]:
    """Worth of pairs and gaps in units of the most telling symbol."""
    odds, gaps = log_odds(same, other)
    worth = np.maximum(np.diag(odds), 1e-3)
    mean = 0.5 * (worth[:, None] + worth[None, :])
    sigma = np.clip(odds / mean, -1.0, 1.0)
    np.fill_diagonal(sigma, 1.0)
    gap = np.clip(gaps / worth, *GAP_LIMITS)
    return Scores(sigma, gap, scores.visible), worth / worth.max()


def log_odds(same: Tally, other: Tally) -> tuple[FloatArray, FloatArray]:
    """How much likelier each pair (20, 20) and, negated, each gap (20,) is within one place.

    Hues are alike: their pairs are pooled by how many bins they lie apart. PRIOR further counts on
    either side, at equal totals, keep rare symbols quiet.
    """
    whole = 0.5 * (same.total + other.total)
    shares = []
    for one in (same, other):
        pooled = _pooled(one)
        scale = whole / max(one.total, 1e-12)
        shares.append((pooled.matched * scale + PRIOR, pooled.missed * scale + PRIOR))
    return np.log(shares[0][0] / shares[1][0]), -np.log(shares[0][1] / shares[1][1])


def _pooled(one: Tally) -> Tally:
    """The tally with every hue given the sum of its kind."""
    matched, missed = one.matched.copy(), one.missed.copy()
    missed[HUES] = missed[HUES].sum()
    apart = np.abs(HUES[:, None] - HUES[None, :])
    apart = np.minimum(apart, COLOURS - apart)
    block = matched[:COLOURS, :COLOURS]
    for bins in range(COLOURS // 2 + 1):
        block[apart == bins] = block[apart == bins].sum()
    for rest in range(COLOURS, len(ALPHABET)):
        matched[HUES, rest] = matched[rest, HUES] = matched[HUES, rest].sum()
    return Tally(matched, missed)


def _count(
    strings: Strings,
    first: int,
    second: int,
    partner: NDArray[np.int64],
    matched: FloatArray,
    missed: FloatArray,
) -> None:
    """Add one alignment to the counts, each symbol by its weight."""
    xs = slice(strings.offsets[first], strings.offsets[first + 1])
    ys = slice(strings.offsets[second], strings.offsets[second + 1])
    cx, wx, cy, wy = strings.codes[xs], strings.weights[xs], strings.codes[ys], strings.weights[ys]
    mate = partner[: len(cy)]
    pairs = np.flatnonzero(mate >= 0)
    weight = 0.5 * (wx[mate[pairs]] + wy[pairs])
    np.add.at(matched, (cx[mate[pairs]], cy[pairs]), weight)
    np.add.at(matched, (cy[pairs], cx[mate[pairs]]), weight)
    alone = np.ones(len(cx), bool)
    alone[mate[pairs]] = False
    np.add.at(missed, cx[alone], wx[alone])
    np.add.at(missed, cy[mate < 0], wy[mate < 0])


def _weighted(strings: Strings, weights: FloatArray) -> Strings:
    """The strings with each certainty times its type's weight."""
    return Strings(
        strings.codes,
        on_grid(strings.weights * weights[strings.codes]),
        strings.angles_rad,
        strings.offsets,
        strings.arcs,
        strings.fixed,
    )
