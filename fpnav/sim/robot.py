"""The simulated robot as a body: a policy steers it, what it sees comes back, all is logged."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fpnav.navigation.base import Body, Command, Policy
from fpnav.sim.journal import Journal
from fpnav.sim.motion import TICK_S, Base
from fpnav.sim.raycast import from_point
from fpnav.sim.record import Sealed, sealed
from fpnav.sim.rig import Rig, calibrations
from fpnav.sim.seeds import generator
from fpnav.sim.sense import Moment, sense
from fpnav.sim.sensors import state
from fpnav.sim.sensors.film import decode
from fpnav.sim.sensors.ranges import level_rays
from fpnav.sim.stage import Stage
from fpnav.values import Decoded, Frame, Image, Payload, Pose2, Reference

RADIUS_M = 0.22
FEELERS = 24
FEELER_HEIGHTS_M = (0.1, 0.38, 0.7, 1.0)


class SimulatedRobot(Body):
    """A robot in a world; ``step`` lasts one decision period.

    It stops where it would touch anything (``bumped`` says so) and goes on when told to move
    away. A panned camera takes one partial view a step, the next one each time. With a journal,
    state, commands and readings are logged as they happen.
    """

    def __init__(
        self,
        stage: Stage,
        rig: Rig,
        start: Pose2,
        *,
        period_s: float = 0.25,
        journal: Journal | None = None,
    ) -> None:
        world = stage.world
        self.stage, self.rig, self.journal = stage, rig, journal
        self.ticks = max(1, round(period_s / TICK_S))
        self.base = Base(start.x_m, start.y_m, start.heading_rad)
        self.encoders = state.Encoders(rig.drift, generator(world.seed, world.run, "drift"))
        self.compass = state.compass_of(rig.compass, world.seed, world.run)
        self.dead_reckoned = Pose2(0.0, 0.0, 0.0)
        self.cameras = dict(calibrations(rig))
        self.tick, self.frames, self.travelled_m = 0, 0, 0.0
        self.bumped = False

    @property
    def pose(self) -> Pose2:
        """Where it really is."""
        return self.base.pose

    def set_down(self, pose: Pose2) -> None:
        """Lift the robot and set it down elsewhere; its odometry does not notice."""
        self.base = Base(pose.x_m, pose.y_m, pose.heading_rad)

    def step(self, command: Command) -> Frame:
        """Carry out a command for one period; what is seen at its end."""
        if self.journal is not None:
            time_s = self.tick * TICK_S
            self.journal.command(time_s, command.linear_mps, command.angular_radps)
        self.bumped = False
        for _ in range(self.ticks):
            self._move(command)
            self._state()
        return self._frame()

    def _move(self, command: Command) -> None:
        before = (self.base.x_m, self.base.y_m)
        self.base.step(command.linear_mps, command.angular_radps)
        step = math.dist(before, (self.base.x_m, self.base.y_m))
        if step > 0.0 and touches(self.stage, self.base.x_m, self.base.y_m):
            self.base.x_m, self.base.y_m = before
            self.base.linear_mps, step, self.bumped = 0.0, 0.0, True
        self.tick += 1
        self.travelled_m += step
        self._dead_reckon(math.copysign(step, self.base.linear_mps))

    def _dead_reckon(self, step_m: float) -> None:
        turn = self.base.angular_radps * TICK_S
        along, turned = self.encoders.measure(np.array([step_m]), np.array([turn]))
        start = (self.dead_reckoned.x_m, self.dead_reckoned.y_m, self.dead_reckoned.heading_rad)
        self.dead_reckoned = Pose2(*state.dead_reckon(along, turned, start)[-1].tolist())

    def _state(self) -> None:
        if self.journal is None or self.tick % 2:
            return
        speeds = (self.base.linear_mps, self.base.angular_radps)
        self.journal.state(self.tick, self.pose, self.dead_reckoned, speeds, self._heading())

    def _heading(self) -> float:
        pose = np.array([[self.base.x_m, self.base.y_m, self.base.heading_rad]])
        return float(self.compass.read(pose)[0])

    def _frame(self) -> Frame:
        """Take a data set; log it; hand it on as its log would hold it."""
        time_s, turning = self.tick * TICK_S, self.base.angular_radps
        pose = self.pose
        moment = Moment(
            self.stage,
            self.rig,
            lambda _: (pose, turning),
            self.frames,
            time_s,
            view=self.frames,
        )
        taken = [sealed(reading, self.rig) for reading in sense(moment)]
        if self.journal is not None:
            self.journal.readings(taken)
        reference = Reference(
            index=self.frames,
            stamp_ns=self.journal.ns(time_s) if self.journal else round(time_s * 1e9),
            travelled_m=self.travelled_m,
            odometry=self.dead_reckoned,
            truth=pose,
            heading_rad=self._heading(),
        )
        self.frames += 1
        return Frame(reference, dict(self._payload(item) for item in taken))

    def _payload(self, item: Sealed) -> tuple[str, Payload]:
        reading, encoded = item
        if encoded is None:
            return reading.role, Decoded(reading.value)
        return reading.role, Decoded(Image(decode(encoded), self.cameras[reading.role]))


def touches(stage: Stage, x_m: float, y_m: float) -> bool:
    """Whether anything solid stands within the robot's radius of a point."""
    reach = np.full(FEELERS, RADIUS_M, dtype=np.float32)
    feelers = level_rays(np.arange(FEELERS) * 2 * math.pi / FEELERS)
    return any(
        stage.scene.solid.blocked(from_point((x_m, y_m, height), feelers), feelers, reach).any()
        for height in FEELER_HEIGHTS_M
    )


def steer(robot: SimulatedRobot, policy: Policy, decisions: int) -> Iterator[Frame]:
    """Let a policy steer; yields what was seen, the first frame standing still."""
    command = Command(0.0, 0.0)
    for _ in range(decisions):
        frame = robot.step(command)
        yield frame
        command = policy.act(frame)
