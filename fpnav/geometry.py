"""Angles and planar poses: radians, metres, x forward, y left, counter-clockwise positive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from fpnav.values import Pose2

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

TAU = 2.0 * math.pi


def wrap(angle_rad: float) -> float:
    """Angle wrapped to [-pi, pi)."""
    wrapped = (angle_rad + math.pi) % TAU - math.pi
    return -math.pi if wrapped >= math.pi else wrapped  # a hair below -pi rounds up to pi


def wrap_array(angles_rad: ArrayLike) -> NDArray[np.float64]:
    """Angles of any shape wrapped to [-pi, pi)."""
    angles: NDArray[np.float64] = np.asarray(angles_rad, dtype=np.float64)
    wrapped = (angles + math.pi) % TAU - math.pi
    return np.where(wrapped >= math.pi, -math.pi, wrapped)


def angular_distance(first_rad: ArrayLike, second_rad: ArrayLike) -> NDArray[np.float64]:
    """Unsigned angular distance in [0, pi], broadcasting."""
    first, second = np.asarray(first_rad, np.float64), np.asarray(second_rad, np.float64)
    return np.abs(wrap_array(first - second))


def compose(first: Pose2, second: Pose2) -> Pose2:
    """Pose ``second``, given in the frame of ``first``, in the frame ``first`` is given in."""
    c, s = math.cos(first.heading_rad), math.sin(first.heading_rad)
    return Pose2(
        first.x_m + c * second.x_m - s * second.y_m,
        first.y_m + s * second.x_m + c * second.y_m,
        wrap(first.heading_rad + second.heading_rad),
    )


def inverse(pose: Pose2) -> Pose2:
    """Pose that undoes ``pose``: ``compose(pose, inverse(pose))`` is the origin."""
    c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    return Pose2(-c * pose.x_m - s * pose.y_m, s * pose.x_m - c * pose.y_m, wrap(-pose.heading_rad))


def relative(origin: Pose2, target: Pose2) -> Pose2:
    """Pose ``target`` as seen from ``origin``."""
    return compose(inverse(origin), target)


def distance(first: Pose2, second: Pose2) -> float:
    """Straight-line distance in metres."""
    return math.hypot(first.x_m - second.x_m, first.y_m - second.y_m)


def transform_points(pose: Pose2, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (N, 2), given in the frame of ``pose``, in the frame ``pose`` is given in."""
    c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    rotation = np.array([[c, s], [-s, c]])
    return np.asarray(points_m @ rotation + np.array([pose.x_m, pose.y_m]), dtype=np.float64)


def interpolate_poses(
    stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], query_ns: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Poses at the query stamps, linear in position and along the shorter arc in heading.

    Parameters
    ----------
    stamps_ns : (N,) int64, strictly increasing
    poses : (N, 3) float64, x_m, y_m, heading_rad
    query_ns : (Q,) int64

    Returns
    -------
    (Q, 3) float64; rows outside the stamped interval are NaN.
    """
    out = np.full((len(query_ns), 3), np.nan)
    if len(stamps_ns) == 0:
        return out
    base = stamps_ns[0]
    time = (stamps_ns - base).astype(np.float64)
    query = (query_ns - base).astype(np.float64)
    inside = (query_ns >= stamps_ns[0]) & (query_ns <= stamps_ns[-1])
    heading = np.unwrap(poses[:, 2])
    for column, values in enumerate((poses[:, 0], poses[:, 1], heading)):
        out[inside, column] = np.interp(query[inside], time, values)
    out[:, 2] = wrap_array(out[:, 2])
    return out


def path_length(positions_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Travelled distance at each position (N, 2); steps from or to a NaN position count zero."""
    steps = np.hypot(*np.diff(positions_m[:, :2], axis=0).T)
    return np.concatenate([np.zeros(min(1, len(positions_m))), np.cumsum(np.nan_to_num(steps))])


def column_bearings(width: int) -> NDArray[np.float64]:
    """Bearing of each column centre of a 360 degree panorama (commands.md): centre ahead, CCW."""
    return math.pi - TAU * (np.arange(width) + 0.5) / width
