"""Trips of a simulated robot that a policy steers, and the log of them."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs.writer import LogWriter
from fpnav.navigation.base import HALT, Decision, Policy
from fpnav.publish import publish
from fpnav.sim.journal import Journal
from fpnav.sim.rig import Rig
from fpnav.sim.robot import SimulatedRobot
from fpnav.sim.seeds import generator
from fpnav.sim.stage import Stage
from fpnav.sim.world import Point, Route
from fpnav.store.tables import ACTION
from fpnav.values import Frame, Pose2

BESIDE_M = 5.0
"""A trip along a route is over where it passes the end of it, at most so far to the side."""

STILL = 8
"""Decisions for which a robot that has arrived stands still before its trip is over."""


@dataclass(frozen=True, slots=True)
class Expedition:
    """Trips to make: from each of ``starts``, at most ``decisions`` of ``period_s`` each.

    ``route`` : names and marks of the log; ``follow`` : whether its end is the end of a trip
    """

    rig: Rig
    route: Route
    starts: Sequence[Pose2]
    decisions: int
    period_s: float = 0.25
    follow: bool = False


def travel(
    stage: Stage,
    expedition: Expedition,
    make_policy: Callable[[], Policy],
    output: Path | None = None,
    *,
    clobber: bool = True,
    advance: Callable[[int], None] = lambda done: None,
) -> NDArray[Any]:
    """Make the trips, each with a fresh policy; log them where an output is given.

    Returns
    -------
    decisions : (A,) ACTION; between trips the robot is lifted and set down

    Raises
    ------
    FpnavError
        The log cannot be written.
    """
    with _journal(stage, expedition, output, clobber=clobber) as journal:
        robot = SimulatedRobot(
            stage,
            expedition.rig,
            expedition.starts[0],
            period_s=expedition.period_s,
            journal=journal,
        )
        rows = []
        for trip, start in enumerate(expedition.starts):
            robot.set_down(start)
            rows += [(trip, *step) for step in _trip(robot, make_policy(), expedition)]
            advance(1)
    return np.array(rows, ACTION)


def starts_around(
    goal: Point, within_m: float, count: int, seed: int, run: int, free: Callable[[Pose2], bool]
) -> list[Pose2]:
    """Free poses drawn uniformly over a disc about a goal, any way round."""
    rng = generator(seed, run, "starts")
    starts: list[Pose2] = []
    while len(starts) < count:
        away, angle, facing = within_m * math.sqrt(rng.random()), *rng.uniform(-math.pi, math.pi, 2)
        x, y = goal[0] + away * math.cos(angle), goal[1] + away * math.sin(angle)
        pose = Pose2(float(x), float(y), float(facing))
        if free(pose):
            starts.append(pose)
    return starts


@contextlib.contextmanager
def _journal(
    stage: Stage, expedition: Expedition, output: Path | None, *, clobber: bool
) -> Iterator[Journal | None]:
    if output is None:
        yield None
        return
    with publish(output, clobber=clobber) as stream, LogWriter(stream) as log:
        journal = Journal(log, stage.world, expedition.route, expedition.rig)
        journal.begin()
        yield journal
        journal.finish()


def _trip(
    robot: SimulatedRobot, policy: Policy, expedition: Expedition
) -> Iterator[tuple[Any, ...]]:
    """Rows of one trip, without its number."""
    command, still = HALT, 0
    begun_m = robot.travelled_m
    for _ in range(expedition.decisions):
        frame = robot.step(command)
        command = policy.act(frame)
        yield _row(frame, policy.decision, bumped=robot.bumped)
        still = still + 1 if policy.decision.arrived and command == HALT else 0
        if still >= STILL or _at_end(robot, expedition, robot.travelled_m - begun_m):
            return


def _row(frame: Frame, decision: Decision, *, bumped: bool) -> tuple[Any, ...]:
    pose = frame.reference.truth or Pose2(math.nan, math.nan, math.nan)
    return (
        frame.reference.stamp_ns,
        (pose.x_m, pose.y_m, pose.heading_rad),
        decision.place,
        decision.activity,
        decision.wanted_rad,
        bumped,
    )


def _at_end(robot: SimulatedRobot, expedition: Expedition, gone_m: float) -> bool:
    """Whether the robot has come past the end of the route, most of which lies behind it."""
    if not expedition.follow:
        return False
    points = expedition.route.points
    length = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
    (x0, y0), (x, y) = points[-2:]
    across, along = robot.pose.x_m - x, robot.pose.y_m - y
    past = across * (x - x0) + along * (y - y0) >= 0.0
    return past and math.hypot(across, along) <= BESIDE_M and gone_m >= 0.8 * length
