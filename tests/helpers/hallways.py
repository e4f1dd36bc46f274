"""Hallways from line segments, and drives along them with a ring of sonars: small and exact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fpnav.values import FloatArray, Pose2, SonarRing

COUNT, CONE_RAD, REACH_M, RAYS = 24, math.radians(30.0), 6.0, 15
Box = tuple[float, float, float, float]


def outline(boxes: Sequence[Box]) -> FloatArray:
    """Walls (n, 4) round the union of free boxes (x0, y0, x1, y1): edges between free and not."""
    xs = sorted({x for b in boxes for x in (b[0], b[2])})
    ys = sorted({y for b in boxes for y in (b[1], b[3])})
    free = np.zeros((len(xs) + 1, len(ys) + 1), dtype=bool)
    for i, (x0, x1) in enumerate(pairwise(xs)):
        for j, (y0, y1) in enumerate(pairwise(ys)):
            x, y = (x0 + x1) / 2, (y0 + y1) / 2
            free[i + 1, j + 1] = any(b[0] < x < b[2] and b[1] < y < b[3] for b in boxes)
    walls = []
    for i in range(len(xs)):
        for j in range(1, len(ys)):
            if free[i, j] != free[i + 1, j]:
                walls.append((xs[i], ys[j - 1], xs[i], ys[j]))
    for j in range(len(ys)):
        for i in range(1, len(xs)):
            if free[i, j] != free[i, j + 1]:
                walls.append((xs[i - 1], ys[j], xs[i], ys[j]))
    return np.array(walls, dtype=np.float64)


def cast(walls: FloatArray, x: float, y: float, angles: FloatArray) -> FloatArray:
    """Distance to the nearest wall in each direction, +inf where there is none."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    ax, ay = walls[None, :, 0] - x, walls[None, :, 1] - y
    ex, ey = walls[None, :, 2] - walls[None, :, 0], walls[None, :, 3] - walls[None, :, 1]
    cross = c * ey - s * ex
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (ax * ey - ay * ex) / cross
        where = (ax * s - ay * c) / cross
    hit = (np.abs(cross) > 1e-12) & (along > 1e-9) & (where >= -1e-12) & (where <= 1.0 + 1e-12)
    return np.where(hit, along, np.inf).min(axis=1)


def ring_at(
    walls: FloatArray, pose: Pose2, rng: np.random.Generator | None = None, noise_m: float = 0.0
) -> SonarRing:
    """One reading of a ring of 24 sonars with cones of 30 degrees at the robot's centre."""
    heading = (2 * math.pi * np.arange(COUNT) / COUNT + math.pi) % (2 * math.pi) - math.pi
    across = np.linspace(-CONE_RAD / 2, CONE_RAD / 2, RAYS)
    angles = (pose.heading_rad + heading[:, None] + across[None, :]).ravel()
    ranges = cast(walls, pose.x_m, pose.y_m, angles).reshape(COUNT, RAYS).min(axis=1)
    if rng is not None:
        ranges = ranges + noise_m * rng.standard_normal(COUNT)
    ranges = np.where(ranges > REACH_M, np.inf, np.maximum(ranges, 0.02))
    mounts = np.column_stack([np.zeros((COUNT, 2)), heading])
    return SonarRing(ranges.astype(np.float32), mounts, CONE_RAD, 0.02, REACH_M)


def straight(
    start: Pose2, length_m: float, step_m: float = 0.1, phase_m: float = 0.0
) -> list[Pose2]:
    """Poses along the heading of the first."""
    c, s = math.cos(start.heading_rad), math.sin(start.heading_rad)
    marks = np.arange(phase_m, length_m + 1e-9, step_m)
    return [Pose2(start.x_m + c * m, start.y_m + s * m, start.heading_rad) for m in marks]


def drifted(
    poses: Sequence[Pose2], rng: np.random.Generator, share: float = 0.02, turn_deg: float = 0.2
) -> list[Pose2]:
    """Dead reckoning of a drive: each step too long or short by a share, the heading wandering."""
    out, heading = [poses[0]], poses[0].heading_rad
    for before, after in pairwise(poses):
        step = math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
        step *= 1.0 + share * float(rng.standard_normal())
        turn = after.heading_rad - before.heading_rad
        heading += turn + math.radians(turn_deg) * float(rng.standard_normal())
        last = out[-1]
        out.append(
            Pose2(last.x_m + step * math.cos(heading), last.y_m + step * math.sin(heading), heading)
        )
    return out
