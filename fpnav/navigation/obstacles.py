"""What is in the way: nearest things around the robot from a laser scan or a sonar ring."""

from __future__ import annotations

import math

import numpy as np

from fpnav.geometry import angular_distance
from fpnav.values import FloatArray, Frame

Obstacles = list[tuple[float, float]]
"""Bearing (rad) and proximity in [0, 1] of each, nearest first."""

APART_RAD = np.deg2rad(20.0)
LEVEL = 1e-9


def obstacles_of(frame: Frame, reach_m: float, touch_m: float) -> Obstacles:
    """Obstacles within reach; proximity is 0 at ``reach_m`` and 1 at ``touch_m`` from the robot.

    Of several in one direction (20 degrees) the nearest counts.
    """
    points = _points(frame)
    ranges = np.hypot(points[:, 0], points[:, 1])
    bearings = np.arctan2(points[:, 1], points[:, 0])
    found: Obstacles = []
    open_to = ranges < reach_m
    for row in np.argsort(ranges, kind="stable"):
        if open_to[row]:
            proximity = (reach_m - ranges[row]) / max(reach_m - touch_m, 1e-6)
            found.append((float(bearings[row]), float(min(1.0, proximity))))
            open_to &= angular_distance(bearings, bearings[row]) > APART_RAD
    return found


def grazing(heading_rad: float, obstacles: Obstacles, near: float = 1.0) -> float | None:
    """The heading nearest to the one given that leads no closer to anything near.

    ``near`` : proximity from which on; 1 = what the robot touches. None where there is no such
    heading.
    """
    close = np.array([bearing for bearing, proximity in obstacles if proximity >= near])
    tried = np.concatenate([[heading_rad], close - math.pi / 2, close + math.pi / 2])
    leaves = (np.cos(tried[:, None] - close) <= LEVEL).all(axis=1)
    if not leaves.any():
        return None
    apart = np.where(leaves, angular_distance(tried, heading_rad), math.inf)
    return float(tried[np.argmin(apart)])


def _points(frame: Frame) -> FloatArray:
    """Hits (n, 2) in the robot frame, from the scan, else the sonars."""
    if frame.scan is not None:
        return frame.scan.points_m()
    ring = frame.sonar
    if ring is None:
        return np.zeros((0, 2))
    near = np.isfinite(ring.ranges_m) & (ring.ranges_m < ring.range_max_m)
    x, y, heading = ring.mounts[near].T
    ranges = ring.ranges_m[near].astype(np.float64)
    return np.column_stack([x + ranges * np.cos(heading), y + ranges * np.sin(heading)])
