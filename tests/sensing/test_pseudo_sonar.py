"""Virtual sonars from scans, and the ranges to the sides."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.sensing.pseudo_sonar import ring_from_scan, sides
from fpnav.values import ORIGIN, LaserScan, Pose2, SonarRing

FULL = 2.0 * math.pi


def scan_of(ranges: list[float], mount: Pose2 = ORIGIN) -> LaserScan:
    step = FULL / len(ranges)
    return LaserScan(np.array(ranges, np.float32), -math.pi, step, 0.1, 10.0, mount)


def ring(headings_deg: list[float], ranges: list[float], radius_m: float = 0.0) -> SonarRing:
    heading = np.radians(headings_deg)
    mounts = np.column_stack([radius_m * np.cos(heading), radius_m * np.sin(heading), heading])
    return SonarRing(np.array(ranges, np.float32), mounts, math.radians(30), 0.1, 5.0)


def test_a_virtual_sonar_answers_with_the_nearest_beam_of_its_cone() -> None:
    ranges = [4.0] * 360
    ranges[180 + 88] = 2.5
    made = ring_from_scan(scan_of(ranges), count=4, cone_rad=math.radians(30))
    assert made.ranges_m == pytest.approx([4.0, 2.5, 4.0, 4.0])
    assert made.mounts[:, 2] == pytest.approx([0.0, math.pi / 2, -math.pi, -math.pi / 2])
    assert made.field_of_view_rad == pytest.approx(math.radians(30))


def test_a_beam_outside_the_cone_is_not_heard() -> None:
    ranges = [4.0] * 360
    ranges[180 + 70] = 2.5
    made = ring_from_scan(scan_of(ranges), count=4, cone_rad=math.radians(30))
    assert made.ranges_m[1] == pytest.approx(4.0)


def test_a_cone_without_an_echo_is_infinite_and_one_not_covered_is_unknown() -> None:
    half = LaserScan(np.full(181, np.inf, np.float32), -math.pi / 2, math.radians(1), 0.1, 10.0)
    made = ring_from_scan(half, count=4, cone_rad=math.radians(30))
    assert np.isposinf(made.ranges_m[0])
    assert np.isposinf(made.ranges_m[1])
    assert np.isnan(made.ranges_m[2])


def test_unknown_and_too_near_beams_are_no_echoes() -> None:
    ranges = [4.0] * 360
    ranges[180] = math.nan
    ranges[181] = -math.inf
    ranges[182] = 0.01
    made = ring_from_scan(scan_of(ranges), count=4, cone_rad=math.radians(30))
    assert made.ranges_m[0] == pytest.approx(4.0)


def test_a_scanner_ahead_of_the_centre_is_allowed_for() -> None:
    made = ring_from_scan(
        scan_of([3.0] * 360, Pose2(0.5, 0.0, 0.0)), count=4, cone_rad=math.radians(2)
    )
    assert made.ranges_m[0] == pytest.approx(3.5, abs=1e-3)
    assert made.ranges_m[2] == pytest.approx(2.5, abs=1e-3)


def test_a_side_is_the_median_of_its_three_transducers() -> None:
    seen = sides(ring([0, 75, 90, 105, 180, -90], [3.0, 1.2, 1.0, 4.0, 2.0, 0.8]))
    assert seen.left_m == pytest.approx(1.2)
    assert seen.right_m == pytest.approx(0.8)
    assert seen.front_m == pytest.approx(3.0)
    assert seen.behind_m == pytest.approx(2.0)
    assert seen.beam_rad == pytest.approx(math.radians(30))


def test_a_narrower_side_is_the_transducer_straight_across() -> None:
    seen = sides(ring([75, 90, 105, -90], [1.2, 1.0, 4.0, 1.0]), math.radians(5))
    assert seen.left_m == pytest.approx(1.0)


def test_the_front_is_the_nearest_of_those_ahead() -> None:
    seen = sides(ring([-15, 0, 15, 30], [2.0, 3.0, 1.5, 0.2]))
    assert seen.front_m == pytest.approx(1.5)
    assert seen.ahead_m == pytest.approx(3.0)


def test_ranges_count_from_the_robots_centre() -> None:
    seen = sides(ring([0, 90, -90], [1.0, 1.0, 1.0], radius_m=0.2))
    assert (seen.front_m, seen.left_m, seen.right_m) == pytest.approx((1.2, 1.2, 1.2))


def test_saturated_readings_are_nothing_and_too_near_ones_the_least() -> None:
    seen = sides(ring([0, 90, -90], [5.0, math.inf, -math.inf]))
    assert math.isinf(seen.front_m)
    assert math.isinf(seen.left_m)
    assert seen.right_m == pytest.approx(0.1)


def test_of_a_wall_and_nothing_the_wall_counts() -> None:
    seen = sides(ring([80, 100, -90], [1.0, math.inf, 1.0]))
    assert seen.left_m == pytest.approx(1.0)


def test_a_transducer_that_looks_ahead_alone_stands_aside_for_the_one_across() -> None:
    seen = sides(ring([75, 90, -90], [4.0, 1.0, 1.0]))
    assert seen.left_m == pytest.approx(1.0)


def test_the_nearest_transducer_stands_for_a_side_that_has_none() -> None:
    seen = sides(ring([0, 68, -112], [3.0, 1.5, 1.7]))
    assert seen.left_m == pytest.approx(1.5)
    assert seen.right_m == pytest.approx(1.7)


def test_directions_without_a_transducer_are_unknown() -> None:
    seen = sides(ring([0], [3.0]))
    assert math.isnan(seen.left_m)
    assert math.isnan(seen.right_m)
    assert math.isnan(seen.behind_m)


@pytest.mark.parametrize("radius", [0.0, 0.21])
def test_cones_to_the_sides_begin_where_their_transducers_stand(radius: float) -> None:
    heading = np.deg2rad([0.0, 90.0, 180.0, -90.0])
    mounts = np.column_stack([radius * np.cos(heading), radius * np.sin(heading), heading])
    ring = SonarRing(np.ones(4, np.float32), mounts, math.radians(30.0), 0.02, 6.0)
    assert sides(ring).apex_m == pytest.approx(radius)
    assert sides(ring).left_m == pytest.approx(1.0 + radius)
