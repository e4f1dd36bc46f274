"""Passages found in hallways of line segments by a ring of sonars with 30 degree cones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.hallways import Box, drifted, outline, ring_at, straight

from fpnav.geometry import compose, relative
from fpnav.sensing.hallway import Hallway
from fpnav.sensing.openings import Evidence, Threshold
from fpnav.sensing.passages import Opening, Passage, Rule, exit_beside, grouped
from fpnav.sensing.pseudo_sonar import sides
from fpnav.sensing.rooms import Exit
from fpnav.values import Pose2

CORRIDOR: Box = (0, -1, 20, 1)
SIDE_RAD = math.radians(5.0)


@dataclass
class Found:
    """Passages of a drive, and their centres in the world by the robot's true poses."""

    passages: list[Passage]
    centres: list[Pose2]

    @property
    def names(self) -> list[str]:
        return [
            p.left + p.right + ("!" if p.blocked else "")
            if p.exit is None
            else f"{p.exit.where} {p.exit.shape}"
            for p in self.passages
        ]


def drive(
    boxes: Sequence[Box],
    poses: Sequence[Pose2],
    seed: int | None = None,
    noise_m: float = 0.05,
    detector: str = "threshold",
    in_room: bool = False,
) -> Found:
    rng = None if seed is None else np.random.default_rng(seed)
    walls = outline(boxes)
    change = (
        (lambda: Threshold(0.5, 0.25, 2))
        if detector == "threshold"
        else (lambda: Evidence(0.25, 0.05, 5.0))
    )
    hallway = Hallway(Rule(), change)
    if in_room:
        hallway.room.enter()
    reckoned = poses if rng is None else drifted(poses, rng)
    found: list[Passage] = []
    for row, (true, pose) in enumerate(zip(poses, reckoned, strict=True)):
        found += hallway.step(row, pose, sides(ring_at(walls, true, rng, noise_m), SIDE_RAD))
    found += hallway.finish()
    return Found(found, [compose(poses[p.row], relative(reckoned[p.row], p.centre)) for p in found])


def way(*points: tuple[float, float], step_m: float = 0.1) -> list[Pose2]:
    """Straight legs with turns on the spot of ten degrees a step."""
    poses: list[Pose2] = []
    heading = 0.0
    for (ax, ay), (bx, by) in pairwise(points):
        towards = math.atan2(by - ay, bx - ax)
        turn = (towards - heading + math.pi) % (2 * math.pi) - math.pi
        count = math.ceil(abs(turn) / math.radians(10)) if poses else 0
        poses += [Pose2(ax, ay, heading + turn * i / count) for i in range(1, count)]
        heading = towards
        poses += straight(Pose2(ax, ay, towards), math.hypot(bx - ax, by - ay), step_m)
    return poses


OPEN_RIGHT: list[Box] = [CORRIDOR, (8, -6, 10, -1)]
STRAIGHT = straight(Pose2(1.0, 0.0, 0.0), 14.0)


@pytest.mark.parametrize(
    ("boxes", "name", "centre_m", "length_m"),
    [
        (OPEN_RIGHT, "WO", 9.0, 14.0),
        ([CORRIDOR, (8, 1, 10, 6)], "OW", 9.0, 14.0),
        ([CORRIDOR, (8, -6, 10, 6)], "OO", 9.0, 14.0),
        ([CORRIDOR, (8, -6, 15, -1)], "WN", 8.5, 12.0),
        ([CORRIDOR, (8, 1, 15, 6)], "NW", 8.5, 12.0),
        ([CORRIDOR, (8, -6, 15, 6)], "NN", 8.5, 12.0),
        ([(0, -1, 8, 1), (8, -6, 10, 6)], "BB!", 9.0, 8.4),
        ([(0, -1, 8, 1), (8, -1, 10, 6)], "BW!", 9.0, 8.4),
        ([(0, -1, 8, 1), (8, -6, 10, 1)], "WB!", 9.0, 8.4),
        ([(0, -1, 9, 1)], "WW!", 8.2, 7.6),
    ],
)
@pytest.mark.parametrize("detector", ["threshold", "evidence"])
def test_without_noise_every_shape_is_found_where_it_is(
    boxes: list[Box], name: str, centre_m: float, length_m: float, detector: str
) -> None:
    found = drive(boxes, straight(Pose2(1.0, 0.0, 0.0), length_m), detector=detector)
    assert found.names == [name]
    assert found.centres[0].x_m == pytest.approx(centre_m, abs=0.06)
    assert found.centres[0].heading_rad == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("detector", ["threshold", "evidence"])
