"""A laser scan as it is kept for geometry: evenly spaced rays, thinned, one convention."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.values import LaserScan

RAY = np.dtype([("bearing_rad", "<f4"), ("range_m", "<f4")])
"""Bearing about the sensor, from the robot's heading, increasing; range inf = nothing in range,
0 = unknown."""


def rays_of(scan: LaserScan, step_rad: float) -> NDArray[np.void]:
    """Every so many beams of a scan, so that they stand at least about ``step_rad`` apart."""
    increment = scan.angle_increment_rad
    every = max(1, round(step_rad / max(abs(increment), 1e-9)))
    ranges = scan.ranges_m.astype(np.float32, copy=True)
    nothing = np.isposinf(ranges)
    ranges[~scan.valid] = 0.0
    ranges[nothing] = np.inf
    rows = np.arange(len(ranges))[::every]
    rows = rows if increment > 0.0 else rows[::-1]
    out = np.zeros(len(rows), RAY)
    out["bearing_rad"] = scan.mount.heading_rad + scan.angle_min_rad + increment * rows
    out["range_m"] = ranges[rows]
    return out
