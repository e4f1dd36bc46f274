"""Every world: its plan, doors, gateways and routes agree with what sensors meet there."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from helpers.sim_world import TRUE_LASER

from fpnav.errors import UsageError
from fpnav.geometry import wrap
from fpnav.sim.catalogue import WORLDS, Setting, default_rig, overrides_in, route_of
from fpnav.sim.record import Job, driven, sense_chunk, stage_at, stage_of, world_of
from fpnav.sim.rig import make_rig
from fpnav.sim.seeds import generator
from fpnav.sim.sense import Moment, sense
from fpnav.sim.sensors import ranges
from fpnav.sim.stage import Stage, set_stage
from fpnav.sim.world import Gateway, World
from fpnav.values import Pose2

INDOORS = [("office", 1), ("office", 2), ("room", 1), ("gateways", 1)]


def world(name: str, seed: int, run: int = 1) -> World:
    return world_of(Setting(name, seed, run))


def stage(name: str, seed: int) -> Stage:
    return stage_of(Setting(name, seed, 1))


def distance(scene_of: Stage, x: float, y: float, angle: float, height: float = 0.35) -> float:
    """Free way of one beam."""
    laser = ranges.Laser(
        beams=2, height_m=height, noise_m=0.0, noise_share=0.0, dropouts=0.0, mixed=0.0, step_m=0.0
    )
    scan = ranges.scan(scene_of.scene, None, Pose2(x, y, angle), laser, generator(1))
    return float(scan.ranges_m[1])


@pytest.mark.parametrize("name", ["office", "room", "gateways", "gateway_types"])
def test_every_route_of_the_catalogue_can_be_had(name: str) -> None:
    assert set(world(name, 1).routes) == set(WORLDS[name])


@pytest.mark.parametrize(("name", "seed"), INDOORS[:3])
def test_open_doors_can_be_looked_through_and_closed_ones_not(name: str, seed: int) -> None:
    made, ready = world(name, seed), stage(name, seed)
    assert made.doors
    for door in made.doors:
        spaces = {space.name: space for space in made.spaces}
        corridor = spaces[door.spaces[1]]
        side = math.copysign(1.0, door.y_m - corridor.centre[1])
        x, y = door.x_m, door.y_m - side * 0.5
        free = distance(ready, x, y, side * math.pi / 2)
        if door.open:
            assert free > 0.9
        else:
            assert free == pytest.approx(0.5 - 0.02, abs=0.03)


@pytest.mark.parametrize(("name", "seed"), INDOORS)
def test_walls_of_the_plan_stand_where_the_laser_finds_them(name: str, seed: int) -> None:
    # Looked at from just beside its middle, a wall is half its thickness nearer than its line.
    made, ready = world(name, seed), stage(name, seed)
    found = 0
    for x0, y0, x1, y1 in made.walls:
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        across = math.pi / 2 if y0 == y1 else 0.0
        for side in (1.0, -1.0):
            px, py = x + side * 0.3 * math.cos(across), y + side * 0.3 * math.sin(across)
            seen = distance(ready, px, py, across if side < 0 else across + math.pi, 2.3)
            found += abs(seen - (0.3 - 0.06)) < 0.01
    # Boards and shelves that stand higher than the beam hide a few.
    assert found > 0.75 * 2 * len(made.walls)


def beside(ready: Stage, gateway: Gateway, along: float, side: float) -> float:
    """Free way to one side of the axis, ``along`` it from the gateway's centre."""
    c, s = math.cos(gateway.axis_rad), math.sin(gateway.axis_rad)
    angle = gateway.axis_rad + side * math.pi / 2
    return distance(ready, gateway.x_m + along * c, gateway.y_m + along * s, angle, 2.3)


@pytest.mark.parametrize(
    "setting",
    [
        Setting("gateways", 1),
        Setting("gateways", 2),
        Setting("gateways", 3, 1, (("alike", 6), ("gateways", 20))),
    ],
    ids=["seven-1", "seven-2", "twenty"],
)
def test_gateways_open_and_close_where_the_truth_says(setting: Setting) -> None:
    made, ready = world_of(setting), stage_of(setting)
    half = made.routes["route-1"].half_width_m
    for gateway in made.gateways:
        if "TURN" in gateway.type or "T-SHAPE" in gateway.type:
            continue
        sides = {"L": (1.0,), "R": (-1.0,)}.get(gateway.type[0], (1.0, -1.0))
        opens, closes = gateway.opens_m, gateway.closes_m
        for side in sides:
            places = (opens - 0.12, opens + 0.12, 0.0, closes + 0.12)
            before, first, middle, after = (beside(ready, gateway, at, side) for at in places)
            assert max(before, after) < half + 0.05
            assert first > half + 0.5
            assert middle > half + 0.6