@pytest.mark.parametrize("boxes", [OPEN_RIGHT, [CORRIDOR, (8, -1.15, 9, -1), (6, -5, 11, -1.15)]])
def test_centres_are_within_7_cm_and_axes_within_3_5_degrees_at_5_cm_noise(
    detector: str, boxes: list[Box]
) -> None:
    true = 9.0 if boxes is OPEN_RIGHT else 8.5
    good = 0
    for seed in range(12):
        phase = float(np.random.default_rng(seed).uniform(0.0, 0.1))
        poses = straight(Pose2(1.0, 0.05, 0.0), 12.0, phase_m=phase)
        found = drive(boxes, poses, seed, detector=detector)
        assert found.names == ["WO"]
        away = abs(found.centres[0].x_m - true)
        good += away <= 0.07 and abs(math.degrees(found.centres[0].heading_rad)) <= 3.5
    assert good >= 11


def test_an_opening_too_narrow_to_pass_is_none() -> None:
    assert drive([CORRIDOR, (8, -6, 8.8, -1)], STRAIGHT).names == []


def test_a_plain_corridor_has_no_gateways() -> None:
    for seed in range(5):
        assert drive([CORRIDOR], STRAIGHT, seed).names == []


def test_openings_one_after_the_other_are_two_in_travel_order() -> None:
    found = drive([CORRIDOR, (5, -6, 7, -1), (10, 1, 12, 6)], STRAIGHT)
    assert found.names == ["WO", "OW"]
    assert found.passages[0].row < found.passages[1].row


def test_openings_that_overlap_are_one() -> None:
    found = drive([CORRIDOR, (8, -6, 10, -1), (8.6, 1, 10.6, 6)], STRAIGHT)
    assert found.names == ["OO"]


def test_the_width_allows_for_the_beam() -> None:
    found = drive(OPEN_RIGHT, STRAIGHT)
    assert found.passages[0].width_m == pytest.approx(2.0, abs=0.11)
    assert found.passages[0].wall_right_m == pytest.approx(1.0, abs=0.01)
    assert found.passages[0].wall_left_m == pytest.approx(1.0, abs=0.01)


def test_turning_in_the_middle_of_an_opening_finds_it() -> None:
    found = drive(OPEN_RIGHT, way((1, 0), (9, 0), (9, -5)))
    assert found.names[0] == "WO"
    assert found.centres[0].x_m == pytest.approx(9.0, abs=0.11)


def test_turning_before_a_wall_is_a_turn() -> None:
    found = drive([(0, -1, 8, 1), (8, -6, 10, 1)], way((1, 0), (9, 0), (9, -5)))
    assert found.names == ["WB!"]
    assert found.centres[0].x_m == pytest.approx(9.0, abs=0.06)


def test_a_robot_that_goes_back_finds_nothing_twice() -> None:
    out = straight(Pose2(1.0, 0.0, 0.0), 10.0)
    back = [Pose2(11.0 - 0.1 * i, 0.0, 0.0) for i in range(1, 25)]
    again = [Pose2(8.6 + 0.1 * i, 0.0, 0.0) for i in range(1, 50)]
    assert drive(OPEN_RIGHT, [*out, *back, *again]).names == ["WO"]


def test_the_frame_of_a_passage_is_headed_along_the_walls() -> None:
    poses = [
        Pose2(p.x_m, p.y_m, 0.2 if 8.8 < p.x_m < 9.3 else 0.0)
        for p in straight(Pose2(1.0, 0.0, 0.0), 14.0)
    ]
    found = drive(OPEN_RIGHT, poses)
    assert poses[found.passages[0].row].heading_rad == 0.0


def test_somebody_passing_ahead_is_no_dead_end() -> None:
    hallway = Hallway(Rule(), lambda: Threshold(0.5, 0.25, 2))
    walls = outline([CORRIDOR])
    found: list[Passage] = []
    for row, pose in enumerate(STRAIGHT):
        seen = sides(ring_at(walls, pose))
        if row == 60:
            seen = replace(seen, front_m=0.5)
        found += hallway.step(row, pose, seen)
    assert found == []


ROOM: Box = (0, -3, 8, 3)


