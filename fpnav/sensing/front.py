"""What stands ahead of a moving robot: a wall stays where it is, somebody passing does not."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

STRETCH_M = 0.3
"""Travel over which something ahead must have stood still to be a wall."""

STILL_M = 0.15
READINGS = 3


class Front:
    """Readings ahead over the last stretch of travel."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, float]] = deque()

    def see(self, at_m: float, range_m: float) -> None:
        """Take one reading; NaN says nothing."""
        if math.isnan(range_m):
            return
        self._rows.append((at_m, range_m))
        while at_m - self._rows[0][0] > STRETCH_M:
            self._rows.popleft()

    def forget(self) -> None:
        """Another leg begins."""
        self._rows.clear()

    @property
    def wall_m(self) -> float:
        """Where along the path a wall stands across it, +inf where none does."""
        if len(self._rows) < READINGS:
            return math.inf
        places = np.array([at + ahead for at, ahead in self._rows])
        if not np.isfinite(places).all() or np.ptp(places) > STILL_M:
            return math.inf
        return float(np.median(places))
