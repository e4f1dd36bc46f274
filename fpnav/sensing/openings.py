"""Openings beside a moving robot: where a wall ends and where it goes on.

Two tests of the same shape decide when a side changes. ``Threshold`` is the state machine of the
paper (systems.md 3.3); ``Evidence`` sums log-likelihood ratios of "no wall here" against "the
wall" (CUSUM, Page 1954) and dates a change to where the sum began to rise.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from fpnav.sensing.walls import Wall

NEARER_M = 0.3
PASSING_M = 0.7
"""A reading so much nearer than the wall is somebody between it and the robot, for so long."""

STEP_M = 1.0
LEVEL_M = 0.1
"""Readings this level over so much travel, at most ``STEP_M`` beyond the wall, are the wall
stepping back: nobody passes through it."""

JAMB = 0.7
"""Share of the limit that a jamb takes a reading to pass, on average."""

HISTORY = 64
"""Readings a change can lie back."""


class Change(Protocol):
    """Decides from readings, one at a time, whether a side has changed."""

    def rise_m(self, opened: bool) -> float:
        """How far beyond the wall a reading must be to count as no wall; decides how much of an
        opening's end a wide beam hides."""
        ...

    def update(self, range_m: float, wall_m: float, spread_m: float, opened: bool) -> int:
        """How many readings ago the change began, 1 = with this one; 0 = there is none.

        ``wall_m`` and ``spread_m`` are distance and spread of the wall before the opening.
        """
        ...

    def reset(self) -> None:
        """Start anew, after a change."""
        ...


class Threshold:
    """A side opens or closes when ``readings`` in a row are beyond a distance from the wall."""

    def __init__(self, open_rise_m: float, close_rise_m: float, readings: int) -> None:
        self._rise_m = {False: open_rise_m, True: close_rise_m}
        self._readings = readings
        self._told: deque[bool] = deque(maxlen=HISTORY)

    def rise_m(self, opened: bool) -> float:
        """Most of the limit that holds: beyond the wall's end the beam meets its jamb, so slantwise
        that no echo comes at times."""
        return JAMB * self._rise_m[opened]

    def update(self, range_m: float, wall_m: float, spread_m: float, opened: bool) -> int:
        """Count readings beyond the limit (closed) or within it (open)."""
        self._told.append((range_m > wall_m + self._rise_m[opened]) != opened)
        told = list(self._told)[::-1]
        return _since(told) if all(told[: self._readings]) and len(told) >= self._readings else 0

    def reset(self) -> None:
        """No reading counted."""
        self._told.clear()


def _since(told: Sequence[bool]) -> int:
    """How many readings ago, latest first, the change began; a single one that does not tell it
    between two that do is a bad echo."""
    back = 0
    for row, tells in enumerate(told):
        if tells:
            back = row + 1
        elif row > back:
            break
    return back


class Evidence:
    """A side changes when the evidence summed over readings passes ``limit`` (nats).

    The wall answers normally about its distance, an opening evenly from ``rise_m`` beyond it to
    ``REACH_M`` or not at all; both fail at times, so that one reading never decides.
    """

    REACH_M = 4.0
    FAILURES = 0.08
    SILENCE_WALL = 0.04
    SILENCE_OPEN = 0.4
    LARGEST = 3.0

    def __init__(self, rise_m: float, noise_m: float, limit: float) -> None:
        self._rise_m = rise_m
        self._noise_m = noise_m
        self._limit = limit
        self._sum, self._count = 0.0, 0

    def rise_m(self, opened: bool) -> float:
        """Where the opening's readings begin."""
        return self._rise_m

    def update(self, range_m: float, wall_m: float, spread_m: float, opened: bool) -> int:
        """Add the evidence of one reading; a sum below zero is none."""
        ratio = self.ratio(range_m - wall_m, max(spread_m, self._noise_m))
        gain = -ratio if opened else ratio
        if self._sum + gain <= 0.0:
            self.reset()
            return 0
        self._sum, self._count = self._sum + gain, self._count + 1
        return self._count if self._sum >= self._limit else 0

    def ratio(self, beyond_m: float, noise_m: float) -> float:
        """Log-likelihood ratio of a reading that far beyond the wall: open against closed."""
        if beyond_m > self.REACH_M:
            return math.log(self.SILENCE_OPEN / self.SILENCE_WALL)
        anywhere = self.FAILURES / self.REACH_M
        hit = math.exp(-0.5 * (beyond_m / noise_m) ** 2) / (noise_m * math.sqrt(2.0 * math.pi))
        wall = (1.0 - self.FAILURES - self.SILENCE_WALL) * hit + anywhere
        away = beyond_m > self._rise_m
        share = 1.0 - self.FAILURES - self.SILENCE_OPEN
        opening = share / (self.REACH_M - self._rise_m) * away + anywhere
        return min(max(math.log(opening / wall), -self.LARGEST), self.LARGEST)

    def reset(self) -> None:
        """No evidence."""
        self._sum, self._count = 0.0, 0