@pytest.mark.parametrize("seed", [1, 2])
def test_b_c_and_d_look_alike_to_sonar(seed: int) -> None:
    widths = [g.closes_m - g.opens_m for g in world("gateways", seed).gateways if g.name in "BCD"]
    assert max(widths) - min(widths) < 0.05


def test_there_are_sixteen_scenes_at_seven_gateways() -> None:
    met = world("gateways", 1).gateways
    assert len(met) == 16
    assert {gateway.name for gateway in met} == set("ABCDEFG")
    assert len({(g.name, round(g.axis_rad, 3)) for g in met}) == 16


def test_any_number_of_gateways_can_be_had_some_of_them_alike() -> None:
    made = world_of(Setting("gateways", 2, 1, (("alike", 10), ("gateways", 50))))
    assert [gateway.name for gateway in made.gateways] == [f"{k:02d}" for k in range(1, 51)]
    widths = [g.closes_m - g.opens_m for g in made.gateways if g.type == "RIGHT OPENING"]
    assert len(widths) == 10
    assert max(widths) - min(widths) < 0.05


def test_a_gateway_that_is_closed_is_walled_up() -> None:
    closed = Setting("gateways", 1, 1, overrides_in({"world": {"closed": ["C"]}})).make()
    ready = set_stage(closed)
    before = world("gateways", 1).gateways
    gateway = next(g for g in before if g.name == "C" and g.route == "route-1")
    assert {g.name for g in closed.gateways} == set("ABDEFG")
    half = closed.routes["route-1"].half_width_m
    assert distance(ready, gateway.x_m, gateway.y_m, -math.pi / 2, 2.3) < half + 0.05


def job(name: str, seed: int, route: str, run: int = 1, **capture: float) -> Job:
    roles, defaults = default_rig(name)
    return Job(Setting(name, seed, run), route, make_rig(roles, defaults, {"capture": capture}))


@pytest.mark.parametrize("route", ["route-1", "route-2", "route-3"])
def test_the_wall_follower_meets_every_gateway_straight_and_in_the_middle(route: str) -> None:
    _, track, _ = driven(job("gateways", 2, route))
    for gateway in world("gateways", 2).gateways:
        if gateway.route != route:
            continue
        away = np.hypot(track.poses[:, 0] - gateway.x_m, track.poses[:, 1] - gateway.y_m)
        turned = [abs(wrap(float(h) - gateway.axis_rad)) for h in track.poses[away < 0.2, 2]]
        assert away.min() < 0.07
        assert min(turned) < math.radians(3.5)


@pytest.mark.parametrize(
    "seed", [1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (3, 4, 5))]
)
def test_the_office_routes_have_the_length_and_the_data_sets_of_the_paper(seed: int) -> None:
    _, mapped, sets = driven(job("office", seed, "map"))
    assert len(sets) == 500
    assert mapped.travelled_m[-1] == pytest.approx(75.0, abs=0.3)
    assert len(world("office", seed).routes["map"].stops) >= 3


def test_the_test_route_is_another_path_through_the_mapped_part() -> None:
    _, mapped, _ = driven(job("office", 1, "map"))
    _, tested, sets = driven(job("office", 1, "test", run=2))
    assert len(sets) > 1000
    assert tested.travelled_m[-1] == pytest.approx(250.0, abs=0.3)
    gaps = np.linalg.norm(tested.poses[::20, None, :2] - mapped.poses[None, ::5, :2], axis=2)
    assert np.median(gaps.min(axis=1)) > 0.1
    assert gaps.min(axis=1).max() < 3.0


@pytest.mark.parametrize(("name", "seed", "route"), [
    ("office", 1, "map"), ("office", 2, "test"), ("office", 2, "loop-2"),
    ("room", 1, "line"), ("room", 1, "homing"), ("gateways", 1, "route-1"),
])  # fmt: skip
def test_the_robot_touches_nothing_on_its_way(name: str, seed: int, route: str) -> None:
    _, track, _ = driven(job(name, seed, route))
    ready = stage(name, seed)
    for height in (0.1, 0.35, 0.75):
        laser = ranges.Laser(
            beams=72, height_m=height, noise_m=0.0, noise_share=0.0, dropouts=0.0, mixed=0.0
        )
        for x, y, heading in track.poses[::16]:
            scan = ranges.scan(ready.scene, None, Pose2(x, y, heading), laser, generator(1))
            assert scan.ranges_m.min() > 0.2


