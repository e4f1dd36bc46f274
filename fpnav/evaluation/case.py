"""A result beside its truth: what was right, what could have been, what cannot be judged.

The same for frame-to-frame recognition and for localization on a map: the truth of a query is a
set of accepted place ids; for recognition every reference row is its own place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import TruthError
from fpnav.evaluation.accepted import (
    Bools,
    border_places,
    contains,
    nearest_rows,
    owners,
    rows_by_pose,
    singles,
)
from fpnav.geometry import angular_distance
from fpnav.store.tables import Ragged, Result
from fpnav.values import FloatArray

NEAR_MAPPING_M = 1.0
"""A query farther than this from every mapping pose stands in no place (systems.md 1.9.2)."""

BORDER_M = 0.5
DONT_CARE_M, DONT_CARE_RAD = 3.0, np.pi / 2
RADIUS_M, HEADING_DEG = 1.5, 45.0


@dataclass(frozen=True, eq=False)
class Case:
    """Q queries with a ranking of depth k, and their truth.

    ``judged`` (Q,): truth is known. ``accepted``: place ids that are right, per query; ``border``:
    graph neighbours accepted besides by the tolerant figures. ``true_place`` (Q,) owns the nearest
    mapping pose, -1 = none (maps only). ``member_apart_m``, ``_rad`` (Q,): from the truth of the
    query to that of the best member; ``position_error_m``, ``heading_error_rad`` (Q,): the same
    with the stated relative pose applied. NaN where unknown. ``chosen_on``: another run, from which
    thresholds are carried over.
    """

    result: Result
    judged: Bools
    accepted: Ragged
    border: Ragged
    true_place: NDArray[np.int64]
    member_apart_m: FloatArray
    member_apart_rad: FloatArray
    position_error_m: FloatArray
    heading_error_rad: FloatArray
    chosen_on: Case | None = None

    @property
    def has_map(self) -> bool:
        """Whether the result was made on a map of places."""
        return len(self.result.view.place_ids) > 0

    @cached_property
    def has_match(self) -> Bools:
        """Queries for which some answer is right, (Q,)."""
        return np.asarray(self.judged & (np.diff(self.accepted.offsets) > 0))

    @property
    def answered(self) -> Bools:
        """Queries whose ranking holds something, (Q,)."""
        return np.asarray(self.result.places[:, :1].max(axis=1, initial=-1) >= 0)

    @property
    def decided(self) -> Bools:
        """Queries with a decision, (Q,)."""
        return np.asarray(self.result.decision >= 0)

    @cached_property
    def right(self) -> Bools:
        """Whether each answer of the ranking is right, (Q, k)."""
        return contains(self.accepted, self.result.places)

    @cached_property
    def best_right(self) -> Bools:
        """Whether the first of the ranking is right, (Q,)."""
        return np.asarray(self.right[:, :1].any(axis=1))

    @property
    def decided_right(self) -> Bools:
        """Whether the decision is right, (Q,)."""
        return contains(self.accepted, self.result.decision[:, None])[:, 0]

    def within(self, answers: NDArray[np.int64], *, tolerant: bool) -> Bools:
        """Whether any of the answers (Q, n) is right, or, tolerant, a neighbour at its border."""
        right = contains(self.accepted, answers).any(axis=1)
        if tolerant:
            right |= contains(self.border, answers).any(axis=1)
        return np.asarray(right)

    @cached_property
    def dont_care(self) -> Bools:
        """Wrong best answers at most 3 m and 90 degrees from the query, (Q,)."""
        with np.errstate(invalid="ignore"):
            near = self.member_apart_m <= DONT_CARE_M
            near &= self.member_apart_rad <= DONT_CARE_RAD
        return np.asarray(self.judged & self.answered & ~self.best_right & near)


def judge(result: Result) -> Case:
    """Lay a result beside its truth.

    Raises
    ------
    TruthError
        The truth does not fit the result (another number of queries).
    """
    judged, accepted, foot = _truth(result)
    border = border_places(
        result.queries["truth"],
        foot,
        result.references["truth"],
        result.owner,
        neighbour_places(result),
        BORDER_M,
    )
    member = result.members[:, 0] if result.members.shape[1] else np.full(len(judged), -1)
    truth = _member_truth(result, member)
    away = result.queries["truth"] - truth
    estimate = _estimated_poses(result, truth)
    error = result.queries["truth"] - estimate
    return Case(
        result=result,
        judged=judged,
        accepted=accepted,
        border=border,
        true_place=np.append(result.owner, -1)[foot],
        member_apart_m=np.hypot(away[:, 0], away[:, 1]),
        member_apart_rad=angular_distance(away[:, 2], 0.0),
        position_error_m=np.hypot(error[:, 0], error[:, 1]),
        heading_error_rad=angular_distance(error[:, 2], 0.0),
    )


def neighbour_places(result: Result) -> dict[int, set[int]]:
    """Places joined by an edge, in either direction."""
    joined: dict[int, set[int]] = {}
    edges = result.view.edges
    for source, target in zip(edges["source"].tolist(), edges["target"].tolist(), strict=True):
        joined.setdefault(source, set()).add(target)
        joined.setdefault(target, set()).add(source)
    return joined


def _truth(result: Result) -> tuple[Bools, Ragged, NDArray[np.int64]]:
    """Whether each query can be judged, its accepted places, its nearest mapping row."""
    nowhere = np.full(len(result.queries), -1, dtype=np.int64)
    if result.truth.kind == "pairs" and result.truth.pairs is not None:
        accepted = owners(_fitting_pairs(result), result.owner, result.candidates)
        return np.ones(len(nowhere), bool), accepted, nowhere
    if result.truth.kind != "poses":
        return np.zeros(len(nowhere), bool), singles(nowhere), nowhere
    known = ~np.isnan(result.queries["truth"]).any(axis=1)
    if len(result.view.place_ids):
        labels = (result.queries["label"], result.references["label"])
        poses = result.queries["truth"], result.references["truth"]
        foot = nearest_rows(*poses, labels, NEAR_MAPPING_M)
        return known, singles(np.append(result.owner, -1)[foot]), foot
    return known, _accepted_rows(result), nowhere


def _fitting_pairs(result: Result) -> Ragged:
    pairs = result.truth.pairs
    if pairs is None or len(pairs) != len(result.queries):
        found = "no" if pairs is None else len(pairs)
        raise TruthError(
            f"{result.truth.source}: {found} rows of truth, the result has "
            f"{len(result.queries)} queries; make the result again"
        )
    return pairs


def _accepted_rows(result: Result) -> Ragged:
    """Reference rows within the radius and heading of the protocol."""
    radius_m, heading_rad = tolerance_of(result)
    poses = result.queries["truth"], result.references["truth"]
    return rows_by_pose(*poses, result.candidates, radius_m, heading_rad)


def tolerance_of(result: Result) -> tuple[float, float | None]:
    """Radius in metres and largest heading difference in radians (None = any) of the protocol."""
    protocol = result.header.get("protocol", {})
    heading = protocol.get("heading_deg", HEADING_DEG)
    heading_rad = None if heading == "any" else float(np.deg2rad(float(heading)))
    return float(protocol.get("radius_m", RADIUS_M)), heading_rad


def _estimated_poses(result: Result, member_truth: FloatArray) -> FloatArray:
    """Pose each best answer stands for, (Q, 3): the member's, the relative pose applied if any.

    Without a relative pose the heading is the member's, turned as stated.
    """
    verified = np.isfinite(result.relative).all(axis=1).reshape(-1)
    dx, dy, turn = np.where(verified[:, None], result.relative, 0.0).T
    x, y, heading = member_truth.T
    c, s = np.cos(heading), np.sin(heading)
    stated = result.headings_rad[:, 0] if result.headings_rad.shape[1] else np.nan
    turned = heading + np.where(verified, turn, stated)
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy, turned])


def _member_truth(result: Result, member: NDArray[np.int64]) -> FloatArray:
    """Truth of the best member of each query, (Q, 3), NaN where there is none."""
    poses = np.vstack([result.references["truth"], np.full((1, 3), np.nan)])
    return np.asarray(poses[np.where(member >= 0, member, len(poses) - 1)])
