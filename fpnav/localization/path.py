"""Belief along the mapping path: where in a place the robot stands, and which way it goes.

States are the spots of the mapping run, each within its place. A step moves the belief by what
odometry says, turned into the map by the heading the alignment gives, and a spot is told by how
like each place the robot's view is: that profile changes within a place as well, and the mapping
run shows it at every spot; fpnav.localization.spots then compares the views at the likeliest. The
belief over places is the sum over their spots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import overload

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import distance, relative
from fpnav.localization.filter import FilterParams, Step, travelled
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Reference, Signature

SPOTS = 2000
"""Spots of a map at most; on a longer path they lie farther apart."""

LEAST_PLACES = 4
"""With fewer places a profile says too little."""

REACH_M = 1.5
"""Spots farther apart than this, and than a usual step goes, are not joined."""

SEAM_M = 25.0
"""Path between two passings from which odometry no longer says which spots of them are one."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """C spots and E joints between them, both directions.

    ``rows`` (C,) mapping signatures; ``column`` (C,) of their place; ``frames_rad`` (P,) heading
    by odometry in which each place's frame stands; ``step_m`` (E, 2) from source to target by
    odometry, nothing across a seam; ``spread_m`` how far off a step may be.
    """

    rows: NDArray[np.int64]
    column: NDArray[np.int64]
    frames_rad: FloatArray
    source: NDArray[np.int64]
    target: NDArray[np.int64]
    step_m: FloatArray
    spread_m: float

    def __len__(self) -> int:
        return len(self.rows)


def spots_of(
    topomap: TopoMap, mapped: Sequence[Signature], params: FilterParams
) -> NDArray[np.int64]:
    """Mapping signatures that are spots; none where the map has no path a belief could go along.

    That takes one session with odometry and a few places.
    """
    nowhere = np.zeros(0, dtype=np.int64)
    references = [signature.reference for signature in mapped]
    if not params.along_path or len(topomap) < LEAST_PLACES:
        return nowhere
    if references[0].session != references[-1].session:
        return nowhere
    metres = np.array([reference.travelled_m for reference in references])
    if any(one.odometry is None for one in references) or not np.isfinite(metres).all():
        return nowhere
    apart = max(params.spot_m, float(metres[-1] - metres[0]) / SPOTS)
    owner = topomap.owner(len(mapped))
    kept = [0]
    for row in range(1, len(metres)):
        if owner[row] != owner[kept[-1]] or metres[row] - metres[kept[-1]] >= apart:
            kept.append(row)
    return np.array(kept, dtype=np.int64)


def make_path(
    topomap: TopoMap,
    mapped: Sequence[Signature],
    rows: NDArray[np.int64],
    profiles: FloatArray,
    references: Sequence[Reference],
    params: FilterParams,
) -> Path:
    """The path through spots ``rows``, for queries that step as ``references`` do.

    ``profiles`` : (C, P) scores of the spots at all places.
    """
    owner = topomap.owner(len(mapped))
    poses = np.array([_pose(signature.reference) for signature in mapped])
    metres = np.array([mapped[int(row)].reference.travelled_m for row in rows])
    column = np.searchsorted(topomap.ids, owner[rows])
    usual = float(np.median([travelled(a, b, params) for a, b in pairwise(references)] or [0.0]))
    gap = float(np.median(np.diff(metres))) if len(rows) > 1 else 0.0
    spread_m = max(params.spread_m, 0.3 * gap, 0.25 * usual)
    xy = poses[rows, :2]
    source, target = _near(xy, max(REACH_M, usual + 3.0 * spread_m))
    steps = xy[target] - xy[source]
    seams = _seams(column, metres, _standardised(profiles))
    return Path(
        rows,
        column.astype(np.int64),
        poses[[int(np.argmax(owner == place)) for place in topomap.ids], 2],
        np.concatenate([source, seams[0], seams[1]]),
        np.concatenate([target, seams[1], seams[0]]),
        np.concatenate([steps, np.zeros((2 * len(seams[0]), 2))]),
        spread_m,
    )


def path_likelihood(
    path: Path, profiles: FloatArray, scores: FloatArray, likelihood: FloatArray, share: float
) -> FloatArray:
    """Likelihood of each query at each spot, (Q, C), the largest of a row 1.

    Of how well the profiles correlate, which needs no unit, and of the place's own ``likelihood``
    (Q, P). ``share`` : nats between profiles that agree and such that have nothing in common.
    """
    alike = _standardised(scores) @ _standardised(profiles).T
    with np.errstate(divide="ignore"):
        logs = share * alike + np.log(likelihood)[:, path.column]
    best = logs.max(axis=1, keepdims=True, initial=-np.inf)
    return np.asarray(np.exp(logs - np.where(np.isfinite(best), best, 0.0)))


class PathSteps(Sequence[Step]):
    """The steps between consecutive queries, each made when it is asked for.

    ``headings_rad`` : (Q, P) heading of each query in each place's frame.
    """

    def __init__(
        self,
        path: Path,
        references: Sequence[Reference],
        headings_rad: FloatArray,
        params: FilterParams,
    ) -> None:
        self._path, self._references = path, references
        self._headings, self._params = headings_rad, params
        self._stays = path.source == path.target
        self._length = np.hypot(path.step_m[:, 0], path.step_m[:, 1])
        self._net = _Joints(path.source[~self._stays], path.target[~self._stays], len(path))

    def __len__(self) -> int:
        return max(0, len(self._references) - 1)

    @overload
    def __getitem__(self, index: int) -> Step: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Step]: ...
    def __getitem__(self, index: int | slice) -> Step | Sequence[Step]:
        if isinstance(index, slice):
            return [self[row] for row in range(*index.indices(len(self)))]
        if not 0 <= index < len(self):
            raise IndexError(index)
        before, after = self._references[index], self._references[index + 1]
        shares = self._shares(before, after, self._headings[index])
        stay = np.bincount(self._path.source[self._stays], shares[self._stays], len(self._path))
        leave = np.clip(1.0 - stay, 0.0, 1.0)
        source = self._net.source
        weight = shares[~self._stays] / np.maximum(leave[source], 1e-300)
        apart = before.session != after.session
        return Step(self._net, leave, weight, 1.0 if apart else self._params.kidnap)

    def _shares(self, before: Reference, after: Reference, headings: FloatArray) -> FloatArray:
        """Where the robot goes from each spot, (E,); sums to 1 over the joints of a source.

        The way its heading says, or, as it may be wrong or unknown, any way as far.
        """
        path, metres = self._path, travelled(before, after, self._params)
        ring = self._normalised((self._length - metres) ** 2)
        course = (path.frames_rad + headings + _bearing(before, after))[path.column[path.source]]
        with np.errstate(invalid="ignore"):
            off = path.step_m - metres * np.stack([np.cos(course), np.sin(course)], axis=1)
        known = np.isfinite(course)
        way = self._normalised(np.where(known, (off**2).sum(axis=1), (self._length - metres) ** 2))
        return (1.0 - self._params.astray) * way + self._params.astray * ring

    def _normalised(self, squares: FloatArray) -> FloatArray:
        """Gaussian of squared metres, of which the least from each spot counts as none at all."""
        path = self._path
        least = np.full(len(path), np.inf)
        np.minimum.at(least, path.source, squares)
        weight = np.exp(-0.5 * (squares - least[path.source]) / path.spread_m**2)
        total = np.bincount(path.source, weight, len(path))
        return np.asarray(weight / total[path.source])


@dataclass(frozen=True, slots=True, eq=False)
class _Joints:
    """Joints between different spots, as a step needs them."""

    source: NDArray[np.int64]
    target: NDArray[np.int64]
    count: int

    def __len__(self) -> int:
        return self.count


def _pose(reference: Reference) -> tuple[float, float, float]:
    pose = reference.odometry
    return (math.nan,) * 3 if pose is None else (pose.x_m, pose.y_m, pose.heading_rad)


def _bearing(before: Reference, after: Reference) -> float:
    """Direction of a step in the robot's frame; NaN without odometry, 0 for none."""
    if before.odometry is None or after.odometry is None:
        return math.nan
    if distance(before.odometry, after.odometry) < 1e-9:
        return 0.0
    step = relative(before.odometry, after.odometry)
    return math.atan2(step.y_m, step.x_m)


