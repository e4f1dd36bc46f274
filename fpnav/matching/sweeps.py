"""Laser sweeps laid over each other: correlative search, refinement, mutual free-space check.

Search after Olson, "Real-time correlative scan matching" (ICRA 2009); refinement point to line
(Censi, "An ICP variant using a point-to-line metric", ICRA 2008); a hit must lie near a hit of the
other sweep, and no beam of either may have passed through what the other saw.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU, wrap
from fpnav.matching import sweep_kernels as kernels
from fpnav.values import FloatArray

FARTHEST_M = 30.0
"""Hits beyond are taken for none: neighbouring beams are too far apart there."""

CELL_M, HALF_M, BLUR_M = 0.2, 16.0, 0.3
POINTS, NEAR_M = 60, 14.0
WEIGHT_NEAR_M, WEIGHT_FAR_M = 0.3, 8.0

REACH_M, STEP_M = 2.0, 0.5
CLIMB = np.array([[0.15, np.deg2rad(2.0), 3], [0.075, np.deg2rad(1.0), 2]])
STRIDE = 4
"""Metres, radians and stride over the outline of each level of the climb; stride of the search."""
GATES_M = np.array([1.0, 1.0, 0.6, 0.6, 0.35, 0.35, 0.35, 0.35])


@dataclass(frozen=True, eq=False)
class Sweep:
    """One scan in its sensor's frame: evenly spaced beams, counter-clockwise.

    ``ranges_m`` (n,) float64: inf = nothing hit, 0 = unknown.
    """

    ranges_m: FloatArray
    start_rad: float
    step_rad: float

    @property
    def closed(self) -> bool:
        """Whether the beams go all round."""
        return len(self.ranges_m) * self.step_rad > TAU - 1.5 * self.step_rad

    @cached_property
    def hits(self) -> NDArray[np.int64]:
        """Beams that hit something."""
        return np.flatnonzero((self.ranges_m > 0.0) & np.isfinite(self.ranges_m))

    @cached_property
    def points(self) -> tuple[FloatArray, FloatArray]:
        """x and y of every beam's hit, (n,) each; 0 where there is none."""
        bearings = self.start_rad + self.step_rad * np.arange(len(self.ranges_m))
        ranges = np.zeros(len(self.ranges_m))
        ranges[self.hits] = self.ranges_m[self.hits]
        return ranges * np.cos(bearings), ranges * np.sin(bearings)

    @cached_property
    def normals(self) -> FloatArray:
        """Unit normal of the surface at each hit, (n, 2), NaN where there is no line."""
        out = np.empty((len(self.ranges_m), 2))
        kernels.directions(*self.points, self.ranges_m, self.closed, out)
        return out

    @cached_property
    def weights(self) -> FloatArray:
        """Share of the outline each hit stands for, by its range, (hits,); sums to 1."""
        length = np.minimum(self.ranges_m[self.hits], WEIGHT_FAR_M) + WEIGHT_NEAR_M
        return np.asarray(length / max(float(length.sum()), 1e-9))

    @cached_property
    def outline(self) -> tuple[FloatArray, FloatArray]:
        """x and y of at most POINTS hits, evenly along what is seen."""
        near = self.hits[self.ranges_m[self.hits] < NEAR_M]
        if len(near) > POINTS:
            length = np.cumsum(np.minimum(self.ranges_m[near], WEIGHT_FAR_M) + WEIGHT_NEAR_M)
            wanted = (np.arange(POINTS) + 0.5) / POINTS * length[-1]
            near = near[np.unique(np.searchsorted(length, wanted))]
        x, y = self.points
        return x[near], y[near]

    @cached_property
    def fields(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Likelihood of a hit on a fine grid, and its maxima on one of twice the side."""
        size = int(2 * HALF_M / CELL_M)
        free = np.full((size, size), 255, np.uint8)
        x, y = (np.floor((axis[self.hits] + HALF_M) / CELL_M).astype(int) for axis in self.points)
        inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
        free[x[inside], y[inside]] = 0
        if not inside.any():
            return np.zeros((size, size), np.float32), np.zeros((size // 2, size // 2), np.float32)
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL_M
        fine = np.asarray(np.exp(-0.5 * (distance / BLUR_M) ** 2), np.float32)
        most = np.asarray(cv2.dilate(fine, np.ones((3, 3), np.uint8)), np.float32)
        return fine, np.ascontiguousarray(most[1::2, 1::2])


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """One sweep laid over another.

    ``pose`` (3,): x, y, heading of the other sensor in the frame of the query's. ``forward``,
    ``backward`` (5,): the other's hits checked against the query and the reverse, shares that
    agree, conflict, are hidden, outside, and the agreeing ones' distances summed. ``value`` : mean
    likelihood of the search; ``pairs`` and ``square_m2`` of the refinement, with its
    ``information`` (3, 3) for unit variance.
    """

    pose: FloatArray
    forward: FloatArray
    backward: FloatArray
    value: float
    pairs: int
    square_m2: float
    information: FloatArray

    @property
    def balance(self) -> float:
        """What agrees less what conflicts, both ways, in [-2, 2]."""
        both = self.forward + self.backward
        return float(both[kernels.AGREE] - both[kernels.CONFLICT])


def turns_between(first: Sweep, second: Sweep, most_rad: float, step_rad: float) -> FloatArray:
    """Turns to try: all round where both sweeps are closed, else up to ``most_rad`` either way."""
    if first.closed and second.closed:
        whole = round(TAU / step_rad)
        return np.asarray(np.arange(whole) * (TAU / whole), dtype=np.float64)
    count = int(most_rad / step_rad + 1e-9)
    return np.asarray(np.arange(-count, count + 1) * step_rad, dtype=np.float64)


def searched(query: Sweep, other: Sweep, turns_rad: FloatArray, keep: int) -> FloatArray:
    """The ``keep`` best overlays, rows value, x, y, psi; value -1 where there is none."""
    out = np.full((keep, 4), -1.0)
    fine, coarse = query.fields
    closed = len(turns_rad) > 1 and query.closed and other.closed
    kernels.search(
        fine, coarse, np.array([CELL_M, 2 * CELL_M]), HALF_M, *other.outline,
        turns_rad, closed, REACH_M, STEP_M, STRIDE, CLIMB, out,
    )  # fmt: skip
    return out


def correlated(
    query: Sweep, other: Sweep, turns_rad: FloatArray, reach_m: float, step_m: float
) -> tuple[float, FloatArray]:
    """Mean likelihood and pose (x, y, psi) of the best overlay on a grid, all of it searched
    (Olson, ICRA 2009: two levels, the coarse one bounds the fine one)."""
    pose = np.zeros(3)
    fine, _ = query.fields
    # a block's translations and the cells' own width together reach one cell further each way
    reached = cv2.dilate(fine, np.ones((5, 5), np.uint8))
    coarse = np.ascontiguousarray(np.asarray(reached, np.float32)[1::2, 1::2])
    value = kernels.correlate(
        fine, coarse, np.array([CELL_M, 2 * CELL_M]), HALF_M, *other.outline,
        turns_rad, reach_m, step_m, pose,
    )  # fmt: skip
    return float(value), pose


def overlaid(query: Sweep, other: Sweep, starts: FloatArray) -> Overlay:
    """The overlay with the best balance after refining each start (value, x, y, psi)."""
    found = [_refined(query, other, start) for start in starts if start[0] >= 0.0]
    if not found:
        found = [_refined(query, other, np.zeros(4))]
    return max(found, key=lambda one: one.balance)


def rough_balance(query: Sweep, other: Sweep, pose: FloatArray) -> float:
    """What agrees less what conflicts, both ways, of an overlay that was not refined."""
    both = _checked(query, other, pose) + _checked(other, query, inverted(pose))
    return float(both[kernels.AGREE] - both[kernels.CONFLICT])


def inverted(pose: FloatArray) -> FloatArray:
    """The pose of the first frame in the second."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])


def _refined(query: Sweep, other: Sweep, start: FloatArray) -> Overlay:
    pose, information = start[1:].copy(), np.zeros((3, 3))
    px, py = (axis[other.hits] for axis in other.points)
    frame = (query.start_rad, query.step_rad, query.closed)
    pairs, square = kernels.refine(
        *query.points, query.ranges_m, query.normals, *frame,
        px[::2], py[::2], GATES_M, pose, information,
    )  # fmt: skip
    pose[2] = wrap(float(pose[2]))
    return Overlay(
        pose,
        _checked(query, other, pose),
        _checked(other, query, inverted(pose)),
        float(start[0]),
        int(pairs),
        float(square),
        information,
    )


def _checked(query: Sweep, other: Sweep, pose: FloatArray) -> FloatArray:
    out = np.zeros(5)
    x, y = (axis[other.hits] for axis in other.points)
    kernels.check(
        *query.points, query.ranges_m, query.start_rad, query.step_rad, query.closed,
        x, y, other.weights, pose, out,
    )  # fmt: skip
    return out
