"""From a frame to features: what the camera and the laser see of a place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.sensing import corners as laser
from fpnav.sensing import edges, hues, panorama
from fpnav.sensing.rays import RAY, rays_of
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.symbols import (
    ALPHABET,
    CAMERA,
    FEATURE,
    LASER,
    features_of,
)
from fpnav.values import FloatArray, Frame

CAMERA_ROLES = ("panorama", "omni", "camera")

_LETTERS = np.array(list(ALPHABET), dtype="S1")


def features_of_frame(frame: Frame, params: FingerprintParams) -> tuple[NDArray[Any], FloatArray]:
    """Features by angle, and the arcs the sensors covered (2, 2): laser, camera."""
    parts = [np.zeros(0, FEATURE)]
    arcs = np.zeros((2, 2))
    if params.use_laser and frame.scan is not None:
        fov = np.deg2rad(params.laser_fov_deg)
        parts.append(corner_features(laser.corners(frame.scan, fov, params.corner_epsilon_m)))
        arcs[LASER] = laser.sensed_arc(frame.scan, fov)
    view = _view(frame) if params.use_camera else None
    if view is not None:
        parts.append(_edges(view))
        if params.use_colour:
            parts.append(_patches(panorama.white_balanced(view) if params.white_balance else view))
        arcs[CAMERA] = view.centre_rad, min(view.width_rad, TAU)
    found = np.concatenate(parts)
    order = np.lexsort((found["type"], found["angle_rad"]))
    return found[order], arcs


def rays_of_frame(frame: Frame, params: FingerprintParams) -> tuple[NDArray[Any], FloatArray]:
    """Rays kept for geometry, and where the laser stands on the robot (2,); none without both."""
    scan = frame.scan
    if scan is None or not params.use_laser or params.ray_deg <= 0.0:
        return np.zeros(0, RAY), np.zeros(2)
    rays = rays_of(scan, float(np.deg2rad(params.ray_deg)))
    rays = rays[np.abs(rays["bearing_rad"]) <= np.deg2rad(params.laser_fov_deg / 2.0) + 1e-6]
    return rays, np.array([scan.mount.x_m, scan.mount.y_m])


def _view(frame: Frame) -> panorama.View | None:
    if frame.panorama is not None:
        return panorama.from_panorama(frame.panorama)
    if frame.omni is not None:
        return panorama.from_omni(frame.omni)
    if frame.camera is not None:
        return panorama.from_camera(frame.camera)
    return None


def corner_features(found: laser.Corners) -> NDArray[Any]:
    """Rows of features, one a corner."""
    letters = np.full(len(found.bearings_rad), b"c")
    rows = features_of(letters, found.bearings_rad, found.certainty)
    rows["range_m"] = found.ranges_m
    return rows


def _edges(view: panorama.View) -> NDArray[Any]:
    columns, certainty = edges.vertical_edges(panorama.grey(view), circular=view.circular)
    return features_of(np.full(len(columns), b"v"), view.bearing_at(columns), certainty)


def _patches(view: panorama.View) -> NDArray[Any]:
    found = hues.hue_patches(view.pixels, circular=view.circular)
    rows = features_of(_LETTERS[found.bins], view.bearing_at(found.columns), found.certainty)
    rows["width_rad"] = found.widths * panorama.STEP_RAD
    return rows
