"""Stated certainty of a feature against how often it is seen again (systems.md 1.3.7, I-A2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.cyclic import align
from fpnav.systems.fingerprint import presence, scoring
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.following import moved, partners
from fpnav.systems.fingerprint.model import GROUPS, KNOTS, Model, groups_of
from fpnav.systems.fingerprint.pairs import Pairs, near_pairs
from fpnav.values import FloatArray, Pose2, Signature

AGAIN_RAD = float(np.deg2rad(15.0))
LEAST = 40

Bools = NDArray[np.bool_]
Rule = Callable[[Signature, Signature], Bools]
"""Which features (F,) of the first fingerprint are seen again in the second."""


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Features that were followed, (M,) each: ``stated`` certainty by a model, ``evidence``
    (M, presence.COLUMNS), ``group`` of GROUPS, ``again`` whether a nearby fingerprint saw it."""

    stated: FloatArray
    evidence: FloatArray
    group: NDArray[np.int64]
    again: Bools


def sightings(
    signatures: Sequence[Signature], model: Model, seen: Rule, pairs: Pairs | None = None
) -> Sightings:
    """What became of the features of each fingerprint in one a little further on."""
    if pairs is None:
        pairs = near_pairs([one.reference for one in signatures])
    first, rows = np.unique(pairs[:, 0], return_inverse=True)
    features = [signatures[i].parts["features"] for i in first.tolist()]
    known = [(model.certainty(one), presence.table(one), groups_of(one)) for one in features]
    told = [known[row] for row in rows.tolist()]
    again = [seen(signatures[i], signatures[j]) for i, j in pairs.tolist()]
    return Sightings(
        np.concatenate([np.zeros(0), *(one[0] for one in told)]),
        np.concatenate([np.zeros((0, len(presence.COLUMNS))), *(one[1] for one in told)]),
        np.concatenate([np.zeros(0, np.int64), *(one[2] for one in told)]),
        np.concatenate([np.zeros(0, bool), *again]),
    )


def by_odometry(first: Signature, second: Signature) -> Bools:
    """Rule: one of its type stands within 3 degrees of where this one must, by odometry."""
    return _standing(first, second, moved(first.reference.odometry, second.reference.odometry))


def by_truth(first: Signature, second: Signature) -> Bools:
    """Rule: one of its type stands within 3 degrees of where this one must, by the true poses."""
    return _standing(first, second, moved(first.reference.truth, second.reference.truth))


def by_alignment(aligner: Aligner) -> Rule:
    """Rule: the alignment matches it with one of its type, within 15 degrees after the turn.

    Asks for no pose; where the alignment turns a fingerprint wrongly, none of it is seen again.
    """

    def seen(first: Signature, second: Signature) -> Bools:
        return _matched(first, second, aligner)

    return seen


def calibrated(model: Model, found: Sightings) -> Model:
    """The model with leanings and curves refitted by group: a logistic of the evidence, then the
    rising curve of least squares through the observed frequencies.

    A group with too few sightings keeps its own.
    """
    lean, curves = model.lean.copy(), model.curves.copy()
    for group in range(len(GROUPS)):
        same = found.group == group
        if same.sum() < LEAST:
            continue
        evidence, again = found.evidence[same], found.again[same]
        lean[group] = presence.fitted_lean(evidence, again)
        curves[group] = _rising(presence.probability(evidence, lean[group]), again)
    counts = model.evidence.copy()
    counts[3] = len(found.again)
    return replace(model, lean=lean, curves=curves, evidence=counts)


def pooled(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Non-decreasing values nearest to the given ones (pool adjacent violators)."""
    blocks: list[list[float]] = []
    for value, weight in zip(values, weights, strict=True):
        blocks.append([float(value), float(weight), 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            last = blocks.pop()
            whole = blocks[-1][1] + last[1]
            blocks[-1][0] = (blocks[-1][0] * blocks[-1][1] + last[0] * last[1]) / whole
            blocks[-1][1], blocks[-1][2] = whole, blocks[-1][2] + last[2]
    return np.concatenate([np.zeros(0), *(np.full(int(n), value) for value, _, n in blocks)])


def _standing(first: Signature, second: Signature, motion: Pose2 | None) -> Bools:
    rows, others = first.parts["features"], second.parts["features"]
    if motion is None:
        return np.zeros(len(rows), bool)
    return np.asarray(partners(rows, others, motion) >= 0)


def _matched(first: Signature, second: Signature, aligner: Aligner) -> Bools:
    one, other = aligner.observation(first), aligner.observation(second)
    rows = aligner.symbols(one), aligner.symbols(other)
    found = align(
        aligner.pack([one]), 0, aligner.pack([other]), np.zeros(1, np.int64),
        aligner.model.scores, scoring.EMPTY,
    )  # fmt: skip
    mates = np.flatnonzero(found.partner[0] >= 0)
    mine = rows[0]["feature"][found.partner[0, mates]]
    theirs = rows[1]["feature"][mates]
    both = (mine >= 0) & (theirs >= 0)
    mine, theirs = mine[both], theirs[both]
    a, b = one.features[mine], other.features[theirs]
    off = b["angle_rad"] - a["angle_rad"] - np.nan_to_num(found.psi_rad[0])
    off = np.abs((off + np.pi) % (2.0 * np.pi) - np.pi)
    again = np.zeros(len(one.features), bool)
    again[mine[(a["type"] == b["type"]) & (off <= AGAIN_RAD)]] = True
    return again


def _rising(stated: FloatArray, again: Bools) -> FloatArray:
    """Knots (2, KNOTS): mean probability and frequency of equally full bins, made to rise."""
    order = np.argsort(stated, kind="stable")
    bins = np.array_split(order, KNOTS)
    knots = np.array([stated[rows].mean() for rows in bins])
    values = pooled(
        np.array([again[rows].mean() for rows in bins]),
        np.array([float(len(rows)) for rows in bins]),
    )
    return np.stack([knots, np.clip(values, 0.02, 1.0)])
