"""Places and edges from the owner of each signature: members, extents, lengths, bearings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import relative, wrap
from fpnav.systems.base import Memory, System
from fpnav.topomap.graph import Edge
from fpnav.values import Place, Pose2, Reference, Signature


def runs_of(references: Sequence[Reference], owner: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Stays: rows of consecutive signatures of one session with one owner, in travel order."""
    sessions = np.array([reference.session for reference in references])
    breaks = (np.diff(owner) != 0) | (np.diff(sessions) != 0)
    return np.split(np.arange(len(owner)), np.flatnonzero(breaks) + 1)


def learned(system: System, signatures: Sequence[Signature], owner: NDArray[np.int64]) -> Memory:
    """A memory that learned every signature at its place, in travel order."""
    memory = system.memory()
    memory.fit(signatures)
    for place, signature in zip(owner, signatures, strict=True):
        memory.learn(int(place), signature)
    return memory


def make_places(signatures: Sequence[Signature], owner: NDArray[np.int64]) -> list[Place]:
    """Places with their members, first label, and the length travelled inside on a mean stay."""
    references = [signature.reference for signature in signatures]
    travelled: dict[int, list[float]] = {}
    for stay in runs_of(references, owner):
        length = _travel(references[stay[0]], references[stay[-1]])
        travelled.setdefault(int(owner[stay[0]]), []).append(length)
    places = []
    for place in sorted(travelled):
        members = np.flatnonzero(owner == place).tolist()
        labels = (references[member].label for member in members)
        places.append(
            Place(
                id=place,
                members=tuple(members),
                extent_m=float(np.mean(travelled[place])),
                label=next(filter(None, labels), ""),
            )
        )
    return places


def make_edges(signatures: Sequence[Signature], owner: NDArray[np.int64]) -> list[Edge]:
    """One edge per travelled direction, its length averaged over the times it was travelled.

    Length is the path between the middle members of the two stays; bearings are given in the
    frame of each place, which is the robot's frame at the place's first signature. Odometry of
    another session has another origin, so a bearing is known in the session of that signature only.
    """
    references = [signature.reference for signature in signatures]
    frames = {int(place): references[int(np.argmax(owner == place))] for place in np.unique(owner)}
    edges: dict[tuple[int, int], Edge] = {}
    for before, after in pairwise(runs_of(references, owner)):
        source, target = int(owner[before[0]]), int(owner[after[0]])
        if references[before[-1]].session != references[after[0]].session:
            continue
        edge = Edge(
            source,
            target,
            _travel(references[before[len(before) // 2]], references[after[len(after) // 2]]),
            _bearing(frames[source], references[before[-1]], references[after[0]]),
            _bearing(frames[target], references[after[0]], references[before[-1]]),
        )
        known = edges.get((source, target))
        edges[source, target] = edge if known is None else _average(known, edge)
    return list(edges.values())


def _average(known: Edge, new: Edge) -> Edge:
    """Mean length of both; the first bearings known."""
    total = known.count + new.count
    return replace(
        known,
        length_m=(known.length_m * known.count + new.length_m * new.count) / total,
        bearing_out_rad=_first_known(known.bearing_out_rad, new.bearing_out_rad),
        bearing_in_rad=_first_known(known.bearing_in_rad, new.bearing_in_rad),
        count=total,
    )


def _first_known(first: float, second: float) -> float:
    return second if math.isnan(first) else first


def _travel(first: Reference, second: Reference) -> float:
    length = second.travelled_m - first.travelled_m
    return abs(length) if math.isfinite(length) else 0.0


def _poses(references: Sequence[Reference]) -> list[Pose2] | None:
    """All by odometry, or all by truth: the two do not share an origin."""
    for found in (
        [reference.odometry for reference in references],
        [reference.truth for reference in references],
    ):
        known = [pose for pose in found if pose is not None]
        if len(known) == len(references):
            return known
    return None


def _bearing(frame: Reference, start: Reference, end: Reference) -> float:
    """Direction from start to end in the robot's frame at ``frame``; NaN where unknown."""
    poses = _poses([frame, start, end]) if frame.session == start.session else None
    if poses is None:
        return math.nan
    origin, a, b = poses
    step = relative(a, b)
    if math.hypot(step.x_m, step.y_m) < 1e-9:
        return math.nan
    direction = a.heading_rad + math.atan2(step.y_m, step.x_m)
    return wrap(direction - origin.heading_rad)
