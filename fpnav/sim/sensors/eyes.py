"""Camera geometries: which way each pixel looks, in the robot's frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import column_bearings
from fpnav.params import Params
from fpnav.sim.raycast import Float32Array
from fpnav.values import Calibration, Pose2


class PanoramaEye(Params, frozen=True):
    """Equirectangular strip, the horizon in its middle, square pixels."""

    width_px: int = 720
    height_px: int = 120
    height_m: float = 1.05

    @property
    def vertical_fov_rad(self) -> float:
        """Rows are as many radians apart as columns."""
        return 2.0 * math.pi * self.height_px / self.width_px

    def calibration(self) -> Calibration:
        """What the log says of it."""
        return Calibration(
            self.width_px,
            self.height_px,
            horizontal_fov_rad=2.0 * math.pi,
            vertical_fov_rad=self.vertical_fov_rad,
            horizon_row=(self.height_px - 1) / 2,
        )


class OmniEye(Params, frozen=True):
    """Camera looking up at a mirror: ahead is up, bearings run counter-clockwise.

    The radius grows linearly with elevation, from ``radius_in_px`` at half the vertical field of
    view below the horizon to ``radius_out_px`` at half of it above.
    """

    size_px: int = 480
    radius_in_px: float = 64.0
    radius_out_px: float = 232.0
    vertical_fov_deg: float = 60.0
    height_m: float = 1.05

    def calibration(self) -> Calibration:
        """What the log says of it."""
        middle = (self.size_px - 1) / 2
        return Calibration(
            self.size_px,
            self.size_px,
            horizontal_fov_rad=2.0 * math.pi,
            vertical_fov_rad=math.radians(self.vertical_fov_deg),
            horizon_row=(self.radius_out_px - self.radius_in_px) / 2 - 0.5,
            centre_x_px=middle,
            centre_y_px=middle,
            radius_in_px=self.radius_in_px,
            radius_out_px=self.radius_out_px,
        )


class CameraEye(Params, frozen=True):
    """Pinhole camera looking ahead; its twin stands ``baseline_m`` to the right."""

    width_px: int = 480
    height_px: int = 480
    fov_deg: float = 60.0
    baseline_m: float = 0.18
    height_m: float = 1.05

    @property
    def focal_px(self) -> float:
        """Focal length in pixels."""
        return 0.5 * self.width_px / math.tan(math.radians(self.fov_deg) / 2)

    def calibration(self, *, offset: bool = False) -> Calibration:
        """What the log says of it, or of its twin."""
        return Calibration(
            self.width_px,
            self.height_px,
            horizontal_fov_rad=math.radians(self.fov_deg),
            vertical_fov_rad=2.0 * math.atan2(0.5 * self.height_px, self.focal_px),
            horizon_row=(self.height_px - 1) / 2,
            centre_x_px=(self.width_px - 1) / 2,
            centre_y_px=(self.height_px - 1) / 2,
            baseline_m=self.baseline_m if offset else math.nan,
            mount=self.mount(offset=offset),
        )

    def mount(self, *, offset: bool = False) -> Pose2:
        """Where it stands on the robot."""
        return Pose2(0.0, -self.baseline_m if offset else 0.0, 0.0)


class PanTilt(Params, frozen=True):
    """Head that takes a row of partial views, left to right, while the robot goes on."""

    views: int = 9
    width_px: int = 192
    height_px: int = 144
    sweep_deg: float = 240.0
    period_s: float = 0.12

    def angles_rad(self) -> NDArray[np.float64]:
        """Pan angles of the views; left is positive."""
        half = math.radians(self.sweep_deg) / 2
        return np.linspace(half, -half, self.views)


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """Directions (H * W, 3) float32, unit, robot frame; the angle one pixel covers; the shape."""

    directions: Float32Array
    pixel_rad: float
    shape: tuple[int, int]
    seen: NDArray[np.bool_] | None = None


def panorama_rays(eye: PanoramaEye) -> Rays:
    """Column bearings of commands.md, row elevations centred on the horizon."""
    step = 2.0 * math.pi / eye.width_px
    up = ((eye.height_px - 1) / 2 - np.arange(eye.height_px)) * step
    bearing, elevation = np.meshgrid(column_bearings(eye.width_px), up)
    return Rays(_sphere(bearing, elevation), step, bearing.shape)


def omni_rays(eye: OmniEye) -> Rays:
    """Rays of the ring between the two radii; the rest of the image is black."""
    middle = (eye.size_px - 1) / 2
    x, y = np.meshgrid(np.arange(eye.size_px) - middle, middle - np.arange(eye.size_px))
    radius = np.hypot(x, y)
    bearing = np.arctan2(-x, y)
    mean, depth = (eye.radius_in_px + eye.radius_out_px) / 2, eye.radius_out_px - eye.radius_in_px
    elevation = (radius - mean) / depth * math.radians(eye.vertical_fov_deg)
    seen = (radius >= eye.radius_in_px) & (radius <= eye.radius_out_px)
    return Rays(_sphere(bearing, elevation), 1.0 / mean, bearing.shape, seen.ravel())


def camera_rays(eye: CameraEye) -> Rays:
    """Rays of a pinhole camera."""
    width, height, focal = eye.width_px, eye.height_px, eye.focal_px
    x, y = np.meshgrid(np.arange(width) - (width - 1) / 2, np.arange(height) - (height - 1) / 2)
    ahead = np.stack([np.full(x.shape, focal), -x, -y], axis=-1).reshape(-1, 3)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    return Rays(ahead.astype(np.float32), 1.0 / focal, (height, width))


def _sphere(bearing: NDArray[np.float64], elevation: NDArray[np.float64]) -> Float32Array:
    level = np.cos(elevation)
    xyz = np.stack([level * np.cos(bearing), level * np.sin(bearing), np.sin(elevation)], axis=-1)
    return xyz.reshape(-1, 3).astype(np.float32)
