"""People: where they walk, that they give way, and that every sensor sees them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.sim_world import TRUE_LASER, block, box_room, stage_of

from fpnav.geometry import column_bearings
from fpnav.sim.light import Lamp
from fpnav.sim.people import KEEP_OFF_M
from fpnav.sim.seeds import generator
from fpnav.sim.sensors import eyes, ranges
from fpnav.sim.stage import Stage
from fpnav.sim.world import Walk
from fpnav.values import Pose2

WALK = Walk(((6.0, 1.0), (6.0, 5.0)), 1.0)


@pytest.fixture(scope="module")
def stage() -> Stage:
    lamp = Lamp(4.0, 3.0, 2.8, (30.0, 30.0, 30.0))
    return stage_of(box_room(8.0, 6.0), walks=(WALK,), lamps=(lamp,))


@pytest.mark.parametrize(
    ("time", "y"), [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0), (6.0, 3.0), (8.0, 1.0)]
)
def test_a_walk_goes_there_and_back_again(stage: Stage, time: float, y: float) -> None:
    assert stage.crowd.people[0].position(time) == (pytest.approx(6.0), pytest.approx(y))


def test_somebody_may_just_stand() -> None:
    standing = stage_of(box_room(8.0, 6.0), walks=(Walk(((2.0, 2.0),)),))
    assert standing.crowd.people[0].position(99.0) == (2.0, 2.0)


def test_people_give_way_to_the_robot(stage: Stage) -> None:
    robot = Pose2(6.0, 3.1, 0.0)
    bystanders = stage.bystanders(2.0, robot)
    assert bystanders is not None
    x, y = bystanders.places[0]
    assert math.hypot(x - robot.x_m, y - robot.y_m) == pytest.approx(KEEP_OFF_M)


def test_nobody_is_in_sight_far_away() -> None:
    far = stage_of(box_room(8.0, 6.0), walks=(Walk(((60.0, 3.0),)),))
    assert far.bystanders(0.0, Pose2(1.0, 3.0, 0.0)) is None


@pytest.mark.parametrize("time", [0.5, 1.7, 3.1])
def test_scan_and_panorama_see_a_person_at_one_bearing(stage: Stage, time: float) -> None:
    pose = Pose2(3.0, 3.0, 0.0)
    people = stage.bystanders(time, pose)
    assert people is not None
    x, y = people.places[0]
    expected = math.atan2(y - 3.0, x - 3.0)
    empty = ranges.scan(stage.scene, None, pose, TRUE_LASER, generator(1))
    scan = ranges.scan(stage.scene, people, pose, TRUE_LASER, generator(1))
    hit = scan.bearings_rad[scan.ranges_m < empty.ranges_m - 0.05]
    assert np.mean(hit) == pytest.approx(expected, abs=math.radians(2.0))
    rays = eyes.panorama_rays(eyes.PanoramaEye())
    differs = stage.look(rays, pose, 1.05, people) != stage.look(rays, pose, 1.05, None)
    columns = column_bearings(720)[differs.any(axis=(0, 2))]
    assert np.mean(columns) == pytest.approx(expected, abs=math.radians(2.0))


def test_sonar_hears_a_person_nearer_than_the_wall(stage: Stage) -> None:
    pose = Pose2(3.0, 3.0, 0.0)
    people = stage.bystanders(2.0, pose)
    plain = ranges.Sonar(noise_m=0.0, cross_talk=0.0, misses=0.0)
    alone = ranges.ring(stage.scene, None, pose, plain, generator(1)).ranges_m[0]
    crowded = ranges.ring(stage.scene, people, pose, plain, generator(1)).ranges_m[0]
    assert crowded < alone - 1.0


def test_a_person_behind_a_wall_is_hidden() -> None:
    hidden = stage_of([*box_room(8.0, 6.0), *block(4.0, 0.0, 4.2, 6.0)], walks=(WALK,))
    pose = Pose2(2.0, 3.0, 0.0)
    people = hidden.bystanders(2.0, pose)
    rays = eyes.panorama_rays(eyes.PanoramaEye())
    with_them = hidden.look(rays, pose, 1.05, people)
    np.testing.assert_array_equal(with_them, hidden.look(rays, pose, 1.05, None))
