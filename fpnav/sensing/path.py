"""The straight legs of a drive: how far along, and when the robot turns."""

from __future__ import annotations

import math
from collections import deque

from fpnav.geometry import wrap
from fpnav.values import Pose2

STEADY_RAD = math.radians(8.0)
"""Headings this near to each other are straight travel."""

BEND_RAD = math.radians(6.0)
BEND_M = 1.0
"""Travel over which another heading must have been steady to be another axis."""


class Path:
    """Distance along and left of the present leg.

    A leg begins once the heading has been steady for ``settle_m`` of travel and ends where it
    departs by ``turn_rad`` from the leg's axis, by ``turned_rad``; between legs ``straight`` is
    false and ``axis_rad`` that of the last one. A leg that settles to a heading ``BEND_RAD`` off
    its axis takes that for its axis: ``bends`` counts them. ``at_m`` goes on growing from leg to
    leg.
    """

    def __init__(self, turn_rad: float, settle_m: float) -> None:
        self.leg = 0
        self.bends = 0
        self.at_m = 0.0
        self.lateral_m = 0.0
        self.furthest_m = -math.inf
        self.straight = False
        self.axis_rad = math.nan
        self.turned_rad = 0.0
        self._turn_rad = turn_rad
        self._settle_m = settle_m
        self._pose: Pose2 | None = None
        self._recent: deque[tuple[float, float]] = deque()

    def move(self, pose: Pose2) -> float:
        """Go on to a pose; travel since the last one."""
        last = self._pose or pose
        self._pose = pose
        dx, dy = pose.x_m - last.x_m, pose.y_m - last.y_m
        if self.straight and abs(wrap(pose.heading_rad - self.axis_rad)) > self._turn_rad:
            self.turned_rad = wrap(pose.heading_rad - self.axis_rad)
            self.straight = False
        if not self.straight:
            self.at_m += math.hypot(dx, dy)
            self._settle(pose.heading_rad)
            return math.hypot(dx, dy)
        c, s = math.cos(self.axis_rad), math.sin(self.axis_rad)
        self.furthest_m = max(self.furthest_m, self.at_m)
        self.at_m += c * dx + s * dy
        self.lateral_m += c * dy - s * dx
        self._bend(pose.heading_rad)
        return math.hypot(dx, dy)

    @property
    def advancing(self) -> bool:
        """Whether the robot is where it has not been on this leg."""
        return self.at_m > self.furthest_m

    def _settle(self, heading_rad: float) -> None:
        steady = self._steady(heading_rad, self._settle_m)
        if steady is None:
            return
        self.axis_rad, self.straight = steady, True
        self.lateral_m, self.furthest_m = 0.0, -math.inf
        self.leg += 1
        self._recent.clear()

    def _bend(self, heading_rad: float) -> None:
        steady = self._steady(heading_rad, BEND_M)
        if steady is not None and abs(wrap(steady - self.axis_rad)) > BEND_RAD:
            self.axis_rad = steady
            self.bends += 1

    def _steady(self, heading_rad: float, travel_m: float) -> float | None:
        """Mean heading over the last so much travel, None where it was not steady."""
        self._recent.append((self.at_m, heading_rad))
        while any(abs(wrap(h - heading_rad)) > STEADY_RAD for _, h in self._recent):
            self._recent.popleft()
        while len(self._recent) > 1 and self.at_m - self._recent[1][0] >= travel_m - 1e-9:
            self._recent.popleft()
        if self.at_m - self._recent[0][0] < travel_m - 1e-9:
            return None
        turns = [wrap(h - heading_rad) for _, h in self._recent]
        return wrap(heading_rad + sum(turns) / len(turns))
