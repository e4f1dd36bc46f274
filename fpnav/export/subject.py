"""What is exported: the places, edges and runs that a map or a result file holds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.execution.outcome import view_of_map
from fpnav.execution.walk import SystemChoice, system_of
from fpnav.geometry import compose
from fpnav.store.header import MAP, RESULT, Header
from fpnav.store.maps import read_map
from fpnav.store.results import read_header, read_result
from fpnav.store.tables import MapView, Result
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Pose2


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A map, or a result with the map behind it.

    ``references`` (R,) REFERENCE rows of the mapping or reference run, ``owner`` (R,) the place of
    each; ``labels`` one per place of ``view``, empty where it has none. ``result`` is None for a
    map file.
    """

    name: str
    header: Header
    view: MapView
    labels: tuple[str, ...]
    references: NDArray[Any]
    owner: NDArray[np.int64]
    result: Result | None = None

    def strip(self, row: int) -> str:
        """Readable signature of the place in that row, empty where the system has none."""
        return self.view.strips[row] if row < len(self.view.strips) else ""


def read_subject(path: Path) -> Subject:
    """What a map or result file holds.

    Raises
    ------
    StoreError
        The file is neither, or damaged.
    """
    header = read_header(path)
    if header.get("format") == MAP:
        return _of_map(path, header)
    if header.get("format") == RESULT:
        return _of_result(path)
    raise StoreError(f"{path}: is {header.get('format')!r}, expected a map or a result")


def places_of(subject: Subject) -> None:
    """Refuse what has no places.

    Raises
    ------
    StoreError
        The result was made without a map.
    """
    if not len(subject.view.place_ids):
        raise StoreError(
            f"{subject.name}: holds no map of places; export a map, or localize on one"
        )


def poses_of(rows: NDArray[Any]) -> FloatArray:
    """Pose of each REFERENCE row, (N, 3): truth where known, else odometry, else NaN."""
    truth: FloatArray = rows["truth"]
    known = np.isfinite(truth).all(axis=1, keepdims=True)
    return np.where(known, truth, rows["odometry"])


def estimates(result: Result) -> Iterator[tuple[int, Pose2]]:
    """Decided queries and the pose each is thought to have, in the frame of the references.

    The best member's pose, the relative pose applied where it was verified, else turned as stated.
    Queries that were not localized have none.
    """
    poses = poses_of(result.references)
    for query in np.flatnonzero(result.decision >= 0).tolist():
        ranks = np.flatnonzero(result.places[query] == result.decision[query])
        member = int(result.members[query, ranks[0]]) if len(ranks) else -1
        if member < 0 or not np.isfinite(poses[member]).all():
            continue
        yield query, _estimate(result, query, int(ranks[0]), Pose2(*poses[member].tolist()))


def _estimate(result: Result, query: int, rank: int, member: Pose2) -> Pose2:
    """The member's pose moved by the verified relative pose, else turned by the stated rotation."""
    relative = result.relative[query]
    if rank == 0 and np.isfinite(relative).all():
        return compose(member, Pose2(*relative.tolist()))
    turn = float(result.headings_rad[query, rank])
    return compose(member, Pose2(0.0, 0.0, turn)) if math.isfinite(turn) else member


def _of_map(path: Path, header: Header) -> Subject:
    system, _ = system_of(header, SystemChoice())
    built = read_map(path, system.RECORD, system.PARTS)
    return Subject(
        name=path.name,
        header=header,
        view=view_of_map(system, built),
        labels=_labels(built.topomap),
        references=built.signatures.references,
        owner=built.topomap.owner(len(built.signatures)),
    )


def _of_result(path: Path) -> Subject:
    result = read_result(path)
    return Subject(
        name=path.name,
        header=result.header,
        view=result.view,
        labels=("",) * len(result.view.place_ids),
        references=result.references,
        owner=result.owner,
        result=result,
    )


def _labels(topomap: TopoMap) -> tuple[str, ...]:
    return tuple(place.label for place in topomap.places)
