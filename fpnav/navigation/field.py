"""Dynamic neural field: one heading out of where to go and what is in the way (Amari 1977)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fpnav.geometry import TAU
from fpnav.values import FloatArray

BINS = 360
STEPS = 200
DT = 0.1
REST = -0.4
STEEPNESS = 20.0
WANTED_SIGMA_RAD = math.radians(45.0)
BLOCKED_SIGMA_RAD = math.radians(18.0)
REPULSION = 1.5

_BEARINGS = TAU * np.arange(BINS) / BINS
_AROUND = (_BEARINGS + math.pi) % TAU - math.pi


def _bump(sigma_rad: float) -> FloatArray:
    """Gaussian of height 1 about bearing 0."""
    return np.asarray(np.exp(-0.5 * (_AROUND / sigma_rad) ** 2))


def _interaction() -> FloatArray:
    """1.5 times a Gaussian of 10 degrees and sum 1, less 3 / 360 everywhere."""
    near = _bump(math.radians(10.0))
    return np.asarray(1.5 * near / near.sum() - 3.0 / BINS)


_KERNEL = np.fft.rfft(_interaction())


def input_to(wanted_rad: float, obstacles: Sequence[tuple[float, float]]) -> FloatArray:
    """What drives the field, (360,): a wide bump where to go, a dent at every obstacle.

    ``obstacles`` : bearing (rad) and proximity in [0, 1] of each
    """
    drive = _shifted(_bump(WANTED_SIGMA_RAD), wanted_rad)
    for bearing, proximity in obstacles:
        drive -= REPULSION * proximity * _shifted(_bump(BLOCKED_SIGMA_RAD), bearing)
    return drive


def settled(drive: FloatArray) -> FloatArray:
    """Field u (360,) after it has settled: du/dt = -u + h + I + (w * f(u))."""
    u = np.full(BINS, REST)
    for _ in range(STEPS):
        fire = 1.0 / (1.0 + np.exp(-STEEPNESS * u))
        spread = np.fft.irfft(np.fft.rfft(fire) * _KERNEL, BINS)
        u = u + DT * (-u + REST + drive + spread)
    return np.asarray(u)


def heading_of(wanted_rad: float, obstacles: Sequence[tuple[float, float]] = ()) -> float | None:
    """The one heading the field settles on, in [0, 2 pi); None where every way is blocked."""
    u = settled(input_to(wanted_rad, obstacles))
    best = int(np.argmax(np.round(u, 9)))
    return None if u[best] < 0.0 else float(_BEARINGS[best])


def _shifted(bump: FloatArray, bearing_rad: float) -> FloatArray:
    """The bump about a bearing, between bins by interpolation."""
    at = np.mod(_BEARINGS - bearing_rad, TAU) * BINS / TAU
    low = np.floor(at).astype(np.int64) % BINS
    share = at - np.floor(at)
    return np.asarray((1.0 - share) * bump[low] + share * bump[(low + 1) % BINS])
