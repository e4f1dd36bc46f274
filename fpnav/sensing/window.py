"""One scan all round from the scans of a short stretch of travel, seen from where the robot is.

A scanner that looks ahead cannot know a place again that is driven the other way; what it saw a few
metres earlier shows what now lies behind.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.values import FloatArray, LaserScan, Pose2

BEAMS = 360
FARTHEST_M = 30.0
NEAREST_M = 0.05


def all_round(scan: FloatArray, start_rad: float, step_rad: float, past: FloatArray) -> LaserScan:
    """A full circle of beams about the sensor: the present scan, and behind it the nearest of what
    was seen before.

    Parameters
    ----------
    scan : (n,) ranges of the present scan in metres, inf = nothing, 0 = unknown, the first beam at
        ``start_rad`` from the robot's heading, ``step_rad`` apart
    past : (m, 2) hits of earlier scans in the frame of the present sensor, heading ahead

    Returns
    -------
    LaserScan
        BEAMS beams from straight behind; NaN where nothing is known
    """
    ranges = np.full(BEAMS, np.nan, dtype=np.float32)
    distance = np.hypot(past[:, 0], past[:, 1])
    near = (distance >= NEAREST_M) & (distance <= FARTHEST_M)
    beams = _beams(np.arctan2(past[near, 1], past[near, 0]))
    far_first = np.argsort(-distance[near], kind="stable")
    ranges[beams[far_first]] = distance[near][far_first]
    known = scan > 0.0
    bearings = start_rad + step_rad * np.arange(len(scan))
    ranges[_beams(bearings[known])] = scan[known]
    return LaserScan(ranges, -np.pi, TAU / BEAMS, NEAREST_M, FARTHEST_M)


def carried(points: Sequence[FloatArray], poses: Sequence[Pose2], here: Pose2) -> FloatArray:
    """Hits of earlier scans, each seen from its pose, in the frame of the present pose, (m, 2)."""
    found = [np.zeros((0, 2))]
    for rows, pose in zip(points, poses, strict=True):
        turn = pose.heading_rad - here.heading_rad
        c, s = np.cos(here.heading_rad), np.sin(here.heading_rad)
        dx, dy = pose.x_m - here.x_m, pose.y_m - here.y_m
        a, b = np.cos(turn), np.sin(turn)
        turned = rows @ np.array([[a, b], [-b, a]])
        found.append(turned + np.array([c * dx + s * dy, -s * dx + c * dy]))
    return np.concatenate(found)


def _beams(bearings_rad: NDArray[np.floating]) -> NDArray[np.int64]:
    """Beam of each bearing."""
    return np.asarray(np.round((bearings_rad + np.pi) / (TAU / BEAMS)).astype(np.int64) % BEAMS)
