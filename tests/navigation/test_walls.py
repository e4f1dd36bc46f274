"""A robot in hallways of line segments that follows walls and stops in gateways by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.hallways import Box, outline, ring_at

from fpnav.geometry import wrap
from fpnav.navigation.base import Command
from fpnav.navigation.walls import WallFollowing, WallParams
from fpnav.sensing.passages import Rule
from fpnav.values import Decoded, Frame, Pose2, Reference

CORRIDOR: Box = (0, -1, 16, 1)
PERIOD_S = 0.2


def moved(pose: Pose2, command: Command) -> Pose2:
    heading = pose.heading_rad + command.angular_radps * PERIOD_S / 2
    step = command.linear_mps * PERIOD_S
    return Pose2(
        pose.x_m + step * math.cos(heading),
        pose.y_m + step * math.sin(heading),
        wrap(pose.heading_rad + command.angular_radps * PERIOD_S),
    )


def drive(boxes: Sequence[Box], start: Pose2, steps: int = 900) -> WallFollowing:
    walls, rng = outline(boxes), np.random.default_rng(3)
    policy, pose = WallFollowing(WallParams(), Rule()), start
    for index in range(steps):
        reference = Reference(index, index * 200_000_000, odometry=pose)
        frame = Frame(reference, {"sonar": Decoded(ring_at(walls, pose, rng, 0.01))})
        pose = moved(pose, policy.act(frame))
        if policy.done:
            break
    return policy


def test_it_stops_in_the_middle_of_an_opening_and_goes_on_to_the_end() -> None:
    policy = drive([CORRIDOR, (6, -6, 8, -1)], Pose2(1.0, 0.15, 0.05))
    assert [stop.passage.right for stop in policy.stops] == ["O", "W"]
    stood = policy.stops[0].reference.odometry
    assert stood is not None
    assert stood.x_m == pytest.approx(7.0, abs=0.07)
    assert stood.y_m == pytest.approx(0.0, abs=0.1)
    assert stood.heading_rad == pytest.approx(0.0, abs=math.radians(3.5))
    assert policy.done


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1)])
def test_it_turns_into_what_is_open_where_the_way_is_blocked(side: str, sign: int) -> None:
    low, high = sorted((sign * -1.0, sign * 9.0))
    policy = drive([(0, -1, 6, 1), (6, low, 8, high)], Pose2(1.0, 0.0, 0.0))
    first, last = policy.stops[0], policy.stops[-1]
    assert getattr(first.passage, side) == "B"
    assert last.reference.odometry is not None
    assert last.reference.odometry.heading_rad == pytest.approx(sign * math.pi / 2, abs=0.1)
    assert last.reference.odometry.y_m * sign > 5.0


def test_a_frame_without_ranges_halts_the_robot() -> None:
    policy = WallFollowing(WallParams(), Rule())
    command = policy.act(Frame(Reference(0, 0, odometry=Pose2(0, 0, 0)), {}))
    assert (command.linear_mps, command.angular_radps) == (0.0, 0.0)