def _near(xy: FloatArray, reach_m: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of spots within reach, each with itself, by source."""
    sources, targets = [], []
    for row in range(len(xy)):
        near = np.flatnonzero(np.hypot(*(xy - xy[row]).T) <= reach_m)
        sources.append(np.full(len(near), row))
        targets.append(near)
    return np.concatenate(sources).astype(np.int64), np.concatenate(targets).astype(np.int64)


def _seams(
    column: NDArray[np.int64], metres: FloatArray, profiles: FloatArray
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Spots of one place passed again after a loop: each with the one its view is most like."""
    found: set[tuple[int, int]] = set()
    for row in range(len(column)):
        again = np.flatnonzero((column == column[row]) & (metres[row] - metres > SEAM_M))
        if len(again):
            best = int(again[np.argmax(profiles[again] @ profiles[row])])
            found.add((best, row))
    pairs = np.array(sorted(found), dtype=np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]


def _standardised(scores: FloatArray) -> FloatArray:
    """Rows of mean 0 and length 1, so that their product is a correlation; flat ones are 0."""
    known = np.isfinite(scores)
    least = np.where(known, scores, np.inf).min(axis=1, keepdims=True, initial=np.inf)
    filled = np.where(known, scores, np.where(np.isfinite(least), least, 0.0))
    centred = filled - filled.mean(axis=1, keepdims=True)
    length = np.linalg.norm(centred, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-9, centred / np.maximum(length, 1e-9), 0.0))
