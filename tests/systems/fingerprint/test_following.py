"""Where a feature must stand after a motion, and in how many fingerprints it stood."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fpnav.systems.base import Features
from fpnav.systems.fingerprint.following import LAST, UNKNOWN_M, counted, partners, ranges
from fpnav.systems.fingerprint.symbols import FEATURE, features_of
from fpnav.values import ORIGIN, FloatArray, Pose2, Reference


def seen_from(pose: Pose2, letters: str, points_m: FloatArray) -> NDArray[Any]:
    """Features at points (F, 2) from a pose, in the order given; corners know their range."""
    x, y = (points_m - np.array([pose.x_m, pose.y_m])).T
    kinds = np.frombuffer(letters.encode(), "S1")
    angles = np.arctan2(y, x) - pose.heading_rad
    rows = features_of(kinds, angles, np.full(len(kinds), 0.5))
    rows["range_m"] = np.where(kinds == b"c", np.hypot(x, y), np.nan)
    return rows


def in_order(rows: NDArray[Any]) -> NDArray[Any]:
    return rows[np.argsort(rows["angle_rad"], kind="stable")]


ROOM_M = np.array([[4.0, 3.0], [-4.0, 3.0], [-4.0, -3.0], [4.0, -3.0]])
WALL_M = np.array([[4.0, 1.2], [1.0, 3.0], [-2.5, 3.0], [-4.0, -1.0], [0.5, -3.0], [3.0, -3.0]])


@given(st.floats(-2.0, 2.0), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_what_is_on_a_wall_between_corners_has_the_range_of_the_wall(
    x: float, y: float, heading: float
) -> None:
    pose = Pose2(x, y, heading)
    points = np.concatenate([ROOM_M, WALL_M])
    rows = seen_from(pose, "ccccvAvBvC", points)
    assert ranges(rows) == pytest.approx(np.hypot(*(points - [x, y]).T), rel=1e-5)


def test_ranges_are_unknown_without_corners_and_the_nearer_ones_behind_an_open_arc() -> None:
    edges = seen_from(ORIGIN, "vA", np.array([[1.0, 0.5], [0.0, 2.0]]))
    assert ranges(edges).tolist() == [UNKNOWN_M, UNKNOWN_M]
    one = seen_from(ORIGIN, "cv", np.array([[2.0, 0.0], [-1.0, 1.0]]))
    assert ranges(one)[1] == pytest.approx(2.0)
    assert len(ranges(one[:0])) == 0


@given(st.floats(-0.8, 0.8), st.floats(-0.6, 0.6), st.floats(-3.1, 3.1))
def test_features_are_found_where_they_must_stand_after_the_motion(
    x: float, y: float, heading: float
) -> None:
    points = np.concatenate([ROOM_M, WALL_M])
    first = seen_from(ORIGIN, "ccccvAvBvC", points)
    motion = Pose2(x, y, heading)
    second = seen_from(motion, "ccccvAvBvC", points)
    assert partners(first, second, motion).tolist() == list(range(len(points)))


def test_another_type_another_place_and_a_second_one_are_no_partners() -> None:
    first = seen_from(ORIGIN, "cv", np.array([[3.0, 0.0], [0.0, 3.0]]))
    other = first.copy()
    other["type"] = [b"v", b"v"]
    assert partners(first, other, ORIGIN).tolist() == [-1, 1]
    off = first.copy()
    off["angle_rad"] += np.deg2rad([2.9, 3.1])
    assert partners(first, off, ORIGIN).tolist() == [0, -1]
    twice = np.concatenate([first[:1], first[:1]])
    twice["angle_rad"] = np.deg2rad([0.5, 1.0])
    assert (partners(twice, first, ORIGIN) >= 0).tolist() == [True, False]
    assert partners(first, first[:0], ORIGIN).tolist() == [-1, -1]
    assert len(partners(first[:0], first, ORIGIN)) == 0


def drive(count: int, odometry: bool = True, cut: int = 0) -> list[tuple[Reference, Features]]:
    """Frames 0.15 m apart; a last edge is there from the fourth frame on."""
    frames: list[tuple[Reference, Features]] = []
    for at in range(count):
        pose = Pose2(0.15 * at, 0.0, 0.02 * at)
        points, letters = np.concatenate([ROOM_M, WALL_M]), "ccccvAvBvC"
        if at < 3:
            points, letters = points[:-1], letters[:-1]
        rows = in_order(seen_from(pose, letters, points))
        reference = Reference(at, at, int(at >= cut > 0), 0.15 * at, pose if odometry else None)
        frames.append((reference, {"features": rows, "arcs": np.zeros((2, 2))}))
    return frames


def test_features_know_in_how_many_of_the_last_fingerprints_they_stood() -> None:
    found = [one["features"] for _, one in counted(iter(drive(9)))]
    for at, rows in enumerate(found):
        late = rows["type"] == b"C"
        assert (rows["seen"][~late] == 1 + min(at, LAST)).all()
        assert (rows["seen"][late] == 1 + at - 3).all()
        assert rows.dtype == FEATURE


def test_nothing_before_counts_without_odometry_or_in_another_session() -> None:
    for _, one in counted(iter(drive(4, odometry=False))):
        assert (one["features"]["seen"] == 1).all()
    found = [one["features"]["seen"].max() for _, one in counted(iter(drive(6, cut=4)))]
    assert found == [1, 2, 3, 4, 1, 2]


def test_what_is_counted_leaves_the_frames_as_they_were() -> None:
    frames = drive(3)
    list(counted(iter(frames)))
    assert all((one["features"]["seen"] == 1).all() for _, one in frames)
