"""Inside a room: when the robot is in one, and the exits it passes (systems.md 3.3, 3.4)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fpnav.values import FloatArray

Where = Literal["LEFT", "RIGHT", "FRONT"]
Shape = Literal["CORNER", "MID", "WIDE"]

CLIP_M = 4.0
"""Readings beyond this are as far as this."""

BEFORE_M = 1.0
"""Travel before an exit ahead that says how wide the room is there."""

DROP_M = 0.8
SIDE_DROP_M = 0.3
"""How much nearer the sides come in the exit: both together, and each."""

PASSED_M = 1.0
"""Longest exit ahead of which one side alone came nearer."""

WIDER_M = 0.5
"""How much farther the sides are where the exit ends."""

READINGS = 2


@dataclass(frozen=True, slots=True)
class Exit:
    """Which way an exit lies, and its shape."""

    where: Where
    shape: Shape


@dataclass(frozen=True, slots=True)
class Pinch:
    """An exit ahead, driven through: its ends along the path (``close_m`` NaN where the sides
    stay near), its width and how far the nearer side wall stands from its edge."""

    open_m: float
    close_m: float
    width_m: float
    corner_m: float


class Room:
    """Whether the robot is in a room, and the exit it is driving through."""

    def __init__(self, side_m: float, hall_m: float) -> None:
        self.on = False
        self._side_m = side_m
        self._hall_m = hall_m
        self._far = 0
        self._hall_from = math.nan
        self._held = False
        self.leg()

    def leg(self) -> None:
        """A new leg begins; what was beside the robot is elsewhere now."""
        self._before: deque[tuple[float, float, float]] = deque()
        self._suspects: list[tuple[float, float, float]] = []
        self._inside: list[tuple[float, float, float]] = []
        self._far, self._held, self._hall_from = 0, False, math.nan

    def enter(self) -> None:
        """The robot turns into an opening that did not close."""
        self.on = True

    def leave(self) -> None:
        """The robot leaves the room; far sides mean nothing until the next leg."""
        self.on, self._held = False, True

    @property
    def pinched(self) -> bool:
        """Whether the robot is inside an exit ahead."""
        return bool(self._inside)

    def look(self, at_m: float, left_m: float, right_m: float, *, walls: bool) -> None:
        """Far sides without ``walls`` are a room; near ones with them over a metre a corridor."""
        both_far = left_m > self._side_m and right_m > self._side_m and not walls
        self._far = self._far + 1 if both_far and not self._held else 0
        if self._far > READINGS:
            self.on = True
        if not (walls and left_m + right_m <= self._hall_m):
            self._hall_from = math.nan
        elif math.isnan(self._hall_from):
            self._hall_from = at_m
        elif at_m - self._hall_from >= BEFORE_M and not self.pinched:
            self.on = False

    def through(self, at_m: float, left_m: float, right_m: float) -> Pinch | None:
        """The exit ahead that ended with this reading, if one did."""
        if not self.on or math.isnan(left_m) or math.isnan(right_m):
            return None
        row = (at_m, min(left_m, CLIP_M), min(right_m, CLIP_M))
        if self._inside:
            return self._within(row)
        if self._narrower(row):
            self._suspects.append(row)
            if len(self._suspects) >= READINGS:
                self._inside, self._suspects = self._suspects, []
            return None
        self._suspects.clear()
        self._before.append(row)
        while at_m - self._before[0][0] > BEFORE_M:
            self._before.popleft()
        return None

    def _sides_before(self) -> tuple[float, float]:
        rows = np.array(self._before)
        return float(np.median(rows[:, 1])), float(np.median(rows[:, 2]))

    def _narrower(self, row: tuple[float, float, float]) -> bool:
        _, left, right = row
        if len(self._before) <= READINGS or max(left, right) > self._side_m:
            return False
        return sum(self._sides_before()) - left - right >= DROP_M

    def _within(self, row: tuple[float, float, float]) -> Pinch | None:
        rows = np.array(self._inside)
        width = float((rows[:, 1] + rows[:, 2]).min())
        wider = row[1] + row[2] > width + WIDER_M
        long = row[0] - rows[0, 0] > PASSED_M
        if not wider and not long:
            self._inside.append(row)
            self._suspects.clear()
            return None
        if wider:
            self._suspects.append(row)
            if len(self._suspects) < READINGS:
                return None
        return self._end(rows, width, wider)

    def _end(self, rows: FloatArray, width: float, wider: bool) -> Pinch | None:
        before, last = self._sides_before(), self._before[-1]
        drops = before[0] - float(rows[:, 1].min()), before[1] - float(rows[:, 2].min())
        all_rows = np.array([last, *self._inside, *self._suspects])
        narrow = np.flatnonzero(all_rows[:, 1] + all_rows[:, 2] <= width + WIDER_M)
        marks = all_rows[:, 0]
        start = (marks[narrow[0]] + marks[max(narrow[0] - 1, 0)]) / 2.0
        close = (marks[narrow[-1]] + marks[narrow[-1] + 1]) / 2.0 if wider else math.nan
        self._inside, self._suspects = [], []
        self._before.clear()
        if not wider and min(drops) < SIDE_DROP_M:
            return None
        self.leave()
        return Pinch(float(start), float(close), width, min(drops))
