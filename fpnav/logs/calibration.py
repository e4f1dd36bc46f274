"""How a Calibration travels in sensor_msgs/CameraInfo.

The distortion model says which kind of camera it is:

``plumb_bob`` (and every other ROS model) : pinhole. K and P hold fx, fy, cx, cy; the fields of
    view are 2 atan(W / 2fx) and 2 atan(H / 2fy), the horizon row is cy, the baseline B of a
    laterally offset twin is in P[3] = -fx B. K[0] = 0 means not calibrated.
``equidistant`` : fisheye, the field of view is W / fx.
``fpnav_panorama`` : D = [vertical field of view (rad), horizon row (px)]. K is zero.
``fpnav_omni`` : D = [centre x, centre y, inner radius, outer radius (px), vertical field of view
    (rad), horizon row (px)]. K is zero.

NaN stands for unknown. The mount is not part of it: it travels in /tf_static.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fpnav.logs.messages import CAMERA_INFO, header, make
from fpnav.values import ORIGIN, Calibration, FloatArray, Pose2

PANORAMA_MODEL = "fpnav_panorama"
OMNI_MODEL = "fpnav_omni"
_MODELS = {"panorama": PANORAMA_MODEL, "omni": OMNI_MODEL}


def camera_info(role: str, stamp_ns: int, frame_id: str, calibration: Calibration) -> Any:
    """sensor_msgs/CameraInfo of the camera that plays a role."""
    model = _MODELS.get(role, "plumb_bob")
    intrinsic, projection = _pinhole(calibration) if model == "plumb_bob" else _unknown()
    return make(
        CAMERA_INFO,
        header=header(stamp_ns, frame_id),
        height=calibration.height_px,
        width=calibration.width_px,
        distortion_model=model,
        d=_distortion(model, calibration),
        k=intrinsic,
        r=np.eye(3).ravel(),
        p=projection,
        binning_x=0,
        binning_y=0,
        roi=make(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        ),
    )


def calibration_of(
    width: int,
    height: int,
    model: str,
    distortion: FloatArray,
    intrinsic: FloatArray,
    projection: FloatArray,
    mount: Pose2 = ORIGIN,
) -> Calibration:
    """Calibration that a CameraInfo's fields describe; ``intrinsic`` is K (9), ``projection`` P."""
    values = [float(value) for value in distortion]
    if model == PANORAMA_MODEL and len(values) >= 2:
        return Calibration(
            width,
            height,
            horizontal_fov_rad=2.0 * math.pi,
            vertical_fov_rad=values[0],
            horizon_row=values[1],
            mount=mount,
        )
    if model == OMNI_MODEL and len(values) >= 6:
        x, y, inner, outer, vertical, horizon = values[:6]
        return Calibration(
            width,
            height,
            horizontal_fov_rad=2.0 * math.pi,
            vertical_fov_rad=vertical,
            horizon_row=horizon,
            centre_x_px=x,
            centre_y_px=y,
            radius_in_px=inner,
            radius_out_px=outer,
            mount=mount,
        )
    return _from_pinhole(width, height, model, intrinsic, projection, mount)


def _distortion(model: str, calibration: Calibration) -> FloatArray:
    c = calibration
    if model == PANORAMA_MODEL:
        return np.array([c.vertical_fov_rad, c.horizon_row])
    if model == OMNI_MODEL:
        radii = [c.radius_in_px, c.radius_out_px]
        return np.array([c.centre_x_px, c.centre_y_px, *radii, c.vertical_fov_rad, c.horizon_row])
    return np.zeros(5)


def _unknown() -> tuple[FloatArray, FloatArray]:
    return np.zeros(9), np.zeros(12)


def _pinhole(c: Calibration) -> tuple[FloatArray, FloatArray]:
    """K and P; square pixels where only the horizontal field of view is known."""
    if not 0.0 < c.horizontal_fov_rad < math.pi:
        return _unknown()
    fx = 0.5 * c.width_px / math.tan(0.5 * c.horizontal_fov_rad)
    fy = fx
    if 0.0 < c.vertical_fov_rad < math.pi:
        fy = 0.5 * c.height_px / math.tan(0.5 * c.vertical_fov_rad)
    cx = 0.5 * (c.width_px - 1) if math.isnan(c.centre_x_px) else c.centre_x_px
    cy = 0.5 * (c.height_px - 1) if math.isnan(c.horizon_row) else c.horizon_row
    offset = 0.0 if math.isnan(c.baseline_m) else -fx * c.baseline_m
    intrinsic = np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
    projection = np.array([fx, 0.0, cx, offset, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0])
    return intrinsic, projection


def _from_pinhole(
    width: int,
    height: int,
    model: str,
    intrinsic: FloatArray,
    projection: FloatArray,
    mount: Pose2,
) -> Calibration:
    fx, cx, fy, cy = (float(intrinsic[i]) for i in (0, 2, 4, 5))
    if not (fx > 0.0 and fy > 0.0 and math.isfinite(fx + fy)):
        return Calibration(width, height, mount=mount)
    fisheye = model in ("equidistant", "fisheye")
    return Calibration(
        width,
        height,
        horizontal_fov_rad=width / fx if fisheye else 2.0 * math.atan2(0.5 * width, fx),
        vertical_fov_rad=height / fy if fisheye else 2.0 * math.atan2(0.5 * height, fy),
        horizon_row=cy,
        centre_x_px=cx,
        centre_y_px=cy,
        baseline_m=_baseline(projection),
        mount=mount,
    )


def _baseline(projection: FloatArray) -> float:
    """Lateral offset from P[3] = -fx B; NaN where there is none."""
    fx, shift = float(projection[0]), float(projection[3])
    return -shift / fx if fx > 0.0 and shift != 0.0 else math.nan
