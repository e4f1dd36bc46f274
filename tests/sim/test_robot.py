"""The robot as a body: it moves, stops at walls, is carried off, and logs what it does."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
from helpers.sim_world import block, box_room, hall_world, stage_of, true_rig
from mcap.reader import make_reader

from fpnav.logs.writer import LogWriter
from fpnav.navigation.base import HALT, Command
from fpnav.sim.journal import Journal
from fpnav.sim.robot import RADIUS_M, SimulatedRobot, steer
from fpnav.sim.stage import Stage, set_stage
from fpnav.values import Frame, Pose2


class Cruise:
    """Straight on."""

    def act(self, frame: Frame) -> Command:
        return Command(0.4, 0.0)


class Shy:
    """Straight on, but away from what the scan says is near."""

    def act(self, frame: Frame) -> Command:
        assert frame.scan is not None
        ahead = np.abs(frame.scan.bearings_rad) < 0.6
        near = float(frame.scan.ranges_m[ahead].min())
        return Command(0.3, 0.0) if near > 0.8 else Command(0.0, 0.8)


@pytest.fixture(scope="module")
def room() -> Stage:
    return stage_of(box_room(8.0, 6.0))


def test_it_goes_as_far_as_told(room: Stage) -> None:
    robot = SimulatedRobot(room, true_rig("scan"), Pose2(1.0, 3.0, 0.0))
    for _ in range(20):
        frame = robot.step(Command(0.4, 0.0))
    assert robot.pose.x_m == pytest.approx(1.0 + 0.4 * 5.0 - 0.1, abs=0.02)
    assert frame.reference.odometry is not None
    assert frame.reference.odometry.x_m == pytest.approx(robot.pose.x_m - 1.0, abs=1e-6)
    assert frame.reference.travelled_m == pytest.approx(robot.pose.x_m - 1.0, abs=1e-6)


def test_it_stops_at_walls_and_can_turn_away(room: Stage) -> None:
    robot = SimulatedRobot(room, true_rig("scan"), Pose2(6.5, 3.0, 0.0))
    for _ in steer(robot, Cruise(), 40):
        pass
    assert robot.bumped
    assert 8.0 - robot.pose.x_m == pytest.approx(RADIUS_M, abs=0.03)
    for _ in range(20):
        robot.step(Command(0.0, 0.8))
    for _ in range(8):
        robot.step(Command(0.3, 0.0))
    assert not robot.bumped
    assert robot.pose.x_m < 7.5


def test_a_policy_that_looks_avoids_what_it_sees() -> None:
    stage = stage_of([*box_room(8.0, 6.0), *block(4.0, 2.0, 4.5, 4.0)])
    robot = SimulatedRobot(stage, true_rig("scan"), Pose2(1.0, 3.0, 0.0))
    bumps = 0
    for _ in steer(robot, Shy(), 120):
        bumps += robot.bumped
    assert bumps == 0
    assert robot.travelled_m > 3.0


def test_set_down_elsewhere_it_sees_elsewhere_and_reckons_on(room: Stage) -> None:
    robot = SimulatedRobot(room, true_rig("scan"), Pose2(1.0, 3.0, 0.0))
    before = robot.step(HALT)
    robot.set_down(Pose2(6.0, 2.0, math.pi / 2))
    after = robot.step(HALT)
    assert after.reference.odometry == before.reference.odometry
    assert after.scan is not None
    assert after.scan.ranges_m[360] == pytest.approx(4.0, abs=1e-3)
    assert after.reference.heading_rad == pytest.approx(math.pi / 2)


def test_frames_are_what_a_log_would_hold(room: Stage) -> None:
    rig = true_rig("panorama", "scan", "sonar")
    frame = SimulatedRobot(room, rig, Pose2(4.0, 3.0, 0.0)).step(HALT)
    assert frame.panorama is not None
    assert frame.panorama.pixels.shape == (120, 720, 3)
    assert frame.panorama.calibration is not None
    assert frame.sonar is not None
    assert len(frame.sonar.ranges_m) == 24


def test_a_panned_camera_gives_one_view_a_step(room: Stage) -> None:
    robot = SimulatedRobot(room, true_rig("pan"), Pose2(4.0, 3.0, 0.0))
    pans = [robot.step(HALT).pan_rad for _ in range(10)]
    assert pans[0] == pytest.approx(math.radians(120))
    assert pans[8] == pytest.approx(-math.radians(120))
    assert pans[9] == pans[0]


def test_the_same_commands_give_the_same_frames(room: Stage) -> None:
    def drive() -> list[Pose2 | None]:
        robot = SimulatedRobot(room, true_rig("scan", drift={"scale": 0.05}), Pose2(1, 3, 0))
        return [frame.reference.odometry for frame in steer(robot, Cruise(), 6)]

    assert drive() == drive()


def test_everything_is_logged() -> None:
    world = hall_world()
    stream = io.BytesIO()
    rig = true_rig("scan")
    with LogWriter(stream) as log:
        journal = Journal(log, world, world.routes["across"], rig)
        journal.begin()
        robot = SimulatedRobot(set_stage(world), rig, Pose2(1.0, 3.0, 0.0), journal=journal)
        for _ in steer(robot, Cruise(), 8):
            pass
        journal.finish()
    stream.seek(0)
    summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = summary.statistics.channel_message_counts
    found = {channel.topic: counts[number] for number, channel in summary.channels.items()}
    assert found["/scan"] == found["/cmd_vel"] == 8
    assert found["/truth"] == found["/odom"] == 20
    assert {"/label", "/compass", "/tf_static"} <= set(found)
