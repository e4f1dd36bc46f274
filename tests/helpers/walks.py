"""Small logs of a robot among boxes, with a laser only: enough for every stage to have work."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fpnav.logs.writer import LogWriter
from fpnav.publish import publish
from fpnav.values import LaserScan, Pose2

BEAMS = 180
WALLS = (
    ((0.0, 0.0), (12.0, 0.0)),
    ((12.0, 0.0), (12.0, 6.0)),
    ((12.0, 6.0), (0.0, 6.0)),
    ((0.0, 6.0), (0.0, 0.0)),
    ((4.0, 0.0), (4.0, 2.0)),
    ((8.0, 6.0), (8.0, 3.5)),
    ((8.0, 0.0), (8.0, 1.0)),
    ((2.0, 4.0), (3.0, 4.5)),
    ((10.0, 2.0), (10.5, 3.0)),
)


def ranges_from(pose: Pose2) -> np.ndarray:
    """Ranges (BEAMS,) of a full circle of beams among the walls, metres."""
    angles = -math.pi + 2 * math.pi * (np.arange(BEAMS) + 0.5) / BEAMS + pose.heading_rad
    ray = np.column_stack([np.cos(angles), np.sin(angles)])
    best = np.full(BEAMS, np.inf)
    for start, end in WALLS:
        side = np.subtract(end, start)
        away = np.subtract(start, (pose.x_m, pose.y_m))
        cross = ray[:, 0] * side[1] - ray[:, 1] * side[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (away[0] * side[1] - away[1] * side[0]) / cross
            where = (away[0] * ray[:, 1] - away[1] * ray[:, 0]) / cross
        hit = (along > 0) & (where >= 0) & (where <= 1)
        best = np.where(hit, np.minimum(best, along), best)
    return best


def path(offset_m: float, steps: int) -> list[Pose2]:
    """Along the hall, beside its middle line by ``offset_m``."""
    way = np.linspace(0.8, 11.2, steps)
    return [Pose2(float(x), 3.0 + offset_m, 0.0) for x in way]


def write_walk(file: Path, *, offset_m: float = 0.0, steps: int = 60, seed: int = 1) -> Path:
    """A log of the walk with noise on every beam; returns the file."""
    noise = np.random.default_rng(seed)
    with publish(file) as stream, LogWriter(stream) as writer:
        for number, pose in enumerate(path(offset_m, steps)):
            stamp = 10**9 + number * 10**8
            ranges = ranges_from(pose) + noise.normal(0, 0.01, BEAMS)
            scan = LaserScan(
                ranges.astype(np.float32),
                -math.pi + math.pi / BEAMS,
                2 * math.pi / BEAMS,
                0.05,
                20.0,
            )
            writer.scan(stamp, scan)
            writer.odometry(stamp, pose)
            writer.truth(stamp, pose)
    return file