@pytest.mark.parametrize(
    ("boxes", "start", "length_m", "name", "centre_m"),
    [
        ([(4, -3.15, 5, -3), (3, -6, 6, -3.15)], (0.6, -2.2), 6.8, "RIGHT MID", 4.5),
        ([(3, -3.15, 5.5, -3), (2, -6, 7, -3.15)], (0.6, -2.2), 6.8, "RIGHT WIDE", 4.25),
        ([(6.4, -3.15, 7.4, -3), (5, -6, 9, -3.15)], (0.6, -2.2), 6.8, "RIGHT CORNER", 6.9),
        ([(4, 3, 5, 3.15), (3, 3.15, 6, 6)], (0.6, 2.2), 6.8, "LEFT MID", 4.5),
        ([(3, 3, 5.5, 3.15), (2, 3.15, 7, 6)], (0.6, 2.2), 6.8, "LEFT WIDE", 4.25),
        ([(6.4, 3, 7.4, 3.15), (5, 3.15, 9, 6)], (0.6, 2.2), 6.8, "LEFT CORNER", 6.9),
        ([(8, -0.5, 8.15, 0.5), (8.15, -5, 10.15, 5)], (2, 0), 7.0, "FRONT MID", 8.075),
        ([(8, -1.2, 8.15, 1.2), (8.15, -5, 10.15, 5)], (2, 0), 7.0, "FRONT WIDE", 8.075),
        ([(8, -2.6, 8.15, -1.6), (8.15, -5, 10.15, 5)], (2, -2.1), 7.0, "FRONT CORNER", 8.075),
    ],
)
def test_exits_of_a_room_are_told_by_where_they_are(
    boxes: list[Box], start: tuple[float, float], length_m: float, name: str, centre_m: float
) -> None:
    poses = straight(Pose2(*start, 0.0), length_m)
    found = drive([ROOM, *boxes], poses, in_room=True)
    assert found.names == [name]
    assert found.centres[0].x_m == pytest.approx(centre_m, abs=0.1)


def test_turning_into_an_opening_without_an_end_enters_a_room() -> None:
    boxes = [(0, -1, 20, 1), (8, -9, 16, -1), (7.85, -5.5, 8, -4.5), (5, -8, 7.85, -3)]
    poses = way((1, 0), (12.5, 0), (12.5, -7.0))
    assert drive(boxes, poses).names == ["WN"]
    inside = way((1, 0), (12.5, 0), (12.5, -2), (8.8, -2), (8.8, -8.2))
    found = drive(boxes, inside)
    assert found.names[0] == "WN"
    assert found.names[-1].startswith("RIGHT")


def test_far_walls_on_both_sides_are_a_room() -> None:
    hallway = Hallway(Rule(), lambda: Threshold(0.5, 0.25, 2))
    walls = outline([(0, -4, 10, 4)])
    for row, pose in enumerate(straight(Pose2(1.0, 0.0, 0.0), 3.0)):
        hallway.step(row, pose, sides(ring_at(walls, pose)))
    assert hallway.room.on


def test_a_corridor_is_no_room_any_more() -> None:
    hallway = Hallway(Rule(), lambda: Threshold(0.5, 0.25, 2))
    hallway.room.enter()
    walls = outline([CORRIDOR])
    for row, pose in enumerate(straight(Pose2(1.0, 0.0, 0.0), 3.0)):
        hallway.step(row, pose, sides(ring_at(walls, pose)))
    assert not hallway.room.on


def opening(side: int, start: float, end: float, cause: str = "E") -> Opening:
    return Opening(side, start, end, cause)


def test_openings_are_one_where_they_start_together_or_share_half_of_the_shorter() -> None:
    rule = Rule()
    near = [opening(1, 0.0, 1.0), opening(-1, 0.5, 3.0)]
    half = [opening(1, 0.0, 2.0), opening(-1, 1.0, 3.0)]
    less = [opening(1, 0.0, 2.0), opening(-1, 1.1, 3.1)]
    assert [len(group) for group in grouped(near, rule)] == [2]
    assert [len(group) for group in grouped(half, rule)] == [2]
    assert [len(group) for group in grouped(less, rule)] == [1, 1]


def test_openings_of_one_side_are_never_one() -> None:
    assert len(grouped([opening(1, 0.0, 1.0), opening(1, 0.2, 1.2)], Rule())) == 2


def test_an_exit_that_runs_into_the_corner_is_a_corner_exit() -> None:
    assert exit_beside(opening(-1, 0.0, 1.0, "B"), Rule()) == Exit("RIGHT", "CORNER")
    assert exit_beside(opening(1, 0.0, 1.0), Rule()) == Exit("LEFT", "MID")
    behind = Opening(1, 0.5, 1.5, "E", corners_m=(0.0, math.inf))
    assert exit_beside(behind, Rule()) == Exit("LEFT", "CORNER")
    assert exit_beside(opening(1, 0.0, 2.5), Rule()) == Exit("LEFT", "WIDE")
