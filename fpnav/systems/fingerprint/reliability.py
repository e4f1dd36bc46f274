"""Stated certainty of a feature against how often it is seen again (systems.md 1.3.7, I-A2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.cyclic import align
from fpnav.systems.fingerprint import scoring
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.mean import Mean
from fpnav.systems.fingerprint.model import GROUPS, KNOTS, groups_of
from fpnav.systems.fingerprint.pairs import Pairs, near_pairs
from fpnav.values import FloatArray, Signature

AGAIN_RAD = float(np.deg2rad(15.0))
LEAST = 40


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Features that were followed: ``stated`` certainty, ``group`` of GROUPS, ``again`` whether
    a nearby fingerprint saw it, (M,) each."""

    stated: FloatArray
    group: NDArray[np.int64]
    again: NDArray[np.bool_]


def sightings(
    signatures: Sequence[Signature], aligner: Aligner, pairs: Pairs | None = None
) -> Sightings:
    """What became of the features of each fingerprint in one a little further on.

    A feature is seen again where the alignment matches it with one of its type that is within 15
    degrees after the turn.
    """
    if pairs is None:
        pairs = near_pairs([one.reference for one in signatures])
    views = [aligner.observation(one) for one in signatures]
    rows = [_followed(views[i], views[j], aligner) for i, j in pairs.tolist()]
    columns = [np.concatenate([np.zeros(0), *column]) for column in zip(*rows, strict=True)]
    if not columns:
        columns = [np.zeros(0)] * 3
    return Sightings(columns[0], columns[1].astype(np.int64), columns[2].astype(bool))


def fitted_curves(found: Sightings, curves: FloatArray) -> FloatArray:
    """Curves of a model, refitted by group: the rising curve of least squares through the
    observed frequencies; a group with too few sightings keeps its own."""
    out = curves.copy()
    for group in range(len(GROUPS)):
        same = found.group == group
        if same.sum() >= LEAST:
            out[group] = _rising(found.stated[same], found.again[same].astype(np.float64))
    return out


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


def _followed(
    first: Mean, second: Mean, aligner: Aligner
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stated certainty, group and outcome of every feature of the first."""
    rows = aligner.symbols(first), aligner.symbols(second)
    found = align(
        aligner.pack([first]), 0, aligner.pack([second]), np.zeros(1, np.int64),
        aligner.model.scores, scoring.EMPTY,
    )  # fmt: skip
    mates = np.flatnonzero(found.partner[0] >= 0)
    mine = rows[0]["feature"][found.partner[0, mates]]
    theirs = rows[1]["feature"][mates]
    both = (mine >= 0) & (theirs >= 0)
    mine, theirs = mine[both], theirs[both]
    a, b = first.features[mine], second.features[theirs]
    off = b["angle_rad"] - a["angle_rad"] - np.nan_to_num(found.psi_rad[0])
    off = np.abs((off + np.pi) % (2.0 * np.pi) - np.pi)
    again = np.zeros(len(first.features))
    again[mine[(a["type"] == b["type"]) & (off <= AGAIN_RAD)]] = 1.0
    stated = first.features["certainty"].astype(np.float64)
    return stated, groups_of(first.features).astype(np.float64), again


def _rising(stated: FloatArray, again: FloatArray) -> FloatArray:
    """Knots (2, KNOTS): mean certainty and frequency of equally full bins, made to rise."""
    order = np.argsort(stated, kind="stable")
    bins = np.array_split(order, KNOTS)
    knots = np.array([stated[rows].mean() for rows in bins])
    values = pooled(
        np.array([again[rows].mean() for rows in bins]),
        np.array([float(len(rows)) for rows in bins]),
    )
    return np.stack([knots, np.clip(values, 0.02, 1.0)])
