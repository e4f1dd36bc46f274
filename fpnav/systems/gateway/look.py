"""From a frame to features: the few ranges of a hallway, and the cues of the view."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.cues import CUE, EdgeRule, square_grey, vertical_cues
from fpnav.sensing.pseudo_sonar import Sides, ring_from_scan, sides
from fpnav.sensing.scene import facing_of
from fpnav.sensing.stereo import Rig, focal_px, with_distances
from fpnav.systems.base import Features
from fpnav.systems.gateway.params import GatewayParams
from fpnav.values import Calibration, FloatArray, Frame, Image, SonarRing

NOT_LOOKED = -1


def features_of_frame(frame: Frame, params: GatewayParams) -> Features:
    """``sides`` (7,) of the ring, empty without one; ``facing`` (1,) of the camera, -1 where no
    picture was taken; ``cues`` of the picture."""
    ring = _ring(frame, params)
    seen = None if ring is None else sides(ring, math.radians(params.side_deg))
    facing, cues = NOT_LOOKED, np.zeros(0, CUE)
    if seen is None or params.look == "always" or _opens(seen, params):
        facing, cues = _view(frame, params)
    return {"sides": _row(seen), "facing": np.array([facing], np.int64), "cues": cues}


def sides_of(row: FloatArray) -> Sides | None:
    """The ranges of a feature row, None where it is empty."""
    return Sides(*(float(value) for value in row)) if len(row) else None


def _row(seen: Sides | None) -> FloatArray:
    if seen is None:
        return np.zeros(0)
    return np.array(astuple(seen), dtype=np.float64)


def _ring(frame: Frame, params: GatewayParams) -> SonarRing | None:
    if params.ranges != "scan" and frame.sonar is not None:
        return frame.sonar
    if params.ranges != "sonar" and frame.scan is not None:
        cone = math.radians(params.cone_deg)
        return ring_from_scan(frame.scan, count=params.sonars, cone_rad=cone)
    return None


def _opens(seen: Sides, params: GatewayParams) -> bool:
    """Whether this may be a gateway: one side is far, or the way ahead is not."""
    wide = max(np.nan_to_num(seen.left_m), np.nan_to_num(seen.right_m))
    return bool(wide > LOOK_SIDE_M or seen.front_m < params.front_turn_m)


LOOK_SIDE_M = 1.5
"""Sides nearer than this are walls of any hallway a robot fits in, and of no use to look at."""


def _view(frame: Frame, params: GatewayParams) -> tuple[int, NDArray[np.void]]:
    image = frame.camera
    if image is None:
        return NOT_LOOKED, np.zeros(0, CUE)
    rule = _edges(params)
    cues = vertical_cues(square_grey(image.pixels), rule)
    other = frame.camera_offset
    if other is not None:
        second = vertical_cues(square_grey(other.pixels), rule)
        cues = with_distances(cues, second, _rig(image, other, params))
    mount = image.calibration.mount.heading_rad if image.calibration else 0.0
    facing = facing_of(mount + (frame.pan_rad or 0.0))
    cues["facing"] = facing
    return facing, cues


def _edges(params: GatewayParams) -> EdgeRule:
    return EdgeRule(
        params.edge_steep,
        params.edge_sigmas,
        params.edge_floor,
        params.edge_gap_px,
        params.edge_drift_px,
        params.edge_least_px,
    )


def _rig(first: Image, second: Image, params: GatewayParams) -> Rig:
    """How the two cameras stand; what the calibration leaves out is assumed."""
    one, other = first.calibration, second.calibration
    fov = _known([one, other], "horizontal_fov_rad", math.radians(params.fov_deg))
    aside = 0.0
    if one is not None and other is not None:
        aside = one.mount.y_m - other.mount.y_m
    baseline = _known([other, one], "baseline_m", abs(aside) or params.baseline_m)
    right = aside >= 0.0 if params.offset_camera == "auto" else params.offset_camera == "right"
    return Rig(focal_px(fov), baseline, right)


def _known(calibrations: list[Calibration | None], name: str, otherwise: float) -> float:
    values = [float(getattr(one, name)) for one in calibrations if one is not None]
    return next((value for value in values if math.isfinite(value)), otherwise)