@dataclass(frozen=True, slots=True)
class Edge:
    """A wall's end (``opens``) or where it goes on; ``at_m`` lies half way between the last
    reading before it and the first after it."""

    opens: bool
    at_m: float


class Side:
    """One side of the robot: its wall, and the opening in it."""

    def __init__(self, wall: Wall, change: Change, keep_m: float) -> None:
        self.wall = wall
        self.wall_m = math.nan
        self.spread_m = math.nan
        self.opened_m = math.nan
        self._change = change
        self._keep_m = keep_m
        self._marks: deque[float] = deque(maxlen=HISTORY)
        self._covered_m = math.nan
        self._beyond: deque[tuple[float, float]] = deque()

    def hidden_m(self, half_beam: float, apex_m: float = 0.0) -> float:
        """How much of an opening's present end a beam hides that begins ``apex_m`` from the
        robot's centre and widens by ``half_beam`` a metre to either side."""
        away = max(self.wall_m - apex_m, 0.0) + self._change.rise_m(self.opened)
        return away * half_beam

    @property
    def known(self) -> bool:
        """Whether the side has a wall, or had one before it opened."""
        return not math.isnan(self.wall_m)

    @property
    def opened(self) -> bool:
        """Whether the side is open."""
        return not math.isnan(self.opened_m)

    def update(self, at_m: float, lateral_m: float, range_m: float) -> Edge | None:
        """Take one reading, ``at_m`` along and ``lateral_m`` left of the path; NaN says nothing.

        ``range_m`` may be +inf: no echo.
        """
        if math.isnan(range_m) or self._covered(at_m, range_m):
            return None
        self._marks.append(at_m)
        if not self.known:
            self._see(at_m, lateral_m, range_m)
            return None
        if self.opened and self._steps_back(at_m, range_m):
            self.lose()
            return None
        back = self._change.update(range_m, self.wall_m, self.spread_m, self.opened)
        if back == 0:
            if not self.opened and range_m <= self.wall_m + self._keep_m:
                self._see(at_m, lateral_m, range_m)
            return None
        self._change.reset()
        self._beyond.clear()
        edge = Edge(not self.opened, self._onset(back))
        self.opened_m = edge.at_m if edge.opens else math.nan
        return edge

    def _covered(self, at_m: float, range_m: float) -> bool:
        """Whether somebody stands between the wall and the robot."""
        if not range_m < self.wall_m - NEARER_M:
            self._covered_m = math.nan
            return False
        if math.isnan(self._covered_m):
            self._covered_m = at_m
        return at_m - self._covered_m <= PASSING_M

    def _steps_back(self, at_m: float, range_m: float) -> bool:
        """Whether the wall only went on farther away."""
        self._beyond.append((at_m, range_m))
        while at_m - self._beyond[0][0] > STEP_M:
            self._beyond.popleft()
        ranges = sorted(row[1] for row in self._beyond)
        if at_m - self._beyond[0][0] < 0.9 * STEP_M or ranges[-1] > self.wall_m + STEP_M:
            return False
        tenth = len(ranges) // 10
        return ranges[-1 - tenth] - ranges[tenth] <= LEVEL_M

    def lose(self) -> None:
        """Nothing is known of this side until there is a wall again."""
        self.wall.forget()
        self._change.reset()
        self._marks.clear()
        self._beyond.clear()
        self.wall_m = self.spread_m = self.opened_m = self._covered_m = math.nan

    def _see(self, at_m: float, lateral_m: float, range_m: float) -> None:
        self.wall.see(at_m, lateral_m, range_m)
        distance = self.wall.distance_m
        if not math.isnan(distance):
            self.wall_m, self.spread_m = distance, self.wall.spread_m

    def _onset(self, back: int) -> float:
        first = self._marks[max(0, len(self._marks) - back)]
        before = self._marks[max(0, len(self._marks) - back - 1)]
        return (before + first) / 2.0
