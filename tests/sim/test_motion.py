"""Driving: bounded, on the way, data sets where they are due; lifting and carrying."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.sim import motion
from fpnav.sim.motion import CARRY_S, TICK_S, Base, Track, capture_times, carry, drive, kidnapped
from fpnav.sim.seeds import generator
from fpnav.sim.sensors.state import Drift, odometry
from fpnav.sim.world import Route
from fpnav.values import FloatArray

ELL = Route("ell", ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0)))
FAULTLESS = Drift(
    along_m_per_sqrt_m=0.0,
    scale=0.0,
    heading_deg_per_sqrt_m=0.0,
    heading_share=0.0,
    slips_per_m=0.0,
)


@pytest.fixture(scope="module")
def track() -> Track:
    return drive(ELL, 0.5)


def away_from(route: Route, points: FloatArray) -> FloatArray:
    """Distance of each point (N, 2) from the route."""
    best = np.full(len(points), np.inf)
    for a, b in zip(route.points, route.points[1:], strict=False):
        start, leg = np.array(a), np.array(b) - np.array(a)
        share = np.clip((points - start) @ leg / (leg @ leg), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - start - share[:, None] * leg, axis=1))
    return best


def test_speeds_and_accelerations_are_bounded(track: Track) -> None:
    assert np.abs(track.speeds[:, 0]).max() <= 0.5 + 1e-9
    assert np.abs(track.speeds[:, 1]).max() <= motion.TURN_RADPS + 1e-9
    change = np.abs(np.diff(track.speeds, axis=0)) / TICK_S
    assert change[:, 0].max() <= motion.ACCELERATION_MPS2 + 1e-6
    assert change[:, 1].max() <= motion.ANGULAR_RADPS2 + 1e-6


def test_it_stays_on_the_way_but_for_cut_corners(track: Track) -> None:
    assert away_from(ELL, track.poses[:, :2]).max() < ELL.lookahead_m
    assert math.dist(track.poses[-1, :2], ELL.points[-1]) < ELL.lookahead_m + 0.05


def test_a_shorter_lookahead_cuts_corners_less() -> None:
    close = Route("ell", ELL.points, lookahead_m=0.08)
    assert away_from(ELL, drive(close, 0.2).poses[:, :2]).max() < 0.06


def test_a_square_way_reaches_its_corners() -> None:
    base, way = Base(0.0, 0.0, 0.0), motion.WayFollower(ELL.points, 0.4, 0.25, square=True)
    nearest = math.inf
    while not way.done:
        base.step(*way.command(base.pose))
        nearest = min(nearest, math.dist((base.x_m, base.y_m), (4.0, 0.0)))
    assert nearest < 0.06


def test_the_length_cuts_the_way() -> None:
    cut = Route("cut", ELL.points, length_m=2.0)
    assert drive(cut, 0.5).travelled_m[-1] == pytest.approx(2.0, abs=0.03)


def test_an_arc_is_driven_exactly() -> None:
    base = Base(0.0, 0.0, 0.0, linear_mps=0.5, angular_radps=0.5)
    for _ in range(round(math.pi / 0.5 / TICK_S)):
        base.step(0.5, 0.5)
    assert (base.x_m, base.y_m) == (pytest.approx(0.0, abs=0.02), pytest.approx(2.0, abs=0.02))


@settings(max_examples=20)
@given(st.floats(0.05, 0.7))
def test_data_sets_are_taken_every_step_of_travel(step: float) -> None:
    driven = drive(ELL, 0.5)
    times = capture_times(driven, step)
    at = np.interp(times, np.arange(len(driven.poses)) * TICK_S, driven.travelled_m)
    np.testing.assert_allclose(at, np.arange(len(times)) * step, atol=1e-9)
    assert driven.travelled_m[-1] - at[-1] <= step + 1e-9


def test_the_pose_between_ticks_is_between(track: Track) -> None:
    low, high = track.poses[20], track.poses[21]
    pose = track.pose_at(20.5 * TICK_S)
    assert pose.x_m == pytest.approx((low[0] + high[0]) / 2)
    assert track.pose_at(1e9).x_m == pytest.approx(track.poses[-1, 0])


def test_a_kidnapped_robot_jumps_and_its_odometry_does_not_notice(track: Track) -> None:
    times = capture_times(track, 0.25)
    moved, when = kidnapped(track, times, 2, generator(5))
    steps = np.linalg.norm(np.diff(moved.poses[:, :2], axis=0), axis=1)
    assert (steps > 0.2).sum() == 2
    reckoned = odometry(moved, FAULTLESS, generator(1))
    assert np.linalg.norm(np.diff(reckoned[:, :2], axis=0), axis=1).max() < 0.03
    assert len(when) == len(times) - 1
    assert (np.diff(when) > 0).all()


def test_every_data_set_of_a_kidnapped_run_is_still_taken_where_it_was(track: Track) -> None:
    times = capture_times(track, 0.25)
    moved, when = kidnapped(track, times, 3, generator(6))
    before = sorted((track.pose_at(t).x_m, track.pose_at(t).y_m) for t in times[1:])
    after = sorted((moved.pose_at(t).x_m, moved.pose_at(t).y_m) for t in when)
    np.testing.assert_allclose(before, after, atol=1e-6)


def test_the_robot_is_set_down_well_before_the_next_data_set(track: Track) -> None:
    times = capture_times(track, 0.25)
    moved, when = kidnapped(track, times, 3, generator(6))
    jumps = np.flatnonzero(np.linalg.norm(np.diff(moved.poses[:, :2], axis=0), axis=1) > 0.1)
    apart = np.abs(when[:, None] - (jumps + 0.5) * TICK_S).min()
    assert apart > 2 * TICK_S


def test_without_kidnaps_the_track_is_untouched(track: Track) -> None:
    times = capture_times(track, 0.25)
    assert kidnapped(track, times, 0, generator(1))[0] is track


def test_a_carried_robot_is_at_every_point_in_turn() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-3.0, 2.0)]
    track = carry(points)
    for k, (x, y) in enumerate(points):
        pose = track.pose_at(k * CARRY_S)
        assert (pose.x_m, pose.y_m) == (pytest.approx(x), pytest.approx(y))
    assert track.pose_at(CARRY_S).heading_rad == pytest.approx(0.0)
    assert track.pose_at(2 * CARRY_S).heading_rad == pytest.approx(math.pi / 2)


def test_the_odometry_of_a_carried_robot_closes() -> None:
    track = carry([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-3.0, 2.0)])
    reckoned = odometry(track, FAULTLESS, generator(1))
    np.testing.assert_allclose(reckoned[:, :2], track.poses[:, :2], atol=1e-9)
