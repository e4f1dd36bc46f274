"""Angles and planar poses against closed forms and their own algebra."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.geometry import (
    TAU,
    angular_distance,
    column_bearings,
    compose,
    distance,
    interpolate_poses,
    inverse,
    path_length,
    relative,
    transform_points,
    wrap,
    wrap_array,
)
from fpnav.values import ORIGIN, Pose2

angles = st.floats(-50.0, 50.0)
metres = st.floats(-100.0, 100.0)
poses = st.builds(Pose2, metres, metres, angles)


def same(first: Pose2, second: Pose2) -> bool:
    apart = float(angular_distance(first.heading_rad, second.heading_rad))
    return distance(first, second) < 1e-9 and apart < 1e-9


@given(angles)
def test_wrapped_angles_lie_in_the_half_open_turn_and_point_the_same_way(angle: float) -> None:
    wrapped = wrap(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.isclose(math.cos(wrapped), math.cos(angle), abs_tol=1e-9)
    assert math.isclose(math.sin(wrapped), math.sin(angle), abs_tol=1e-9)
    assert wrap_array(angle) == wrapped


@pytest.mark.parametrize(
    "angle", [math.pi, -math.pi, math.nextafter(-math.pi, -9), 3 * math.pi, -7 * math.pi]
)
def test_the_rear_is_minus_pi_however_it_is_reached(angle: float) -> None:
    assert wrap(angle) == pytest.approx(-math.pi)
    assert wrap(angle) < math.pi
    assert wrap_array([angle])[0] == wrap(angle)


def test_an_unknown_angle_stays_unknown() -> None:
    assert math.isnan(wrap(math.nan))
    assert np.isnan(wrap_array([math.nan, 1.0])).tolist() == [True, False]


@given(angles, angles)
def test_angular_distance_is_symmetric_and_at_most_half_a_turn(first: float, second: float) -> None:
    apart = float(angular_distance(first, second))
    assert 0.0 <= apart <= math.pi
    assert apart == pytest.approx(float(angular_distance(second, first)), abs=1e-9)
    assert math.cos(apart) == pytest.approx(math.cos(first - second), abs=1e-9)


def test_angular_distance_goes_the_short_way_over_the_rear() -> None:
    assert angular_distance([3.0, 0.1], [-3.0, -0.1]) == pytest.approx([TAU - 6.0, 0.2])


def test_a_step_ahead_after_a_left_turn_goes_left() -> None:
    turned = compose(Pose2(1.0, 2.0, math.pi / 2), Pose2(3.0, 0.0, math.pi / 2))
    assert same(turned, Pose2(1.0, 5.0, math.pi))


def test_what_stands_to_the_left_has_positive_y() -> None:
    seen = relative(Pose2(1.0, 1.0, 0.0), Pose2(1.0, 3.0, 0.5))
    assert same(seen, Pose2(0.0, 2.0, 0.5))


@given(poses)
def test_a_pose_and_its_inverse_cancel(pose: Pose2) -> None:
    assert same(compose(pose, inverse(pose)), ORIGIN)
    assert same(compose(inverse(pose), pose), ORIGIN)


@given(poses, poses)
def test_relative_undoes_compose(first: Pose2, second: Pose2) -> None:
    assert same(relative(first, compose(first, second)), second)


@given(poses, metres, metres)
def test_points_move_like_poses(pose: Pose2, x: float, y: float) -> None:
    moved = transform_points(pose, np.array([[x, y]]))
    at = compose(pose, Pose2(x, y, 0.0))
    assert moved == pytest.approx(np.array([[at.x_m, at.y_m]]))


def test_poses_between_stamps_are_linear_and_turn_the_short_way() -> None:
    stamps = np.array([10**18, 10**18 + 100], dtype=np.int64)
    ends = np.array([[0.0, 0.0, 3.0], [10.0, -20.0, -3.0]])
    found = interpolate_poses(stamps, ends, stamps[0] + np.array([-1, 0, 25, 100, 101]))
    assert np.isnan(found[[0, 4]]).all()
    assert found[1:4, :2].tolist() == [[0.0, 0.0], [2.5, -5.0], [10.0, -20.0]]
    assert found[1:4, 2] == pytest.approx(wrap_array([3.0, 3.0 + (TAU - 6.0) / 4, -3.0]))


def test_poses_of_no_stamps_are_unknown() -> None:
    empty = np.zeros(0, dtype=np.int64)
    assert np.isnan(interpolate_poses(empty, np.zeros((0, 3)), np.array([1, 2]))).all()
    assert interpolate_poses(np.array([1]), np.zeros((1, 3)), empty).shape == (0, 3)


def test_path_length_sums_steps_and_skips_unknown_positions() -> None:
    track = np.array([[0.0, 0.0], [3.0, 4.0], [np.nan, 0.0], [3.0, 4.0], [3.0, 5.0]])
    assert path_length(track).tolist() == [0.0, 5.0, 5.0, 5.0, 6.0]
    assert path_length(np.zeros((1, 2))).tolist() == [0.0]
    assert path_length(np.zeros((0, 2))).tolist() == []


def test_panorama_columns_run_clockwise_from_the_rear_with_the_heading_in_the_middle() -> None:
    assert column_bearings(4) == pytest.approx(np.deg2rad([135.0, 45.0, -45.0, -135.0]))
    assert column_bearings(3)[1] == pytest.approx(0.0)
