"""Vertical edges as cues of a scene: where a wall of light meets a wall of dark.

Kortenkamp and Weymouth take vertical edges of a black-and-white image "by a modified Sobel edge
detector"; what was modified is systems.md 3.5. Images of any size are brought to 480 x 480.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.chains import link, steep_pixels
from fpnav.values import FloatArray

SIZE_PX = 480
SOBEL_SUM = 4.0
"""Answer of the 3 x 3 Sobel kernel to a step of 1."""

CUE = np.dtype(
    [
        ("facing", "<i1"),
        ("direction", "<i1"),
        ("x_px", "<f4"),
        ("top_px", "<f4"),
        ("bottom_px", "<f4"),
        ("strength", "<f4"),
        ("distance_m", "<f4"),
    ]
)
"""An edge of an image 480 pixels high and wide. ``facing`` : which of eight directions the camera
looked in, 0 ahead, counter-clockwise; ``direction`` : 1 dark to light from left to right, -1 light
to dark; ``distance_m`` : NaN unknown."""


@dataclass(frozen=True, slots=True)
class EdgeRule:
    """What counts as a vertical edge; pixels of an image 480 high.

    steep : how many times stronger across than down; sigmas : above the mean of the image's
    gradients; floor : and above this, grey levels of 1 that a step across makes, so that the grain
    of a blank wall is none; gap, drift : rows a chain may miss, columns it may wander; least : its
    length
    """

    steep: float = 4.0
    sigmas: float = 2.0
    floor: float = 0.0
    gap_px: int = 5
    drift_px: int = 6
    least_px: int = 60


def square_grey(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Grey image (480, 480) float32 in [0, 1] of a BGR image (H, W, 3) of any size."""
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    if grey.shape != (SIZE_PX, SIZE_PX):
        shrinks = max(grey.shape) > SIZE_PX
        how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        grey = cv2.resize(grey, (SIZE_PX, SIZE_PX), interpolation=how)
    return np.asarray(grey, dtype=np.float32) / np.float32(255.0)


def vertical_cues(grey: NDArray[np.float32], rule: EdgeRule) -> NDArray[np.void]:
    """Vertical edges of a grey image in [0, 1], as CUE rows by column; distances unknown."""
    across, down = (
        np.asarray(cv2.Sobel(grey, cv2.CV_32F, dx, 1 - dx, ksize=3), np.float32) for dx in (1, 0)
    )
    mean, spread = cv2.meanStdDev(np.abs(across))
    threshold = max(float(mean[0, 0] + rule.sigmas * spread[0, 0]), SOBEL_SUM * rule.floor)
    pixels = steep_pixels(across, down, threshold, rule.steep)
    chains = link(across, pixels, rule.gap_px + 1)
    length = chains["bottom"] - chains["top"] + 1
    drift = chains["high"] - chains["low"]
    return _cues(chains[(length >= rule.least_px) & (drift <= rule.drift_px)])


def lengths(cues: NDArray[np.void]) -> FloatArray:
    """Length of each cue in pixels."""
    return np.asarray(cues["bottom_px"] - cues["top_px"] + 1.0, dtype=np.float64)


def _cues(chains: NDArray[np.void]) -> NDArray[np.void]:
    rows = np.zeros(len(chains), CUE)
    rows["direction"] = chains["sign"]
    rows["x_px"] = chains["sum_x"] / chains["count"]
    rows["top_px"], rows["bottom_px"] = chains["top"], chains["bottom"]
    rows["strength"] = chains["sum_strength"] / chains["count"]
    rows["distance_m"] = np.nan
    return rows[np.lexsort((rows["top_px"], rows["x_px"]))]
