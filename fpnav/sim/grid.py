"""Image rays cast sparsely: where two rows meet the same plane, the rows between do too.

Every column is cast at every ``stride``-th row. Where the hits above and below lie on one face,
so do the rays between; everywhere else the middle ray is cast, and so on by halves. Distances are
those to the planes of the faces, in closed form.
What can be missed is lower than ``stride`` rows and stands free of all edges of its background,
so vertical edges are exact and horizontal detail is kept down to about a degree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sim.jit import compiled
from fpnav.sim.raycast import FAR_M, Float32Array, Hits, from_point
from fpnav.sim.scene import Scene
from fpnav.values import Pose2

DETAIL_RAD = math.radians(1.0)
"""Height of the lowest detail that is never missed."""

MOST_ROWS = 4
UNKNOWN = -2


def stride_of(pixel_rad: float) -> int:
    """Rows from one cast row to the next."""
    return min(max(round(DETAIL_RAD / pixel_rad), 1), MOST_ROWS)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Rays from one point: ``directions`` (N, 3) of the robot's frame, turned by its heading.

    ``turn`` (2,) is the cosine and sine of the heading; the turned rays are only made where they
    are cast.
    """

    origin: Float32Array
    directions: Float32Array
    turn: Float32Array

    def some(self, index: NDArray[np.int64]) -> Float32Array:
        """The chosen rays in the world, (len(index), 3)."""
        out = np.empty((len(index), 3), dtype=np.float32)
        _turned(self.directions, index, self.turn, out)
        return out

    def all(self) -> Float32Array:
        """Every ray in the world, (N, 3)."""
        return self.some(np.arange(len(self.directions)))


def view_of(directions: Float32Array, pose: Pose2, height_m: float) -> View:
    """The rays of a camera at a pose."""
    turn = np.array([math.cos(pose.heading_rad), math.sin(pose.heading_rad)], dtype=np.float32)
    origin = np.array([pose.x_m, pose.y_m, height_m], dtype=np.float32)
    return View(origin, directions, turn)


@compiled
def _turned(
    directions: Float32Array, index: NDArray[np.int64], turn: Float32Array, out: Float32Array
) -> None:
    for k in range(len(index)):
        x, y = directions[index[k], 0], directions[index[k], 1]
        out[k, 0] = turn[0] * x - turn[1] * y
        out[k, 1] = turn[1] * x + turn[0] * y
        out[k, 2] = directions[index[k], 2]


def cast_grid(scene: Scene, view: View, width: int, stride: int) -> Hits:
    """First solid hits of an image's rays, (H * width), row by row."""
    directions = view.directions
    last = len(directions) // width - 1
    rows = np.unique(np.append(np.arange(0, last + 1, stride), last))
    triangle = np.full(len(directions), UNKNOWN, dtype=np.int32)
    first = (rows[:, None] * width + np.arange(width)).ravel()
    _cast_some(scene, view, first, triangle)
    while (np.diff(rows) > 1).any():
        left = np.empty(len(rows) * width, dtype=np.int64)
        count = _halve(rows, width, scene.owner, triangle, left)
        _cast_some(scene, view, left[:count], triangle)
        rows = np.unique(np.concatenate([rows, (rows[:-1] + rows[1:]) // 2]))
    distance = np.empty(len(directions), dtype=np.float32)
    real = scene.patches.real
    _distances(view.origin, directions, view.turn, triangle, scene.owner, real, distance)
    return Hits(distance, triangle)


def _cast_some(
    scene: Scene, view: View, index: NDArray[np.int64], triangle: NDArray[np.int32]
) -> None:
    chosen = view.some(index)
    triangle[index] = scene.solid.first(from_point(view.origin, chosen), chosen)


@compiled
def _halve(
    rows: NDArray[np.int64],
    width: int,
    owner: NDArray[np.int32],
    triangle: NDArray[np.int32],
    left: NDArray[np.int64],
) -> int:
    """Between known rows fill what one plane spans, and list the middles of the rest."""
    count = 0
    for k in range(len(rows) - 1):
        middle = (rows[k] + rows[k + 1]) // 2
        if middle == rows[k]:
            continue
        for x in range(width):
            if triangle[middle * width + x] != UNKNOWN:
                continue
            high, low = triangle[rows[k] * width + x], triangle[rows[k + 1] * width + x]
            same = owner[high] == owner[low] if high >= 0 and low >= 0 else high == low
            if not same:
                left[count] = middle * width + x
                count += 1
                continue
            for row in range(rows[k] + 1, rows[k + 1]):
                triangle[row * width + x] = high
    return count


@compiled
def _distances(
    origin: Float32Array,
    directions: Float32Array,
    turn: Float32Array,
    triangle: NDArray[np.int32],
    owner: NDArray[np.int32],
    real: Float32Array,
    distance: Float32Array,
) -> None:
    """Distance along every ray to the plane of what it hits."""
    for i in range(len(triangle)):
        distance[i] = FAR_M
        if triangle[i] < 0:
            continue
        r = np.uint32(owner[np.uint32(triangle[i])])
        nx = real[r, 4] * real[r, 8] - real[r, 5] * real[r, 7]
        ny = real[r, 5] * real[r, 6] - real[r, 3] * real[r, 8]
        nz = real[r, 3] * real[r, 7] - real[r, 4] * real[r, 6]
        above = nx * (real[r, 0] - origin[0]) + ny * (real[r, 1] - origin[1])
        above += nz * (real[r, 2] - origin[2])
        dx = turn[0] * directions[i, 0] - turn[1] * directions[i, 1]
        dy = turn[1] * directions[i, 0] + turn[0] * directions[i, 1]
        towards = nx * dx + ny * dy + nz * directions[i, 2]
        if towards != 0.0:
            distance[i] = above / towards