def test_every_loop_comes_back_to_where_it_was() -> None:
    for k in range(1, 6):
        _, track, _ = driven(job("office", 1, f"loop-{k}"))
        early = track.poses[track.travelled_m < 16.0, :2]
        late = track.poses[track.travelled_m > track.travelled_m[-1] - 4.0, :2]
        gaps = np.linalg.norm(early[:, None] - late[None], axis=2)
        assert gaps.min() < 0.3


def test_seeds_give_different_buildings_and_runs_the_same_one() -> None:
    walls = [world("office", seed).walls for seed in (1, 2, 3)]
    assert len({len(wall) for wall in walls} | {wall[0] for wall in walls}) > 2
    again = world("office", 1, 2)
    assert again.walls == world("office", 1).walls
    assert again.routes == world("office", 1).routes
    assert [door.open for door in again.doors] == [door.open for door in world("office", 1).doors]
    assert again.daylight != world("office", 1).daylight


def test_things_come_and_go_between_runs_and_are_listed() -> None:
    kinds = {change.kind for run in (1, 2) for change in world("office", 1, run).changes}
    assert {"corner", "colour", "removed", "added"} <= kinds


def test_there_are_closed_doors_and_no_route_goes_through_them() -> None:
    made = world("office", 1)
    closed = {door.spaces[0] for door in made.doors if not door.open}
    assert closed
    for route in made.routes.values():
        assert not closed & set(route.stops)


def test_the_line_of_the_room_has_its_places_and_its_steps() -> None:
    route, track, times = driven(job("room", 1, "line"))
    assert len(times) == 241
    assert [mark.name for mark in route.marks] == [f"place-{k}" for k in range(1, 6)]
    gaps = np.diff([mark.y_m for mark in route.marks])
    np.testing.assert_allclose(gaps, 0.6)
    poses = np.array([(track.pose_at(t).x_m, track.pose_at(t).y_m) for t in times])
    for mark in route.marks:
        assert np.hypot(poses[:, 0] - mark.x_m, poses[:, 1] - mark.y_m).min() < 0.015


def test_homing_passes_the_goal_and_the_ring_around_it() -> None:
    route, track, _ = driven(job("room", 2, "homing"))
    goal = route.marks[0]
    for mark in route.marks:
        away = np.hypot(track.poses[:, 0] - mark.x_m, track.poses[:, 1] - mark.y_m)
        assert away.min() < mark.radius_m
    ring = [math.hypot(m.x_m - goal.x_m, m.y_m - goal.y_m) for m in route.marks[1:]]
    np.testing.assert_allclose(ring, 1.0)


def test_outdoor_landmarks_stand_at_a_distance_and_scale_with_the_world() -> None:
    small = set_stage(Setting("outdoor", 1, 1, (("people", 0), ("scale", 0.2))).make())
    large = set_stage(Setting("outdoor", 1, 1, (("people", 0),)).make())
    near, far = (
        ranges.scan(
            ready.scene,
            None,
            Pose2(0, 0, 0),
            ranges.Laser(
                height_m=2.0 * scale,
                range_max_m=200.0,
                noise_m=0.0,
                noise_share=0.0,
                dropouts=0.0,
                mixed=0.0,
                step_m=0.0,
            ),
            generator(1),
        ).ranges_m
        for ready, scale in ((small, 0.2), (large, 1.0))
    )
    hit = np.isfinite(near) & np.isfinite(far)
    assert hit.mean() > 0.3
    np.testing.assert_allclose(near[hit] * 5.0, far[hit], rtol=1e-3)
    assert far.min() > 5.0


def test_the_sun_moves_between_afternoon_and_morning() -> None:
    afternoon, morning = (Setting("suburb", 1, run).make().daylight for run in (1, 2))
    assert abs(wrap(afternoon.sun_azimuth_rad - morning.sun_azimuth_rad)) > 1.0


