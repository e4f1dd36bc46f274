"""Any camera image as a view: an equal-angle strip whose columns have a known bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.geometry import TAU, column_bearings
from fpnav.values import Calibration, FloatArray, Image

FloatImage = NDArray[np.float32]

WIDTH = 720
HEIGHT = 120
STEP_RAD = TAU / WIDTH
PAD = 3


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """An image of equal angular steps.

    ``pixels`` : (HEIGHT, W, 3) uint8 BGR; ``bearings_rad`` : (W,) of the column
    centres on the robot, decreasing by ``STEP_RAD`` from left to right; ``circular`` where the
    last column borders on the first.
    """

    pixels: NDArray[np.uint8]
    bearings_rad: FloatArray
    circular: bool

    @property
    def width_rad(self) -> float:
        """Angle the columns cover."""
        return len(self.bearings_rad) * STEP_RAD

    @property
    def centre_rad(self) -> float:
        """Bearing of the middle of the strip."""
        return float((self.bearings_rad[0] + self.bearings_rad[-1]) / 2.0)

    def bearing_at(self, columns: FloatArray) -> FloatArray:
        """Bearings at fractional column positions."""
        return np.asarray(self.bearings_rad[0] - STEP_RAD * np.asarray(columns), dtype=np.float64)


def from_panorama(image: Image) -> View:
    """View of an unwrapped 360 degree image; column bearings as in the file conventions."""
    pixels = _resized(image.pixels, WIDTH)
    return _view(pixels, column_bearings(WIDTH) + mount_heading(image), circular=True)


def from_omni(image: Image) -> View:
    """View of a raw catadioptric image.

    Raises
    ------
    LogError
        The calibration lacks the centre or the radii.
    """
    return _view(
        _resized(unwrap(image.pixels, omni_calibration(image)), WIDTH),
        column_bearings(WIDTH) + mount_heading(image),
        circular=True,
    )


def from_camera(image: Image) -> View:
    """View of a forward pinhole image, resampled to equal angles.

    Raises
    ------
    LogError
        The horizontal field of view is unknown.
    """
    fov = horizontal_fov(image)
    width = max(1, math.floor(fov / STEP_RAD + 1e-6))
    bearings = np.asarray((width / 2.0 - 0.5 - np.arange(width)) * STEP_RAD, dtype=np.float64)
    source_width = image.pixels.shape[1]
    focal = source_width / (2.0 * math.tan(fov / 2.0))
    scale = cv2.resize(image.pixels, (source_width, HEIGHT), interpolation=cv2.INTER_AREA)
    columns = source_width / 2.0 - 0.5 - focal * np.tan(bearings)
    map_x = np.tile(columns.astype(np.float32), (HEIGHT, 1))
    map_y = np.tile(np.arange(HEIGHT, dtype=np.float32)[:, None], (1, width))
    pixels = cv2.remap(scale, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return _view(pixels, bearings + mount_heading(image), circular=False)


def unwrap(pixels: NDArray[np.uint8], calibration: Calibration) -> NDArray[np.uint8]:
    """Panorama of a catadioptric image, outer radius on top.

    The image is taken as looking up at the mirror: up in the image is the robot's heading and
    angles run counter-clockwise as seen in the image.

    Parameters
    ----------
    pixels : (H, W, C) uint8
    calibration : centre and radii in pixels

    Returns
    -------
    (rows, 4 * radius_out, C) uint8, columns as in the file conventions.
    """
    radius = calibration.radius_out_px
    around = max(8, round(4.0 * radius))
    polar = cv2.warpPolar(
        pixels,
        (max(1, round(radius)), around),
        (calibration.centre_x_px, calibration.centre_y_px),
        radius,
        cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS,
    )
    ring = polar[:, max(0, round(calibration.radius_in_px)) :]
    # warpPolar row r points at 360 r / rows degrees, clockwise on the screen from the right;
    # the heading (up) is row 3/4, and the panorama's left edge is the rear (down), row 1/4
    columns = np.roll(ring, -round(around / 4.0), axis=0)
    return np.ascontiguousarray(np.rot90(columns))


def white_balanced(view: View) -> View:
    """The view with equal channel means (grey world)."""
    means = view.pixels.reshape(-1, 3).mean(axis=0)
    gains = means.mean() / np.maximum(means, 1e-6)
    pixels = np.clip(np.rint(view.pixels * gains), 0.0, 255.0).astype(np.uint8)
    return View(pixels, view.bearings_rad, view.circular)


def grey(view: View) -> FloatImage:
    """Luminance in [0, 1], (HEIGHT, W)."""
    luminance = cv2.cvtColor(view.pixels, cv2.COLOR_BGR2GRAY)
    return np.asarray(luminance * np.float32(1.0 / 255.0))


def _resized(pixels: NDArray[Any], width: int) -> NDArray[Any]:
    shrinks = pixels.shape[1] >= width and pixels.shape[0] >= HEIGHT
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(pixels, (width, HEIGHT), interpolation=how))


def _view(pixels: NDArray[Any], bearings: FloatArray, *, circular: bool) -> View:
    """Light blur (sigma 1 px), wrapping where the view is circular; in bytes, for speed."""
    border = cv2.BORDER_WRAP if circular else cv2.BORDER_REPLICATE
    padded = cv2.copyMakeBorder(pixels, 0, 0, PAD, PAD, border)
    blurred = cv2.GaussianBlur(padded, (7, 7), 1.0)
    return View(np.ascontiguousarray(blurred[:, PAD:-PAD]), bearings, circular)


def mount_heading(image: Image) -> float:
    """Heading of the camera on the robot; 0 where unknown."""
    return 0.0 if image.calibration is None else image.calibration.mount.heading_rad


def horizontal_fov(image: Image) -> float:
    """Horizontal field of view of a forward camera; raises LogError where it is unknown."""
    fov = math.nan if image.calibration is None else image.calibration.horizontal_fov_rad
    if not 0.0 < fov < math.pi:
        found = "none" if math.isnan(fov) else f"{math.degrees(fov):.1f} degrees"
        raise LogError(
            f"the camera's horizontal field of view is needed (found {found}, expected 0 to 180 "
            "degrees); ingest the recording with --role camera --hfov DEGREES"
        )
    return fov


def omni_calibration(image: Image) -> Calibration:
    """Calibration of a catadioptric image; raises LogError where centre or radii are unknown."""
    found = image.calibration
    if found is None or not (
        math.isfinite(found.centre_x_px)
        and math.isfinite(found.centre_y_px)
        and 0.0 <= found.radius_in_px < found.radius_out_px
    ):
        raise LogError(
            "an omnidirectional image needs its centre and radii (centre_x_px, centre_y_px, "
            "radius_in_px < radius_out_px); they come with its camera_info"
        )
    return found
