"""A robot steered by place-action pairs, with a system and a body small enough to see through."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fpnav.geometry import compose, distance
from fpnav.navigation.base import HALT, Command
from fpnav.navigation.obstacles import grazing, obstacles_of
from fpnav.navigation.policy import PlaceAction
from fpnav.navigation.steering import SteeringParams, steer_to
from fpnav.systems.base import Recall
from fpnav.values import Decoded, Frame, LaserScan, Pose2, Reference, Signature, SonarRing

NOTHING = np.zeros(1, [("n", "<i4")])[0]
PERIOD_S = 0.5


class Sees:
    """A system that sees its pose."""

    def describe(self, frame: Frame) -> dict[str, Any]:
        return {}

    def assemble(self, stream: Iterable[tuple[Reference, Any]]) -> Iterator[Signature]:
        for reference, _ in stream:
            yield Signature(reference, NOTHING, {})


class Places:
    """Places at known poses, active as far as three metres."""

    def __init__(self, poses: Sequence[Pose2], reach_m: float = 3.0) -> None:
        self.poses, self.reach_m = poses, reach_m
        self.places = np.arange(len(poses))

    def recall(self, signatures: Sequence[Signature], k: int, allowed: Any, trace: Any) -> Any:
        here = signatures[0].reference.truth
        assert here is not None
        score = np.array([max(0.0, 1 - distance(here, p) / self.reach_m) for p in self.poses])
        turn = np.array([here.heading_rad - pose.heading_rad for pose in self.poses])
        order = np.argsort(-score, kind="stable")
        return Recall(order[None], score[order][None], turn[order][None]), trace


def frame(pose: Pose2, **payloads: Any) -> Frame:
    reference = Reference(0, 0, odometry=pose, truth=pose)
    return Frame(reference, {role: Decoded(value) for role, value in payloads.items()})


def moved(pose: Pose2, command: Command) -> Pose2:
    turn = command.angular_radps * PERIOD_S
    step = command.linear_mps * PERIOD_S
    arc = Pose2(step * math.cos(turn / 2), step * math.sin(turn / 2), turn)
    return compose(pose, arc)


def ring(radius: float = 1.0) -> tuple[list[Pose2], dict[int, float]]:
    """Eight places about the origin, each facing anywhere, whose actions lead inwards."""
    poses, actions = [], {}
    for k in range(8):
        angle, facing = k * math.pi / 4, 0.7 * k
        poses.append(Pose2(radius * math.cos(angle), radius * math.sin(angle), facing))
        actions[k] = angle + math.pi - facing
    return poses, actions


@pytest.mark.parametrize("start", [Pose2(1.4, 0.3, 2.0), Pose2(-0.9, -1.0, 0.0)])
def test_a_ring_of_places_leads_home_from_any_side(start: Pose2) -> None:
    poses, actions = ring()
    policy = PlaceAction(Sees(), Places(poses), actions, SteeringParams())
    pose = start
    for _ in range(60):
        pose = moved(pose, policy.act(frame(pose)))
    assert distance(pose, Pose2(0, 0, 0)) < 0.3


def test_agreement_slows_the_robot_at_the_goal() -> None:
    poses, actions = ring()
    slow = PlaceAction(Sees(), Places(poses), actions, SteeringParams(blend=4.0))
    slow.act(frame(Pose2(0.0, 0.0, 0.0)))
    assert slow.decision.agreement < 0.05
    slow.act(frame(Pose2(1.5, 0.0, 0.0)))
    assert slow.decision.agreement > 0.3


def test_a_place_without_an_action_is_an_end() -> None:
    policy = PlaceAction(Sees(), Places([Pose2(0, 0, 0)]), {}, SteeringParams())
    assert policy.act(frame(Pose2(0.1, 0, 0))) == HALT
    assert policy.decision.place == 0


def test_the_course_is_kept_for_a_while_when_nothing_is_recognised() -> None:
    places = Places([Pose2(0, 0, 0)], reach_m=1.0)
    policy = PlaceAction(Sees(), places, {0: 0.0}, SteeringParams(hold=2))
    assert policy.act(frame(Pose2(0, 0, 0))).linear_mps > 0.0
    away = frame(Pose2(5, 0, 0.2))
    kept = [policy.act(away) for _ in range(3)]
    assert kept[0].linear_mps > 0.0
    assert kept[0].angular_radps < 0.0
    assert kept[2] == HALT


def scan(**ranges: float) -> LaserScan:
    """Eight beams, far but for the named directions."""
    names = ("back", "back_right", "right", "front_right", "front", "front_left", "left", "bl")
    values = np.array([ranges.get(name, 9.0) for name in names], np.float32)
    return LaserScan(values, -math.pi, math.pi / 4, 0.05, 30.0)


def test_obstacles_are_the_nearest_things_within_reach() -> None:
    found = obstacles_of(frame(Pose2(0, 0, 0), scan=scan(front=0.55, left=0.3)), 0.8, 0.3)
    assert [round(math.degrees(bearing)) for bearing, _ in found] == [90, 0]
    assert [close for _, close in found] == pytest.approx([1.0, 0.5], abs=1e-6)


def test_sonars_are_felt_where_there_is_no_scan() -> None:
    mounts = np.array([[0.2, 0.0, 0.0], [0.0, 0.2, math.pi / 2]])
    ring_of_two = SonarRing(np.array([0.35, np.inf], np.float32), mounts, 0.5, 0.02, 4.0)
    found = obstacles_of(frame(Pose2(0, 0, 0), sonar=ring_of_two), 0.8, 0.3)
    assert found == [(0.0, pytest.approx(0.5))]


def test_without_range_sensors_nothing_is_in_the_way() -> None:
    assert obstacles_of(frame(Pose2(0, 0, 0)), 0.8, 0.3) == []


def test_the_robot_goes_around_what_is_in_the_way() -> None:
    policy = PlaceAction(Sees(), Places([Pose2(0, 0, 0)]), {0: 0.0}, SteeringParams())
    free = policy.act(frame(Pose2(0, 0, 0), scan=scan()))
    around = policy.act(frame(Pose2(0, 0, 0), scan=scan(front=0.4, front_right=0.5)))
    assert free.angular_radps == pytest.approx(0.0)
    assert around.angular_radps > 0.1


def test_where_every_way_is_blocked_it_turns_on_the_spot() -> None:
    policy = PlaceAction(Sees(), Places([Pose2(0, 0, 0)]), {0: 0.0}, SteeringParams())
    shut = scan(front=0.3, front_left=0.3, front_right=0.3, left=0.3, right=0.3)
    command = policy.act(frame(Pose2(0, 0, 0), scan=shut))
    assert command.linear_mps == 0.0
    assert command.angular_radps != 0.0


@pytest.mark.parametrize(
    ("heading", "obstacles", "wanted"),
    [
        (0.0, [(-58, 0.9)], 0.0),
        (0.0, [(-58, 1.0)], 32.0),
        (-120.0, [(-58, 1.0)], -148.0),
        (0.0, [(120, 1.0)], 0.0),
        (10.0, [(0, 1.0), (-30, 1.0)], 90.0),
        (0.0, [(0, 1.0), (120, 1.0), (-120, 1.0)], None),
    ],
)
def test_what_is_touched_is_left_along_its_side(
    heading: float, obstacles: list[tuple[float, float]], wanted: float | None
) -> None:
    felt = [(math.radians(bearing), close) for bearing, close in obstacles]
    found = grazing(math.radians(heading), felt)
    if wanted is None:
        assert found is None
    else:
        assert found is not None
        assert math.degrees(found) == pytest.approx(wanted)


def test_the_robot_passes_a_wall_that_stands_across_its_way() -> None:
    policy = PlaceAction(Sees(), Places([Pose2(0, 0, 0)], 9.0), {0: 0.0}, SteeringParams())
    pose = Pose2(-1.0, 0.05, 0.0)
    for _ in range(80):
        pose = moved(pose, policy.act(frame(pose, scan=wall(pose))))
    assert pose.x_m > 1.0


def wall(robot: Pose2) -> LaserScan:
    """What a scan sees of a wall across x = 0 from y = -0.6 to 0.6."""
    bearings = -math.pi + np.arange(360) * math.pi / 180
    along = robot.heading_rad + bearings
    with np.errstate(divide="ignore", invalid="ignore"):
        away = -robot.x_m / np.cos(along)
        met = (away > 0) & (np.abs(robot.y_m + away * np.sin(along)) <= 0.6)
    ranges = np.where(met, away, 9.0).astype(np.float32)
    return LaserScan(ranges, -math.pi, math.pi / 180, 0.05, 30.0)


def test_a_sharp_turn_is_made_on_the_spot() -> None:
    params = SteeringParams()
    assert steer_to(2.0, params) == Command(0.0, params.turn_radps)
    assert steer_to(-0.1, params).angular_radps == pytest.approx(-0.2)
    assert steer_to(0.0, params, clear=0.5) == Command(params.speed_mps / 2, 0.0)


def test_a_signature_that_is_not_of_this_frame_decides_nothing() -> None:
    late = SimpleNamespace(describe=lambda frame: {}, assemble=lambda stream: iter(()))
    policy = PlaceAction(late, Places([Pose2(0, 0, 0)]), {0: 0.0}, SteeringParams())
    assert policy.act(frame(Pose2(0, 0, 0))) == HALT
    assert policy.decision.place == -1
