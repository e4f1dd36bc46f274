"""Where a feature must stand in a fingerprint a little further on, and whether one does there."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU, relative, wrap_array
from fpnav.systems.base import Features
from fpnav.systems.fingerprint.symbols import C as CORNER
from fpnav.systems.fingerprint.symbols import codes
from fpnav.values import FloatArray, Pose2, Reference

GATE_RAD = float(np.deg2rad(3.0))
"""How far a feature may stand from where it must to be the same one: as far apart as edges are."""

UNKNOWN_M = 1000.0
"""Range of features where no corner says how far anything is: no parallax."""

LAST = 5
"""Fingerprints before one in which its features are looked for."""


def ranges(features: NDArray[Any]) -> FloatArray:
    """Range of each feature, metres, (F,): its own, else that of the wall in its direction, which
    runs straight between the corners on either side."""
    own = features["range_m"].astype(np.float64)
    corners = np.flatnonzero((codes(features["type"]) == CORNER) & np.isfinite(own))
    if not len(corners):
        return np.full(len(features), UNKNOWN_M)
    angles = features["angle_rad"]
    corners = corners[np.argsort(angles[corners], kind="stable")]
    after = np.searchsorted(angles[corners], angles) % len(corners)
    before = after - 1
    left, right = own[corners][after], own[corners][before]
    to_left = (angles[corners][after] - angles) % TAU
    to_right = (angles - angles[corners][before]) % TAU
    area = np.sin(to_left) / right + np.sin(to_right) / left
    straight = (to_left + to_right < np.pi) & (area > 1e-9)
    wall = np.sin(to_left + to_right) / np.where(straight, area, 1.0)
    known = np.where(straight, wall, np.minimum(left, right))
    return np.where(np.isfinite(own), own, np.clip(known, 1e-3, UNKNOWN_M))


def partners(
    first: NDArray[Any], second: NDArray[Any], motion: Pose2, ranges_m: FloatArray | None = None
) -> NDArray[np.int64]:
    """Row of the second fingerprint's features that each of the first is, (F,), -1 = none.

    Of one type, within 3 degrees of where the feature must stand after the motion, and each the
    nearest of the other.

    Parameters
    ----------
    motion : pose of the second in the frame of the first
    ranges_m : (F,) ranges of the first's features where they are known already
    """
    none = np.full(len(first), -1, np.int64)
    if not len(first) or not len(second):
        return none
    bearing, far = first["angle_rad"], ranges(first) if ranges_m is None else ranges_m
    x, y = far * np.cos(bearing) - motion.x_m, far * np.sin(bearing) - motion.y_m
    expected = np.arctan2(y, x) - motion.heading_rad
    off = np.abs(wrap_array(expected[:, None] - second["angle_rad"][None, :]))
    off[first["type"][:, None] != second["type"][None, :]] = np.inf
    mate, back = off.argmin(axis=1), off.argmin(axis=0)
    rows = np.arange(len(first))
    return np.where((back[mate] == rows) & (off[rows, mate] <= GATE_RAD), mate, none)


def counted(
    stream: Iterable[tuple[Reference, Features]],
) -> Iterator[tuple[Reference, Features]]:
    """Features that know in how many of the LAST fingerprints before theirs they stood, and one.

    Of one session, by odometry; without it nothing before counts.
    """
    past: deque[tuple[Reference, NDArray[Any]]] = deque(maxlen=LAST)
    for reference, found in stream:
        if past and past[-1][0].session != reference.session:
            past.clear()
        rows = found["features"].copy()
        far = ranges(rows)
        for other, features in past:
            motion = moved(reference.odometry, other.odometry)
            if motion is not None:
                rows["seen"] += partners(rows, features, motion, far) >= 0
        past.append((reference, rows))
        yield reference, {**found, "features": rows}


def moved(first: Pose2 | None, second: Pose2 | None) -> Pose2 | None:
    """Pose of the second in the frame of the first, where both are known."""
    return None if first is None or second is None else relative(first, second)
