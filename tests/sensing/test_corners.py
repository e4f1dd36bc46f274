"""Corners of laser scans."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.sensing.corners import EPSILON_M, corners, sensed_arc, simplify
from fpnav.values import LaserScan, Pose2

FULL = 2.0 * math.pi
BOX = ((3.0, 2.0), (-3.0, 2.0), (-3.0, -2.0), (3.0, -2.0))


def box_range(bearing: float, x: float, y: float) -> float:
    """Distance from (x, y) to the walls of BOX."""
    c, s = math.cos(bearing), math.sin(bearing)
    limits = ((3.0 - x, c), (-3.0 - x, c), (2.0 - y, s), (-2.0 - y, s))
    return min(gap / rate for gap, rate in limits if abs(rate) > 1e-12 and gap / rate > 0.0)


def box_scan(
    x: float = 0.5, y: float = 0.3, beams: int = 720, fov: float = FULL, mount: Pose2 | None = None
) -> LaserScan:
    step = fov / beams
    first = -fov / 2.0 + step / 2.0
    mount = mount or Pose2(0.0, 0.0, 0.0)
    ranges = [
        box_range(first + step * i + mount.heading_rad, x + mount.x_m, y + mount.y_m)
        for i in range(beams)
    ]
    return LaserScan(np.array(ranges, np.float32), first, step, 0.05, 30.0, mount)


def expected(x: float, y: float) -> list[float]:
    return sorted(math.atan2(cy - y, cx - x) for cx, cy in BOX)


@settings(max_examples=25)
@given(st.floats(-2.0, 2.0), st.floats(-1.2, 1.2))
def test_a_box_has_its_four_corners_from_anywhere(x: float, y: float) -> None:
    found = corners(box_scan(x, y))
    assert np.sort(found.bearings_rad) == pytest.approx(expected(x, y), abs=math.radians(2.0))
    assert (found.certainty == 1.0).all()
    order = np.argsort(found.bearings_rad)
    ranges = [math.hypot(cx - x, cy - y) for cx, cy in BOX]
    bearings = [math.atan2(cy - y, cx - x) for cx, cy in BOX]
    assert found.ranges_m[order] == pytest.approx(np.array(ranges)[np.argsort(bearings)], abs=0.15)


def test_half_a_view_sees_the_corners_ahead_and_ends_that_move_with_the_robot() -> None:
    found = corners(box_scan(beams=360, fov=math.pi))
    ahead = [bearing for bearing in expected(0.5, 0.3) if abs(bearing) < math.pi / 2.0]
    sure = found.certainty == 1.0
    assert found.bearings_rad[sure] == pytest.approx(ahead, abs=math.radians(1.0))
    assert np.abs(found.bearings_rad[~sure]) == pytest.approx(math.pi / 2.0, abs=0.02)
    assert found.certainty[~sure] == pytest.approx(0.4)


def test_the_mount_is_undone() -> None:
    turned = corners(box_scan(mount=Pose2(0.2, -0.1, 0.7)))
    assert np.sort(turned.bearings_rad) == pytest.approx(expected(0.5, 0.3), abs=0.03)


def test_laser_fov_keeps_what_lies_around_the_heading() -> None:
    found = corners(box_scan(), field_of_view_rad=math.pi)
    assert (np.abs(found.bearings_rad) <= math.pi / 2.0).all()
    assert sensed_arc(box_scan(), math.pi) == (0.0, math.pi)


def post_scan() -> LaserScan:
    """A wall 4 m ahead, a panel 0.8 m wide 2 m ahead of the robot."""
    bearings = np.radians(np.arange(-60.0, 60.0, 0.25))
    ranges = 4.0 / np.cos(bearings)
    panel = np.abs(2.0 * np.tan(bearings)) <= 0.4
    ranges[panel] = 2.0 / np.cos(bearings[panel])
    return LaserScan(ranges.astype(np.float32), float(bearings[0]), math.radians(0.25), 0.05, 30.0)


def test_near_sides_of_a_jump_are_surer_than_their_shadows() -> None:
    found = corners(post_scan())
    at = np.argsort(found.bearings_rad)
    quality = found.certainty[at]
    near = np.abs(found.ranges_m[at] - math.hypot(2.0, 0.4)) < 0.05
    assert near.sum() == 2
    assert quality[near] == pytest.approx(0.7 * 0.8, abs=0.03)
    assert quality[~near] == pytest.approx(0.4)


def test_a_robot_between_two_bare_walls_sees_no_corner_but_far_ends() -> None:
    bearings = np.radians(np.arange(-180.0, 180.0, 0.5))
    ranges = 1.0 / np.maximum(np.abs(np.sin(bearings)), 1e-3)
    found = corners(LaserScan(ranges.astype(np.float32), -math.pi, math.radians(0.5), 0.05, 8.0))
    ahead = np.minimum(np.abs(found.bearings_rad), math.pi - np.abs(found.bearings_rad))
    assert (ahead < math.radians(30.0)).all()


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan, 0.0, 99.0])
def test_a_scan_without_a_return_has_no_corners(value: float) -> None:
    scan = LaserScan(np.full(180, value, np.float32), 0.0, FULL / 180, 0.05, 30.0)
    found = corners(scan)
    assert len(found.bearings_rad) == len(found.ranges_m) == len(found.certainty) == 0


def test_single_returns_among_nothing_have_no_corners() -> None:
    ranges = np.full(360, np.inf, np.float32)
    ranges[::40] = 3.0
    assert len(corners(LaserScan(ranges, 0.0, FULL / 360, 0.05, 30.0)).bearings_rad) == 0


def test_clutter_shorter_than_a_segment_is_left_out() -> None:
    bearings = np.radians(np.arange(-20.0, 20.0, 0.5))
    ranges = np.full(len(bearings), 9.0)
    ranges[30:40] = 2.0  # ten points over 0.17 m
    found = corners(
        LaserScan(ranges.astype(np.float32), float(bearings[0]), math.radians(0.5), 0.05, 30.0)
    )
    assert not (found.ranges_m < 3.0).any()


@pytest.mark.parametrize(
    ("fov_deg", "heading", "centre", "width_deg"),
    [(180.0, 0.0, 0.0, 180.0), (90.0, 0.3, 0.3, 90.0), (360.0, 0.3, 0.0, 360.0)],
)
def test_the_sensed_arc_is_that_of_the_beams(
    fov_deg: float, heading: float, centre: float, width_deg: float
) -> None:
    scan = box_scan(beams=60, fov=math.radians(fov_deg), mount=Pose2(0.0, 0.0, heading))
    found = sensed_arc(scan)
    assert found[0] == pytest.approx(centre, abs=1e-9)
    assert math.degrees(found[1]) == pytest.approx(width_deg)


def off_segment(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points to a line segment."""
    chord = end - start
    along = np.clip((points - start) @ chord / max(chord @ chord, 1e-12), 0.0, 1.0)
    return np.hypot(*(points - start - along[:, None] * chord).T)


@settings(max_examples=60)
@given(st.integers(3, 80), st.integers(0, 10_000))
def test_what_simplify_drops_lies_near_what_it_keeps(count: int, seed: int) -> None:
    walk = np.random.default_rng(seed).normal(0.0, 0.05, (count, 2)).cumsum(axis=0)
    walk[:, 0] += 0.1 * np.arange(count)
    kept = simplify(walk)
    assert kept[0] == 0
    assert kept[-1] == count - 1
    assert (np.diff(kept) > 0).all()
    for a, b in itertools.pairwise(kept):
        # OpenCV goes on to drop vertices that lie near the simplified line: hence the factor
        assert (off_segment(walk[a : b + 1], walk[a], walk[b]) <= 2.0 * EPSILON_M).all()


def test_simplify_leaves_two_points_alone() -> None:
    assert list(simplify(np.array([[0.0, 0.0], [1.0, 1.0]]))) == [0, 1]
    assert list(simplify(np.zeros((1, 2)))) == [0]
