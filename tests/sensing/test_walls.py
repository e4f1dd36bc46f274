"""Distance and direction of walls from readings along a path."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.sensing.walls import LEFT, RIGHT, Wall, wall_direction


def seen(wall: Wall, ranges: list[float], step_m: float = 0.1, start_m: float = 0.0) -> Wall:
    for number, range_m in enumerate(ranges):
        wall.see(start_m + step_m * number, 0.0, range_m)
    return wall


def test_the_distance_is_the_median_and_one_outlier_does_not_matter() -> None:
    wall = seen(Wall(LEFT, 1.5, 1.5, 2.5), [1.0, 1.02, 0.4, 0.98, 1.0])
    assert wall.distance_m == pytest.approx(1.0)
    assert wall.spread_m == pytest.approx(1.4826 * 0.02)


def test_two_readings_are_no_wall() -> None:
    assert math.isnan(seen(Wall(LEFT, 1.5, 1.5, 2.5), [1.0, 1.0]).distance_m)


def test_readings_all_over_are_no_wall() -> None:
    assert math.isnan(seen(Wall(LEFT, 1.5, 1.5, 2.5), [0.5, 1.0, 1.5, 2.0, 2.4]).distance_m)


def test_what_is_too_far_is_no_wall() -> None:
    wall = seen(Wall(LEFT, 1.5, 1.5, 2.5), [2.6, math.inf, math.nan] * 3)
    assert math.isnan(wall.distance_m)
    assert len(wall.points()) == 0


def test_only_the_last_stretch_counts() -> None:
    wall = seen(Wall(LEFT, 0.5, 0.5, 2.5), [1.0] * 10 + [2.0] * 10)
    assert wall.distance_m == pytest.approx(2.0)


def test_points_lie_on_the_walls_side() -> None:
    left, right = Wall(LEFT, 1.5, 1.5, 2.5), Wall(RIGHT, 1.5, 1.5, 2.5)
    left.see(0.3, 0.1, 1.0)
    right.see(0.3, 0.1, 1.0)
    assert left.points() == pytest.approx(np.array([[0.3, 1.1]]))
    assert right.points() == pytest.approx(np.array([[0.3, -0.9]]))


def test_points_outlive_the_wall_and_an_opening_in_it_but_not_the_leg() -> None:
    wall = seen(Wall(LEFT, 1.5, 1.5, 2.5), [1.0] * 11)
    wall.forget()
    assert math.isnan(wall.distance_m)
    seen(wall, [1.0] * 5, start_m=4.0)
    assert wall.points()[0, 0] == pytest.approx(0.0)
    wall.turn()
    assert len(wall.points()) == 0


def test_the_direction_of_one_wall_is_its_slope() -> None:
    along = np.linspace(0.0, 2.0, 21)
    points = np.column_stack([along, 1.0 + along * math.tan(0.1)])
    assert wall_direction([points], least_m=0.5, noise_m=0.05) == pytest.approx(0.1)


def test_two_walls_share_one_direction_and_keep_their_offsets() -> None:
    along = np.linspace(0.0, 2.0, 21)
    left = np.column_stack([along, 1.3 + 0.05 * along])
    right = np.column_stack([along[5:], -0.7 + 0.05 * along[5:]])
    found = wall_direction([left, right], least_m=0.5, noise_m=0.05)
    assert found == pytest.approx(math.atan(0.05))


def test_a_stray_echo_does_not_bend_the_wall() -> None:
    along = np.linspace(0.0, 1.5, 16)
    points = np.column_stack([along, np.ones(16)])
    points[-1, 1] = 2.4
    assert wall_direction([points], least_m=0.5, noise_m=0.02) == pytest.approx(0.0, abs=1e-9)


def test_walls_too_short_tell_no_direction() -> None:
    short = np.column_stack([np.linspace(0, 0.2, 5), np.ones(5)])
    assert math.isnan(wall_direction([short, short[:1]], least_m=0.5, noise_m=0.05))
    assert math.isnan(wall_direction([], least_m=0.5, noise_m=0.05))


def test_a_wall_across_the_path_tells_no_direction() -> None:
    along = np.linspace(0.0, 1.0, 11)
    steep = np.column_stack([along, 2.0 * along])
    assert math.isnan(wall_direction([steep], least_m=0.5, noise_m=0.05))


def test_noise_of_five_centimetres_leaves_a_few_degrees() -> None:
    rng = np.random.default_rng(1)
    along = np.arange(16) * 0.1
    errors = []
    for _ in range(200):
        walls = [np.column_stack([along, side + rng.normal(0, 0.05, 16)]) for side in (1, -1)]
        errors.append(math.degrees(wall_direction(walls, least_m=0.5, noise_m=0.05)))
    # sigma / sqrt(2 N) / (length / sqrt 12), length 1.5 m
    assert np.std(errors) == pytest.approx(math.degrees(0.05 / math.sqrt(32) / 0.461), rel=0.2)
