"""Walls beside a moving robot: their distance and the direction they run in.

A side reading is the distance to a wall along the path; over a stretch of travel the readings of
both sides tell which way the walls run (systems.md 3.3).
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from fpnav.values import FloatArray

LEFT, RIGHT = 1, -1
READINGS = 3
LEAST_M = 0.4
"""Fewest readings, and least travel, that make a wall: somebody standing there is none."""

SPREAD_M = 0.08
"""Largest median deviation of readings that are one wall."""

GAP_M = 0.4
"""Points farther apart have no wall between them."""

TREND = 0.6
"""Steepest wall that still counts as beside the robot, as a slope."""


class Wall:
    """Readings of one side while that side is closed.

    The distance is the median over the last ``window_m`` of travel. The points are those of the
    last ``axis_m`` of travel beside a wall: they outlive the wall, and go on beyond an opening,
    since they go on telling the direction.
    """

    def __init__(self, side: int, window_m: float, axis_m: float, farthest_m: float) -> None:
        self.side = side
        self._window_m = window_m
        self._axis_m = axis_m
        self._farthest_m = farthest_m
        self._ranges: deque[tuple[float, float]] = deque()
        self._points: deque[tuple[float, float]] = deque()
        self._slanted_m = -math.inf

    def see(self, at_m: float, lateral_m: float, range_m: float) -> None:
        """Add a reading taken ``at_m`` along the path and ``lateral_m`` left of it; readings
        without an echo of a wall near enough are no wall."""
        if not range_m <= self._farthest_m:
            return
        self._ranges.append((at_m, range_m))
        if at_m >= self._slanted_m:
            self._points.append((at_m, lateral_m + self.side * range_m))
        while at_m - self._ranges[0][0] > self._window_m:
            self._ranges.popleft()
        while self._beside_m() > self._axis_m:
            self._points.popleft()

    def _beside_m(self) -> float:
        """Travel beside the wall that the points tell of."""
        steps = np.diff([at for at, _ in self._points])
        return float(steps[steps <= GAP_M].sum())

    def ends(self, at_m: float) -> None:
        """The wall ended here; a beam went on seeing its end at a slant, which is no direction."""
        while self._points and self._points[-1][0] > at_m:
            self._points.pop()

    def begins(self, at_m: float) -> None:
        """The wall begins here; till then a beam sees its end at a slant."""
        self._slanted_m = at_m

    def forget(self) -> None:
        """There is no wall, as far as is known."""
        self._ranges.clear()

    def bend(self) -> None:
        """The path has another axis: where points lay beside it is not known any more."""
        self._points.clear()

    def turn(self) -> None:
        """Another leg begins: nothing seen so far counts."""
        self._ranges.clear()
        self._points.clear()
        self._slanted_m = -math.inf

    @property
    def distance_m(self) -> float:
        """Running median of the readings, NaN where they are too few or no one wall."""
        if len(self._ranges) < READINGS:
            return math.nan
        if self._ranges[-1][0] - self._ranges[0][0] < LEAST_M - 1e-9:
            return math.nan
        ranges = np.array([row[1] for row in self._ranges])
        median = float(np.median(ranges))
        return median if np.median(np.abs(ranges - median)) <= SPREAD_M else math.nan

    @property
    def spread_m(self) -> float:
        """Standard deviation of the readings about their median, from the median deviation."""
        ranges = np.array([row[1] for row in self._ranges])
        return float(1.4826 * np.median(np.abs(ranges - np.median(ranges))))

    def points(self) -> FloatArray:
        """Where the wall was met, (n, 2): along the path, left of it."""
        return np.array(self._points, dtype=np.float64).reshape(-1, 2)


def wall_direction(walls: list[FloatArray], *, least_m: float, noise_m: float) -> float:
    """Angle of the common direction of several walls to the path, by least squares; NaN where
    none is ``least_m`` long.

    Each wall has an offset of its own. Points farther off the line than three times the noise or
    two and a half times the residuals' own spread are left out in a second pass.

    Parameters
    ----------
    walls : of (n, 2) points each, along the path and left of it, metres
    """
    long = [w for w in walls if len(w) >= READINGS and np.ptp(w[:, 0]) >= least_m]
    if not long:
        return math.nan
    slope, residuals = _fit(long)
    spread = 1.4826 * float(np.median(np.abs(np.concatenate(residuals))))
    limit = max(3.0 * noise_m, 2.5 * spread)
    kept = [w[np.abs(r) <= limit] for w, r in zip(long, residuals, strict=True)]
    kept = [w for w in kept if len(w) >= READINGS and np.ptp(w[:, 0]) >= 0.5 * least_m]
    if kept:
        slope, _ = _fit(kept)
    return math.atan(slope) if abs(slope) <= TREND else math.nan


def _fit(walls: list[FloatArray]) -> tuple[float, list[FloatArray]]:
    """Common slope of all walls, and what is left of each."""
    centred = [w - w.mean(axis=0) for w in walls]
    pooled = np.concatenate(centred)
    slope = float((pooled[:, 0] @ pooled[:, 1]) / max(float(pooled[:, 0] @ pooled[:, 0]), 1e-12))
    return slope, [w[:, 1] - slope * w[:, 0] for w in centred]
