"""What a laser scan looks like from where it was taken, as grids over bearing."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.values import FloatArray

RINGS_M = 15.0
PAIR_MIN_M = 0.3


def polar_grid(points_m: FloatArray, bins: int, rings: int) -> FloatArray:
    """Hits by bearing and logarithm of range, blurred, (bins, rings).

    Scan Context (Kim and Kim, IROS 2018) without heights: a planar scan has hits for them.

    Parameters
    ----------
    points_m : (N, 2) about the centre of the grid
    """
    ranges = np.hypot(points_m[:, 0], points_m[:, 1])
    bearings = np.arctan2(points_m[:, 1], points_m[:, 0])
    grid = np.zeros((bins, rings))
    column = np.floor((bearings % TAU) / TAU * bins).astype(int) % bins
    ring = np.floor(np.log1p(ranges) / np.log1p(RINGS_M) * rings).astype(int)
    np.add.at(grid, (column, np.minimum(ring, rings - 1)), 1.0)
    wrapped = np.pad(np.minimum(grid, 2.0), ((2, 2), (0, 0)), mode="wrap")
    blurred = cv2.GaussianBlur(wrapped, (5, 5), 1.0, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(blurred[2:-2], dtype=np.float64)


def covered(centre_rad: float, width_rad: float, bins: int) -> NDArray[np.bool_]:
    """Bearing bins whose middle lies on an arc, (bins,)."""
    middles = (np.arange(bins) + 0.5) * (TAU / bins)
    off = np.abs((middles - centre_rad + np.pi) % TAU - np.pi)
    return np.asarray(off <= width_rad / 2.0 + 1e-9)


def pair_histogram(points_m: FloatArray, bins: int, steps: int, most_m: float) -> FloatArray:
    """Pairs of points by direction and distance, the root of each count, (bins, steps).

    GLAROT (Rizzini, Galasso, Caselli, 2019; GLARE: Himstedt et al., IROS 2014): it minds neither
    where the sensor stood nor, but for a shift, how it was turned. Every pair counts in both
    directions and is shared out linearly.
    """
    apart = points_m[None, :, :] - points_m[:, None, :]
    distance = np.hypot(apart[..., 0], apart[..., 1])
    kept = (distance >= PAIR_MIN_M) & (distance <= most_m)
    step = distance[kept] / most_m * steps - 0.5
    turn = np.arctan2(apart[..., 1], apart[..., 0])[kept] % TAU / TAU * bins
    histogram = np.zeros((bins, steps))
    low, left = np.floor(step).astype(int), np.floor(turn).astype(int)
    for ring, far in ((low, 1.0 - (step - low)), (low + 1, step - low)):
        inside = (ring >= 0) & (ring < steps)
        for column, side in ((left, 1.0 - (turn - left)), (left + 1, turn - left)):
            share = (far * side)[inside]
            np.add.at(histogram, (column[inside] % bins, ring[inside]), share)
    return np.sqrt(histogram)
