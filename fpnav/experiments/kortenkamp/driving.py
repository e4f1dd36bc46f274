"""A robot that goes by itself: it follows walls, finds gateways and stops in the middle of each."""

from __future__ import annotations

from functools import partial

import numpy as np

from fpnav.errors import TruthError
from fpnav.evaluation.gateways import Gateways, Survey, gateways_met, surveyed
from fpnav.experiments.kortenkamp.detection import figures_of, renamed
from fpnav.experiments.kortenkamp.recognition import ROUTE
from fpnav.experiments.kortenkamp.tours import TEST, edged, world_of_job
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.navigation.walls import Stop, WallFollowing, WallParams
from fpnav.report.figures import gateways as drawing
from fpnav.report.study import Illustration
from fpnav.sensing.passages import Rule
from fpnav.sim.record import Job, stage_of
from fpnav.sim.robot import SimulatedRobot, steer
from fpnav.systems.gateway.types import NAMES, code_of
from fpnav.values import Metric, Pose2

PERIOD_S, DECISIONS = 0.15, 3000


def stops(shop: Workshop, seed: int) -> Outcome:
    """C11: closed loop by sonar alone, from the start of the first route to the last hall's end."""
    job = job_of("gateways", ROUTE, seed, TEST, sensors=["sonar"])
    made, bumped = _drive(job)
    world = world_of_job(job)
    survey = surveyed(_found(made), edged(gateways_met(world, ROUTE)))
    metrics = [
        *renamed(figures_of([survey]), "stopped"),
        Metric("bumped", float(bumped), bumped, DECISIONS),
    ]
    return Outcome(metrics, [_picture(world, survey)], {"policy": "wall-following"})


def _drive(job: Job) -> tuple[list[Stop], int]:
    """Stops the robot made in gateways, and how often it touched something."""
    stage = stage_of(job.setting)
    (x, y), (nx, ny) = stage.world.routes[ROUTE].points[:2]
    start = Pose2(x, y, float(np.arctan2(ny - y, nx - x)))
    robot = SimulatedRobot(stage, job.rig, start, period_s=PERIOD_S)
    policy, bumped = WallFollowing(WallParams(), Rule()), 0
    for _ in steer(robot, policy, DECISIONS):
        bumped += robot.bumped
        if policy.done:
            break
    return policy.stops, bumped


def _found(made: list[Stop]) -> Gateways:
    """Where the robot truly stood; the end of the last hall, where it stops for good, left out."""
    kept = [stop for stop in made if NAMES[code_of(stop.passage)] != "DEAD END"]
    poses = []
    for stop in kept:
        truth = stop.reference.truth
        if truth is None:
            raise TruthError("a simulated robot knows where it is; this one does not")
        poses.append((truth.x_m, truth.y_m, truth.heading_rad))
    types = tuple(NAMES[code_of(stop.passage)] for stop in kept)
    return Gateways(np.array(poses).reshape(-1, 3), types, ("",) * len(kept))


def _picture(world: dict[str, object], survey: Survey) -> Illustration:
    caption = "Arrows: where the robot stood still, by itself; the line is the way of the route."
    title = "Stops of the wall-following robot"
    return Illustration("stops", title, caption, partial(drawing.plan, world, [(ROUTE, survey)]))
