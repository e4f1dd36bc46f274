"""How far vertical edges are: two images from places side by side, edges matched in order.

Kortenkamp and Weymouth match by direction of transition, length and location; the candidates and
costs are those of systems.md 3.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.cues import SIZE_PX, lengths
from fpnav.sensing.pairing import in_order
from fpnav.values import FloatArray

OVERLAP = 0.5
LENGTH_RATIO = 0.6, 1.67
"""Candidates overlap by half of the shorter, and are about as long."""

WEIGHTS = 0.5, 1.0 / 240.0, 0.2
"""Cost of a difference in log length, in height of the middle (pixels), in relative strength."""

UNMATCHED = 0.6


@dataclass(frozen=True, slots=True)
class Rig:
    """Two cameras side by side: focal length in pixels of an image 480 wide, distance between
    them, and whether the second stands to the right of the first."""

    focal_px: float
    baseline_m: float
    second_right: bool = True
    disparity_px: tuple[float, float] = (1.0, 160.0)


def focal_px(horizontal_fov_rad: float) -> float:
    """Focal length in pixels of an image 480 wide: 415.7 at 60 degrees."""
    return 0.5 * SIZE_PX / math.tan(0.5 * horizontal_fov_rad)


def with_distances(first: NDArray[np.void], second: NDArray[np.void], rig: Rig) -> NDArray[np.void]:
    """Cues of the first image with the distance of those found again in the second; Z = f b / d."""
    disparity = first["x_px"][:, None].astype(np.float64) - second["x_px"][None, :]
    disparity = disparity if rig.second_right else -disparity
    partner = in_order(pair_costs(first, second, disparity, rig.disparity_px), UNMATCHED)
    out = first.copy()
    rows = np.flatnonzero(partner >= 0)
    out["distance_m"][rows] = rig.focal_px * rig.baseline_m / disparity[rows, partner[rows]]
    return out


def pair_costs(
    first: NDArray[np.void],
    second: NDArray[np.void],
    disparity_px: FloatArray,
    limits_px: tuple[float, float],
) -> FloatArray:
    """Cost of each pair (n, m), +inf where it is no candidate."""
    long, other = lengths(first)[:, None], lengths(second)[None, :]
    bottom = np.minimum(first["bottom_px"][:, None], second["bottom_px"][None, :])
    top = np.maximum(first["top_px"][:, None], second["top_px"][None, :])
    ratio = long / other
    possible = (
        (first["direction"][:, None] == second["direction"][None, :])
        & (bottom - top + 1.0 >= OVERLAP * np.minimum(long, other))
        & (ratio >= LENGTH_RATIO[0])
        & (ratio <= LENGTH_RATIO[1])
        & (disparity_px >= limits_px[0])
        & (disparity_px <= limits_px[1])
    )
    high = np.abs(_middle(first)[:, None] - _middle(second)[None, :])
    strong, weak = first["strength"][:, None], second["strength"][None, :]
    apart = np.abs(strong - weak) / np.maximum(np.maximum(strong, weak), 1e-9)
    cost = WEIGHTS[0] * np.abs(np.log(ratio)) + WEIGHTS[1] * high + WEIGHTS[2] * apart
    return np.where(possible, cost, np.inf)


def _middle(cues: NDArray[np.void]) -> FloatArray:
    return np.asarray(0.5 * (cues["top_px"] + cues["bottom_px"]), dtype=np.float64)
