"""Legs of a drive."""

from __future__ import annotations

import math

import pytest

from fpnav.sensing.path import Path
from fpnav.values import Pose2


def drive(path: Path, poses: list[Pose2]) -> Path:
    for pose in poses:
        path.move(pose)
    return path


def line(start: Pose2, steps: int, step_m: float = 0.1) -> list[Pose2]:
    c, s = math.cos(start.heading_rad), math.sin(start.heading_rad)
    return [
        Pose2(start.x_m + c * step_m * i, start.y_m + s * step_m * i, start.heading_rad)
        for i in range(steps)
    ]


def test_a_leg_begins_after_straight_travel_and_counts_along_its_axis() -> None:
    path = drive(Path(math.radians(25), 0.3), line(Pose2(0, 0, 0.5), 4))
    assert path.straight
    assert path.leg == 1
    assert path.axis_rad == pytest.approx(0.5)
    drive(path, [Pose2(0.3 * math.cos(0.5) - 0.2 * math.sin(0.5),
                       0.3 * math.sin(0.5) + 0.2 * math.cos(0.5), 0.5)])  # fmt: skip
    assert path.at_m == pytest.approx(0.3)
    assert path.lateral_m == pytest.approx(0.2)


def test_turning_on_the_spot_ends_the_leg_and_says_which_way() -> None:
    path = drive(Path(math.radians(25), 0.3), line(Pose2(0, 0, 0), 6))
    drive(path, [Pose2(0.5, 0, 0.2), Pose2(0.5, 0, 0.5)])
    assert not path.straight
    assert path.turned_rad == pytest.approx(0.5)
    drive(path, [Pose2(0.5, 0, 1.0), *line(Pose2(0.5, 0, math.pi / 2), 4)])
    assert path.straight
    assert path.leg == 2
    assert path.axis_rad == pytest.approx(math.pi / 2)
    assert path.at_m == pytest.approx(0.8)


def test_no_leg_begins_while_the_heading_wanders() -> None:
    path = Path(math.radians(25), 0.3)
    for i in range(30):
        path.move(Pose2(0.02 * i, 0.0, 0.3 * i))
    assert not path.straight


def test_going_back_is_not_advancing() -> None:
    path = drive(Path(math.radians(25), 0.3), line(Pose2(0, 0, 0), 8))
    assert path.advancing
    drive(path, [Pose2(0.5, 0, 0)])
    assert not path.advancing
    drive(path, [Pose2(0.71, 0, 0)])
    assert path.advancing


def test_a_heading_that_jumps_over_the_half_turn_is_straight() -> None:
    path = Path(math.radians(25), 0.3)
    for i in range(6):
        path.move(Pose2(-0.1 * i, 0.0, math.pi - 0.01 if i % 2 else -math.pi + 0.01))
    assert path.straight
    assert abs(path.axis_rad) == pytest.approx(math.pi, abs=0.02)
    assert path.at_m == pytest.approx(0.5, abs=1e-3)


def test_a_leg_that_settles_to_another_heading_takes_it_for_its_axis() -> None:
    path = drive(Path(math.radians(25), 0.3), line(Pose2(0, 0, 0.0), 6))
    drive(path, line(Pose2(0.5, 0, 0.15), 14))
    assert path.leg == 1
    assert path.bends == 1
    assert path.axis_rad == pytest.approx(0.15, abs=0.02)
