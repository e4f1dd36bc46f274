"""Fingerprints of a short stretch of travel: rays and corners all round from odometry windows."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.geometry import TAU
from fpnav.sensing.corners import corners
from fpnav.sensing.rays import rays_of
from fpnav.sensing.window import all_round, carried
from fpnav.systems.base import Features
from fpnav.systems.fingerprint.extract import corner_features
from fpnav.systems.fingerprint.laser import attributes_of, sweep_of
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.record import LASER_ARC
from fpnav.values import FloatArray, Pose2, Reference

_Seen = tuple[Reference, FloatArray, Pose2]


def windowed(
    stream: Iterable[tuple[Reference, Features]], params: FingerprintParams
) -> Iterator[tuple[Reference, Features]]:
    """Features with the scan of each frame made all round by those of the last ``window_m`` metres.

    Raises
    ------
    LogError
        A frame has a scan and no odometry to join it with others by.
    """
    seen: deque[_Seen] = deque()
    for reference, found in stream:
        if not len(found["rays"]):
            yield reference, found
            continue
        here = _sensor(reference, found["mount_m"])
        while seen and _left(seen[0][0], reference, params.window_m):
            seen.popleft()
        sweep = sweep_of(found["rays"])
        past = carried([one[1] for one in seen], [one[2] for one in seen], here)
        scan = all_round(sweep.ranges_m, sweep.start_rad, sweep.step_rad, past)
        x, y = sweep.points
        seen.append((reference, np.column_stack([x, y])[sweep.hits], here))
        mount = Pose2(float(found["mount_m"][0]), float(found["mount_m"][1]), 0.0)
        rays = rays_of(scan, float(np.deg2rad(params.ray_deg)))
        rows = corner_features(corners(replace(scan, mount=mount), TAU, params.corner_epsilon_m))
        arcs = found["arcs"].copy()
        arcs[LASER_ARC] = 0.0, TAU
        features = _with_corners(found["features"], rows)
        attributes = attributes_of(features, rays, found["mount_m"], arcs[LASER_ARC])
        changed = {"features": features, "rays": rays, "attributes": attributes, "arcs": arcs}
        yield reference, {**found, **changed}


def _sensor(reference: Reference, mount_m: FloatArray) -> Pose2:
    """Where the laser stands by odometry."""
    pose = reference.odometry
    if pose is None:
        raise LogError(
            "fingerprint.window_m joins scans by odometry; the log has none: "
            "leave window_m at 0, or ingest the log with its odometry"
        )
    c, s = np.cos(pose.heading_rad), np.sin(pose.heading_rad)
    x, y = (float(value) for value in mount_m)
    return Pose2(pose.x_m + c * x - s * y, pose.y_m + s * x + c * y, pose.heading_rad)


def _left(first: Reference, here: Reference, window_m: float) -> bool:
    """Whether a frame lies further back than the window, or in another session."""
    return first.session != here.session or here.travelled_m - first.travelled_m > window_m


def _with_corners(features: NDArray[np.void], rows: NDArray[np.void]) -> NDArray[np.void]:
    """Features with other corners, by angle."""
    both = np.concatenate([features[features["type"] != b"c"], rows])
    return np.asarray(both[np.lexsort((both["type"], both["angle_rad"]))])
