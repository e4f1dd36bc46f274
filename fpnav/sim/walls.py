"""Following walls by sonar: the robot knows its way, dead reckons, and trusts walls beside it."""

from __future__ import annotations

import math

import numpy as np

from fpnav.geometry import wrap
from fpnav.sim.motion import TICK_S, Base, Track, WayFollower, track_of
from fpnav.sim.scene import Scene
from fpnav.sim.sensors import ranges
from fpnav.sim.sensors.ranges import Sonar
from fpnav.sim.world import Route
from fpnav.values import Pose2

EVERY = 4
"""Ticks between two sonar readings: 5 Hz."""

GATE_M, AGREE_M = 0.12, 0.06
ALIGNED_RAD = math.radians(20.0)
POSITION_GAIN, HEADING_GAIN = 0.2, 0.08
WANDER_RAD = math.radians(0.6)
STOP_M = 0.02
NEAR_M = 0.7


class WallFollower:
    """Where the robot believes it is: dead reckoning, set right by walls and by gateways."""

    def __init__(self, scene: Scene, route: Route, sonar: Sonar, rng: np.random.Generator) -> None:
        self.scene, self.route, self.sonar, self.rng = scene, route, sonar, rng
        self.scale = 1.0 + 0.01 * rng.standard_normal()
        quarter = sonar.count // 4
        self.left, self.right = quarter, 3 * quarter
        self.seen: set[int] = set()
        self.believed = Pose2(0.0, 0.0, 0.0)

    def begin(self, truth: Pose2) -> None:
        """Set down with nearly the right idea of where it is."""
        self.believed = Pose2(
            truth.x_m + 0.03 * self.rng.standard_normal(),
            truth.y_m + 0.03 * self.rng.standard_normal(),
            truth.heading_rad + math.radians(1.0) * self.rng.standard_normal(),
        )

    def moved(self, linear_mps: float, angular_radps: float) -> None:
        """Dead reckon one tick."""
        step = linear_mps * TICK_S
        wander = WANDER_RAD * math.sqrt(abs(step)) * self.rng.standard_normal()
        turn = angular_radps * TICK_S + wander
        heading = self.believed.heading_rad + turn / 2
        self.believed = Pose2(
            self.believed.x_m + step * self.scale * math.cos(heading),
            self.believed.y_m + step * self.scale * math.sin(heading),
            wrap(self.believed.heading_rad + turn),
        )

    def look(self, truth: Pose2, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Correct the belief on the walls beside the piece of way from ``start`` to ``end``."""
        along = math.atan2(end[1] - start[1], end[0] - start[0])
        if abs(wrap(self.believed.heading_rad - along)) > ALIGNED_RAD:
            return
        nx, ny = -math.sin(along), math.cos(along)
        expected = (self.believed.x_m - start[0]) * nx + (self.believed.y_m - start[1]) * ny
        measured = self._lateral(truth, expected)
        if measured is None:
            return
        surprise = measured - expected
        self.believed = Pose2(
            self.believed.x_m + POSITION_GAIN * surprise * nx,
            self.believed.y_m + POSITION_GAIN * surprise * ny,
            wrap(self.believed.heading_rad + HEADING_GAIN * surprise),
        )

    def _lateral(self, truth: Pose2, expected: float) -> float | None:
        """Offset to the left of the hallway's middle, as the side walls tell it."""
        half, only = self.route.half_width_m, (self.left, self.right)
        ring = ranges.ring(self.scene, None, truth, self.sonar, self.rng, only)
        left, right = (float(r) + self.sonar.radius_m for r in ring.ranges_m)
        told = [e for e in (half - left, right - half) if abs(e - expected) < GATE_M]
        if len(told) == 2 and abs(told[0] - told[1]) > AGREE_M:
            told = [min(told, key=lambda e: abs(e - expected))]
        return sum(told) / len(told) if told else None

    def pass_marks(self, truth: Pose2) -> None:
        """At a gateway the robot finds its middle, along its way, to a few centimetres."""
        for number, mark in enumerate(self.route.marks):
            close = math.hypot(mark.x_m - truth.x_m, mark.y_m - truth.y_m) < NEAR_M
            if close and number not in self.seen:
                self.seen.add(number)
                c, s = math.cos(truth.heading_rad), math.sin(truth.heading_rad)
                error = STOP_M * self.rng.standard_normal()
                error -= (self.believed.x_m - truth.x_m) * c + (self.believed.y_m - truth.y_m) * s
                self.believed = Pose2(
                    self.believed.x_m + error * c,
                    self.believed.y_m + error * s,
                    self.believed.heading_rad,
                )


def drive_along_walls(
    route: Route, speed_mps: float, scene: Scene, sonar: Sonar, rng: np.random.Generator
) -> Track:
    """Drive a hallway route as a wall follower does."""
    (x, y), (nx, ny) = route.points[0], route.points[1]
    base = Base(x, y, math.atan2(ny - y, nx - x))
    way = WayFollower(route.points, speed_mps, route.lookahead_m, square=True)
    follower = WallFollower(scene, route, sonar, rng)
    follower.begin(base.pose)
    rows = [base.row()]
    while not way.done:
        base.step(*way.command(follower.believed))
        follower.moved(base.linear_mps, base.angular_radps)
        if len(rows) % EVERY == 0 and not way.done:
            follower.look(base.pose, *way.piece)
        follower.pass_marks(base.pose)
        rows.append(base.row())
    return track_of(rows)
