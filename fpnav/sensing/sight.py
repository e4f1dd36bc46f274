"""What a camera sees in grey, at one angular resolution, with bearing and elevation of every pixel.

A panorama or unwrapped mirror image is a cylinder of equal angles; a forward camera, panned or
not, stays the pinhole image it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.sensing.panorama import horizontal_fov, mount_heading, omni_calibration, unwrap
from fpnav.values import FloatArray, Image

FLAT_LEVELS = 2
"""Grey levels that pixels of a hidden column may differ by."""


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A grey image with its geometry.

    ``pixels`` : (H, W) uint8; ``axis_rad`` : bearing on the robot of the image centre;
    ``pixels_per_rad`` : resolution at the centre; ``horizon_row`` : row of elevation 0, from 0;
    ``circular`` : a full turn whose last column borders on the first.
    """

    pixels: NDArray[np.uint8]
    axis_rad: float
    pixels_per_rad: float
    horizon_row: float
    circular: bool

    def directions(self, points: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
        """Bearing in [-pi, pi) and elevation of points (n, 2) x, y; (n,) each."""
        right = points[:, 0] + 0.5 - self.pixels.shape[1] / 2.0
        up = self.horizon_row - points[:, 1]
        if self.circular:
            turn, elevation = right / self.pixels_per_rad, up / self.pixels_per_rad
        else:
            turn = np.arctan2(right, self.pixels_per_rad)
            elevation = np.arctan2(up, np.hypot(right, self.pixels_per_rad))
        bearing = (self.axis_rad - turn + math.pi) % TAU - math.pi
        return bearing.astype(np.float64), elevation.astype(np.float64)


def panorama_sight(image: Image, width_px: int) -> Sight:
    """Sight of an unwrapped panorama resampled to ``width_px`` columns and square pixels."""
    return _cylinder(image.pixels, image, width_px)


def omni_sight(image: Image, width_px: int) -> Sight:
    """Sight of a raw catadioptric image; raises LogError where centre or radii are unknown."""
    return _cylinder(unwrap(image.pixels, omni_calibration(image)), image, width_px)


def camera_sight(image: Image, width_px: int, pan_rad: float = 0.0) -> Sight:
    """Sight of a forward camera at the resolution a panorama of ``width_px`` columns has.

    Raises
    ------
    LogError
        The horizontal field of view is unknown.
    """
    per_rad = width_px / TAU
    height, width = image.pixels.shape[:2]
    wide = max(1, round(2.0 * per_rad * math.tan(horizontal_fov(image) / 2.0)))
    pixels = _grey(image.pixels, wide, max(1, round(height * wide / width)))
    axis = mount_heading(image) + pan_rad
    return Sight(pixels, axis, per_rad, _horizon(image, height, len(pixels)), circular=False)


def hidden_columns(pixels: NDArray[np.uint8], reach_px: int) -> NDArray[np.bool_]:
    """Columns (W,) that something hangs over, and those nearer than ``reach_px`` to one.

    A column of one grey from top to bottom, within ``FLAT_LEVELS``, shows no scene.
    """
    flat: NDArray[np.bool_] = np.ptp(pixels, axis=0) <= FLAT_LEVELS
    if not flat.any():
        return flat
    around = np.ones((1, 2 * reach_px + 1), np.uint8)
    return np.asarray(cv2.dilate(flat[None].astype(np.uint8), around)[0] > 0)


def _cylinder(source: NDArray[np.uint8], image: Image, width_px: int) -> Sight:
    height, width = source.shape[:2]
    per_rad = width_px / TAU
    vertical = math.nan if image.calibration is None else image.calibration.vertical_fov_rad
    rows = vertical * per_rad if math.isfinite(vertical) else height * width_px / width
    pixels = _grey(source, width_px, max(1, round(rows)))
    horizon = _horizon(image, height, len(pixels))
    return Sight(pixels, mount_heading(image), per_rad, horizon, circular=True)


def _horizon(image: Image, source_rows: int, rows: int) -> float:
    """Row of elevation 0 after resampling; the middle where the calibration does not say."""
    row = math.nan if image.calibration is None else image.calibration.horizon_row
    if not math.isfinite(row):
        return (rows - 1) / 2.0
    return (row + 0.5) * rows / source_rows - 0.5


def _grey(pixels: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    if grey.shape == (height, width):
        return np.asarray(grey)
    shrinks = width <= grey.shape[1] and height <= grey.shape[0]
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(grey, (width, height), interpolation=how))