def test_the_suburban_loop_is_a_hundred_metres_and_closes() -> None:
    route, track, _ = driven(job("suburb", 1, "loop"))
    assert track.travelled_m[-1] == pytest.approx(106.0, abs=2.0)
    start = np.array(route.points[0])
    closing = track.poses[track.travelled_m > 90.0, :2]
    assert np.linalg.norm(closing - start, axis=1).min() < 0.3


def test_the_street_bends_one_way_and_then_the_other() -> None:
    _, track, _ = driven(job("suburb", 1, "street"))
    heading = track.poses[:, 2]
    assert np.ptp(heading) > math.radians(60)
    assert abs(heading[-1] - heading[0]) < math.radians(10)


def test_a_campus_has_as_many_places_as_asked_one_data_set_each() -> None:
    setting = Setting("campus", 1, 1, (("places", 37),))
    roles, defaults = default_rig("campus")
    _, _, times = driven(Job(setting, "tour", make_rig(roles, defaults)))
    assert len(times) == 37
    made = setting.make()
    inside = [
        next(s for s in made.spaces if s.contains(*p)).name for p in made.routes["tour"].points
    ]
    assert len(set(inside)) == 37


def test_each_part_of_a_campus_is_built_where_its_plan_says() -> None:
    whole = Setting("campus", 1, 1, (("places", 40),)).make()
    part = Setting("campus", 1, 1, (("places", 40), ("part", 1))).make()
    assert set(part.spaces) < set(whole.spaces)
    assert whole.blocks is not None
    assert {whole.blocks.part_at(*space.centre) for space in part.spaces} == {1}
    ready = set_stage(part)
    room = part.spaces[0]
    scan = ranges.scan(ready.scene, None, Pose2(*room.centre, 0.0), TRUE_LASER, generator(1))
    assert np.isfinite(scan.ranges_m).mean() > 0.99


@pytest.mark.parametrize(("name", "route"), [("campus", "tour"), ("room", "line")])
def test_scans_lie_on_the_truth_of_their_stamps(name: str, route: str) -> None:
    # Seen from where the truth says the robot stood, every beam ends where it really would.
    _, defaults = default_rig(name)
    faultless = {"noise_m": 0.0, "noise_share": 0.0, "dropouts": 0.0, "mixed": 0.0, "step_m": 0.0}
    rig = make_rig(("scan",), defaults, {"laser": faultless})
    _, track, times = driven(Job(Setting(name, 1, 1), route, rig))
    for i in (3, 10, 20):
        time_s = float(times[i])
        ready = stage_at(Setting(name, 1, 1), track.pose_at(time_s))
        (reading,) = sense(Moment(ready, rig, track.state_at, i, time_s))
        stood = track.pose_at(reading.time_s)
        people = ready.bystanders(time_s, track.pose_at(time_s))
        again = ranges.scan(ready.scene, people, stood, rig.laser, generator(1))
        np.testing.assert_allclose(reading.value.ranges_m, again.ranges_m, atol=1e-4)
        turned = wrap(stood.heading_rad - track.pose_at(time_s).heading_rad)
        assert abs(turned) < math.radians(1.0)


def test_an_unknown_world_or_route_is_refused_with_what_there_is() -> None:
    with pytest.raises(UsageError, match="no world 'moon'; known: office, room"):
        Setting("moon").make()
    with pytest.raises(UsageError, match="room has no route 'map'; it has line, homing"):
        route_of(world("room", 1), "map")


def test_every_type_of_gateway_has_a_building_with_free_way() -> None:
    made, ready = world("gateway_types", 1), stage("gateway_types", 1)
    assert len({gateway.type for gateway in made.gateways}) == 25
    for gateway in made.gateways:
        route = made.routes[gateway.route]
        for (x0, y0), (x1, y1) in itertools.pairwise(route.points):
            angle = math.atan2(y1 - y0, x1 - x0)
            assert distance(ready, x0, y0, angle) > math.dist((x0, y0), (x1, y1)) + 0.2


def test_images_may_be_rarer_than_other_readings() -> None:
    roles, defaults = default_rig("gateways")
    rig = make_rig(roles, defaults, {"capture": {"images_every": 3, "images_near_m": 0.0}})
    job = Job(Setting("gateways", 1, 1), "route-1", rig)
    taken = [{reading.role for reading, _ in readings} for readings in sense_chunk((job, 0, 7))]
    assert [("camera" in roles) for roles in taken] == [True, False, False] * 2 + [True]
    assert all("sonar" in roles for roles in taken)
