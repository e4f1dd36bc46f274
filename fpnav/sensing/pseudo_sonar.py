"""A ring of virtual sonars from a laser scan, and the few ranges a robot in a hallway needs.

A sonar answers with the nearest echo anywhere in its cone; a virtual one is therefore the least
range of the beams in a cone (systems.md 3.2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import angular_distance, wrap_array
from fpnav.values import FloatArray, LaserScan, SonarRing

SIDE_RAD = math.radians(15.0)
FRONT_RAD = math.radians(20.0)
FARTHEST_RAD = math.radians(30.0)
_EDGE_RAD = 1e-6
_PARTNER_RAD = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class Sides:
    """Distances from the robot's centre to what stands beside, before and behind it.

    ``front_m`` is the least within 20 degrees of ahead, ``ahead_m`` and ``behind_m`` are of one
    transducer each. +inf: nothing in range; NaN: not known. ``beam_rad`` is the cone's full angle,
    ``apex_m`` how far from the robot's centre the cones to the sides begin.
    """

    left_m: float
    right_m: float
    front_m: float
    ahead_m: float
    behind_m: float
    beam_rad: float
    apex_m: float = 0.0


def ring_from_scan(scan: LaserScan, *, count: int, cone_rad: float) -> SonarRing:
    """Ring of ``count`` virtual sonars at the robot's centre, the first ahead, counter-clockwise.

    A cone of which the scan covers less than half is NaN, one without an echo +inf.
    """
    headings = wrap_array(2.0 * math.pi * np.arange(count) / count)
    ranges, bearings = _seen_from_centre(scan)
    known = np.isfinite(ranges) | np.isposinf(ranges)
    ranges, bearings = ranges[known], bearings[known]
    inside = angular_distance(headings[:, None], bearings[None, :]) <= cone_rad / 2.0 + _EDGE_RAD
    nearest = np.where(inside, ranges[None, :], np.inf).min(axis=1, initial=np.inf)
    covered = inside.sum(axis=1) * abs(scan.angle_increment_rad) >= 0.49 * cone_rad
    return SonarRing(
        np.where(covered, nearest, np.nan).astype(np.float32),
        np.column_stack([np.zeros((count, 2)), headings]),
        cone_rad,
        0.0,
        scan.range_max_m,
    )


def sides(ring: SonarRing, side_rad: float = SIDE_RAD) -> Sides:
    """Median of the transducers within ``side_rad`` of either side, least of those within 20
    degrees of ahead (systems.md 3.3), all from the robot's centre.

    Where no transducer points so near to a side, the nearest within 30 degrees stands for it.
    """
    x, y, heading = ring.mounts.T
    ranges = ring.ranges_m.astype(np.float64)
    ranges = np.where(np.isneginf(ranges), ring.range_min_m, ranges)
    ranges = np.where(ranges >= ring.range_max_m - 1e-6, np.inf, ranges)
    centred = ranges + x * np.cos(heading) + y * np.sin(heading)
    return Sides(
        _median(centred, heading, math.pi / 2, side_rad),
        _median(centred, heading, -math.pi / 2, side_rad),
        _least(centred, heading),
        _median(centred, heading, 0.0, 0.0),
        _median(centred, heading, math.pi, 0.0),
        ring.field_of_view_rad,
        _apex(x * np.cos(heading) + y * np.sin(heading), heading),
    )


def _apex(out_m: FloatArray, heading: FloatArray) -> float:
    """Mean distance of the transducers that look to either side from the centre; 0 of none."""
    beside = np.abs(np.abs(heading) - math.pi / 2) <= FARTHEST_RAD + _EDGE_RAD
    return float(out_m[beside].mean()) if beside.any() else 0.0


def _seen_from_centre(scan: LaserScan) -> tuple[FloatArray, FloatArray]:
    """Range and bearing of every beam's end from the robot's centre, (N,) each."""
    ranges = scan.ranges_m.astype(np.float64)
    with np.errstate(invalid="ignore"):
        ranges = np.where(ranges > scan.range_max_m, np.inf, ranges)
        ranges = np.where(ranges < scan.range_min_m, np.nan, ranges)
    directions = scan.bearings_rad + scan.mount.heading_rad
    length = np.where(np.isfinite(ranges), ranges, scan.range_max_m)
    x = scan.mount.x_m + length * np.cos(directions)
    y = scan.mount.y_m + length * np.sin(directions)
    return np.where(np.isfinite(ranges), np.hypot(x, y), ranges), np.arctan2(y, x)


def _median(ranges: FloatArray, headings: FloatArray, towards: float, side_rad: float) -> float:
    offset = wrap_array(headings - towards)
    known = ~np.isnan(ranges)
    reach = max(side_rad, _smallest(np.abs(offset[known]), FARTHEST_RAD))
    near = np.flatnonzero(known & (np.abs(offset) <= reach + _EDGE_RAD))
    if len(near) == 0:
        return math.nan
    values = np.sort(ranges[_balanced(near, offset)])
    # Of an even number the lower of the middle two: half way between a wall and nothing is nothing.
    return float(values[(len(values) - 1) // 2])


def _balanced(near: NDArray[np.int64], offset: FloatArray) -> NDArray[np.int64]:
    """Those with a partner as far to the other side: one that looks ahead alone sees an opening
    early at both its ends. The nearest where there is none."""
    apart = np.abs(offset[near][:, None] + offset[near][None, :])
    paired = apart.min(axis=1) <= _PARTNER_RAD
    if paired.any():
        return np.asarray(near[paired], dtype=np.int64)
    return near[[int(np.argmin(np.abs(offset[near])))]]


def _least(ranges: FloatArray, headings: FloatArray) -> float:
    near = ~np.isnan(ranges) & (angular_distance(headings, 0.0) <= FRONT_RAD + _EDGE_RAD)
    return float(ranges[near].min()) if near.any() else math.nan


def _smallest(away: FloatArray, limit: float) -> float:
    """The least of the values where that is within the limit, else 0."""
    least = float(away.min(initial=math.inf))
    return least if least <= limit + _EDGE_RAD else 0.0
