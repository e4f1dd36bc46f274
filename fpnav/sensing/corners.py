"""Corners of a laser scan: extremities of line segments found by Douglas-Peucker."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.values import FloatArray, LaserScan

JUMP_M, JUMP_SHARE = 0.3, 0.05
EPSILON_M = 0.06
POINTS_MIN = 6
LENGTH_MIN_M = 0.4
MERGE_M = 0.15
QUALITY_MEETING, QUALITY_NEAR, QUALITY_FAR = 1.0, 0.7, 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Corners in beam order: ``bearings_rad``, ``ranges_m``, ``certainty``, (C,) each, seen from
    the robot's centre."""

    bearings_rad: FloatArray
    ranges_m: FloatArray
    certainty: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """Segment ends in beam order: point, length of the segment, quality of the end."""

    points: FloatArray
    lengths: FloatArray
    quality: FloatArray


def corners(
    scan: LaserScan, field_of_view_rad: float = TAU, epsilon_m: float = EPSILON_M
) -> Corners:
    """Corners of a scan with their uncertainty (systems.md 1.3.4).

    Parameters
    ----------
    scan : any field of view; a full circle is treated as closed
    field_of_view_rad : beams further than half of this from the robot's heading are left out
    epsilon_m : tolerance of Douglas-Peucker
    """
    points, ranges, closed = _hits(scan, field_of_view_rad)
    ends = _segment_ends(points, ranges, closed, epsilon_m)
    points, lengths, quality = _merged(ends, closed)
    return Corners(
        np.arctan2(points[:, 1], points[:, 0]),
        np.hypot(points[:, 0], points[:, 1]),
        np.clip(lengths, 0.3, 1.0) * quality,
    )


def sensed_arc(scan: LaserScan, field_of_view_rad: float = TAU) -> tuple[float, float]:
    """Centre and width, radians, of what the scan can see around the robot."""
    beams = len(scan.ranges_m)
    width = scan.field_of_view_rad
    if width >= field_of_view_rad:
        return 0.0, field_of_view_rad
    middle = scan.angle_min_rad + scan.angle_increment_rad * (beams - 1) / 2.0
    return scan.mount.heading_rad + middle, width


def simplify(points: FloatArray, epsilon_m: float = EPSILON_M) -> NDArray[np.int64]:
    """Indices of the vertices that Douglas-Peucker keeps of an open polyline (N, 2)."""
    if len(points) < 3:
        return np.arange(len(points))
    line = points.astype(np.float32)
    kept = cv2.approxPolyDP(line[:, None, :], epsilon_m, closed=False)[:, 0, :]
    where = (line[:, 0, None] == kept[None, :, 0]) & (line[:, 1, None] == kept[None, :, 1])
    return np.unique(np.concatenate([[0], where.argmax(axis=0), [len(points) - 1]]))


def _hits(scan: LaserScan, field_of_view_rad: float) -> tuple[FloatArray, FloatArray, bool]:
    """Points in the robot frame and their ranges; a full scan is opened where it may be cut."""
    points = scan.points_m()
    ranges = scan.ranges_m[scan.valid].astype(np.float64)
    if field_of_view_rad < TAU:
        inside = np.abs(np.arctan2(points[:, 1], points[:, 0])) <= field_of_view_rad / 2.0
        points, ranges = points[inside], ranges[inside]
    spare = TAU - scan.field_of_view_rad
    closed = field_of_view_rad >= TAU and spare < 1.5 * abs(scan.angle_increment_rad)
    if not closed or not len(points):
        return points, ranges, closed
    order = _opened(points, ranges)
    return points[order], ranges[order], closed


def _opened(points: FloatArray, ranges: FloatArray) -> NDArray[np.int64]:
    """Order that starts behind the widest jump; without a jump, at the farthest point, which is a
    corner and then also ends the contour."""
    count = len(points)
    excess = np.hypot(*(np.roll(points, -1, axis=0) - points).T) - _limit(
        ranges, np.roll(ranges, -1)
    )
    widest = int(np.argmax(excess))
    if excess[widest] > 0.0:
        return np.roll(np.arange(count), -widest - 1)
    start = int(np.argmax(ranges))
    return np.arange(start, start + count + 1) % count


def _segment_ends(points: FloatArray, ranges: FloatArray, closed: bool, epsilon_m: float) -> _Ends:
    """Both ends of every segment that is long enough."""
    rows: list[tuple[float, float, float, float]] = []
    for first, last in _pieces(points, ranges):
        vertices = simplify(points[first:last], epsilon_m) + first
        sides = _side(ranges, first, -1, closed), _side(ranges, last - 1, 1, closed)
        for a, b in itertools.pairwise(vertices):
            length = math.dist(points[a], points[b])
            if b - a + 1 < POINTS_MIN or length < LENGTH_MIN_M:
                continue
            rows.append((*points[a], length, sides[0] if a == first else QUALITY_NEAR))
            rows.append((*points[b], length, sides[1] if b == last - 1 else QUALITY_NEAR))
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    return _Ends(table[:, :2], table[:, 2], table[:, 3])


def _pieces(points: FloatArray, ranges: FloatArray) -> list[tuple[int, int]]:
    """[first, last) of the stretches without a jump."""
    if not len(points):
        return []
    steps = np.hypot(*np.diff(points, axis=0).T)
    cuts = np.flatnonzero(steps > _limit(ranges[:-1], ranges[1:])) + 1
    bounds = [0, *(int(cut) for cut in cuts), len(points)]
    return list(itertools.pairwise(bounds))


def _limit(first_m: FloatArray, second_m: FloatArray) -> FloatArray:
    """Longest step between neighbouring points of one surface."""
    return np.asarray(JUMP_M + JUMP_SHARE * np.minimum(first_m, second_m))


def _side(ranges: FloatArray, end: int, step: int, closed: bool) -> float:
    """Quality of a piece's end: near or far side of the jump; an end of the view moves with the
    robot as an occlusion shadow does."""
    neighbour = end + step
    if not 0 <= neighbour < len(ranges):
        if not closed:
            return QUALITY_FAR
        neighbour %= len(ranges)
    return QUALITY_NEAR if ranges[end] <= ranges[neighbour] else QUALITY_FAR


def _merged(ends: _Ends, closed: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Neighbouring ends within MERGE_M as one corner; two segments that meet are a true corner."""
    count = len(ends.points)
    if count == 0:
        return ends.points, ends.lengths, ends.quality
    near = np.hypot(*(np.roll(ends.points, -1, axis=0) - ends.points).T) <= MERGE_M
    if not closed:
        near[-1] = False
    group = np.concatenate([[0], np.cumsum(~near[:-1])])
    if near[-1]:
        group[group == group[-1]] = 0
    groups = int(group.max()) + 1
    size = np.bincount(group, minlength=groups)
    centre = np.column_stack(
        [np.bincount(group, weights=ends.points[:, axis], minlength=groups) for axis in (0, 1)]
    )
    length, quality = np.zeros(groups), np.zeros(groups)
    np.maximum.at(length, group, ends.lengths)
    np.maximum.at(quality, group, np.where(size[group] > 1, QUALITY_MEETING, ends.quality))
    return centre / size[:, None], length, quality
