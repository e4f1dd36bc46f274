"""Plans, walls built from them, furniture that leaves a lane, ways through rooms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.sim import rooms, tours
from fpnav.sim.building import Finish, wall_faces
from fpnav.sim.decor import ROOM_KINDS, house_style
from fpnav.sim.furniture import STANDING, hanging
from fpnav.sim.plan import THICKNESS_M, Opening, doors_of, segments, wall_runs
from fpnav.sim.raycast import Caster
from fpnav.sim.rooms import Furnished
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Material, box, placed, prism, sheet, turned
from fpnav.sim.tours import Backbone, Stop
from fpnav.sim.world import Blocks, Space

WEST = Space("west", "office", 0.0, 0.0, 4.0, 5.0)
EAST = Space("east", "office", 4.0, 0.0, 9.0, 5.0)
HALL = Space("hall", "corridor", 0.0, 5.0, 9.0, 7.0)
LOBBY = Space("lobby", "lobby", 4.0, 0.0, 9.0, 5.0)
STYLE = house_style(generator(1), 2.7)


def test_walls_stand_between_spaces_and_around_them() -> None:
    lines = set(segments(wall_runs([WEST, EAST, HALL])))
    assert (4.0, 0.0, 4.0, 5.0) in lines
    assert (0.0, 5.0, 4.0, 5.0) in lines
    assert (4.0, 5.0, 9.0, 5.0) in lines
    total = sum(math.hypot(x1 - x0, y1 - y0) for x0, y0, x1, y1 in lines)
    assert total == pytest.approx(2 * (9 + 7) + 9 + 5)


def test_corridor_and_lobby_have_no_wall_between_them() -> None:
    lines = set(segments(wall_runs([WEST, LOBBY, HALL])))
    assert (4.0, 5.0, 9.0, 5.0) not in lines
    assert (0.0, 5.0, 4.0, 5.0) in lines


@pytest.mark.parametrize(
    ("leaf", "is_open"), [(0.0, False), (math.radians(90), True), (math.nan, True)]
)
def test_a_door_is_open_by_its_leaf(leaf: float, is_open: bool) -> None:
    hole = Opening("west", "hall", 2.0, 0.9, leaf_rad=leaf)
    (door,) = doors_of(wall_runs([WEST, EAST, HALL]), [hole])
    assert (door.x_m, door.y_m, door.open) == (2.0, 5.0, is_open)
    assert door.axis_rad == pytest.approx(math.pi / 2)


def test_windows_are_no_doors() -> None:
    window = Opening("west", "", 2.0, 1.0, "window", sill_m=0.9)
    assert doors_of(wall_runs([WEST, HALL]), [window]) == []


def test_walls_are_closed_but_for_their_openings() -> None:
    runs = wall_runs([WEST, EAST, HALL])
    hole = Opening("west", "hall", 2.0, 0.9)
    plain = Material()
    finishes = {s.name: Finish(plain, plain, plain, 2.7) for s in (WEST, EAST, HALL)}
    faces = wall_faces(runs, [hole], finishes, plain)
    caster = Caster(np.concatenate([face.corners() for face in faces]))
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(720)]).astype(np.float32)
    origins = np.tile(np.array([[2.0, 2.5, 1.0]], np.float32), (720, 1))
    free = caster.cast(origins, rays).distance_m
    limit = np.minimum(
        np.abs(2.0 / np.where(rays[:, 0] == 0, 1e-9, rays[:, 0])),
        np.abs(2.5 / np.where(rays[:, 1] == 0, 1e-9, rays[:, 1])),
    )
    through = free > limit + 0.1
    opening = 2 * math.atan2(0.45, 2.5 + THICKNESS_M / 2)
    assert through.sum() * (2 * math.pi / 720) == pytest.approx(opening, abs=0.03)
    assert np.abs(angles[through] - math.pi / 2).max() < opening / 2 + 0.02


@pytest.mark.parametrize("kind", sorted(STANDING))
def test_furniture_stands_on_the_floor_within_its_footprint(kind: str) -> None:
    for seed in range(4):
        piece = STANDING[kind](generator(seed), STYLE.palette)
        points = np.concatenate([face.corners() for face in piece.faces]).reshape(-1, 3)
        assert points[:, 2].min() > -0.01
        assert points[:, 1].max() < 0.12
        assert -points[:, 1].min() <= piece.depth_m + 0.25


def test_what_hangs_takes_no_floor() -> None:
    assert hanging(generator(1), "poster", 5).depth_m == 0.0


@settings(max_examples=15)
@given(st.integers(0, 1000), st.sampled_from(sorted(ROOM_KINDS)))
def test_the_lane_of_a_furnished_room_is_free(seed: int, kind: str) -> None:
    space = Space("r", kind, 0.0, 0.0, 4.2, 5.0)
    room = Furnished(space)
    rooms.furnish(room, generator(seed), STYLE.palette, ROOM_KINDS[kind], clutter=1.0, posters=0.3)
    x0, y0, x1, y1 = room.lane()
    assert x1 - x0 >= 0.45
    assert y1 - y0 >= 0.45
    faces = room.faces()
    if faces:
        points = np.concatenate([face.corners() for face in faces]).reshape(-1, 3)
        low = points[points[:, 2] < 1.2]
        inside = (low[:, 0] > x0) & (low[:, 0] < x1) & (low[:, 1] > y0) & (low[:, 1] < y1)
        assert not inside.any()


@pytest.mark.parametrize("wall", [0, 1, 2, 3])
def test_pieces_lean_with_their_back_on_the_wall_and_their_front_to_the_room(wall: int) -> None:
    made = rooms.lean(box((-0.5, -0.4, 0), (0.5, 0, 1), Material()), WEST, wall, 1.0)
    points = np.concatenate([face.corners() for face in made]).reshape(-1, 3)
    half = THICKNESS_M / 2
    assert points[:, 0].min() >= half - 1e-9
    assert points[:, 0].max() <= 4.0 - half + 1e-9
    assert points[:, 1].min() >= half - 1e-9
    assert points[:, 1].max() <= 5.0 - half + 1e-9
    centre = points.mean(axis=0)[:2]
    np.testing.assert_allclose(rooms.standing_place(WEST, wall, 1.0, 0.2), centre, atol=1e-9)


BACKBONE = Backbone(((0.0, 0.0), (10.0, 0.0), (10.0, 6.0)))


def test_a_backbone_counts_along_itself() -> None:
    assert BACKBONE.length_m == 16.0
    assert BACKBONE.point(12.0) == (10.0, 2.0)
    assert BACKBONE.point(12.0, 0.5) == (9.5, 2.0)
    assert BACKBONE.foot(9.0, 4.0) == pytest.approx(14.0)


def test_a_way_between_two_places_goes_by_the_corners_on_its_own_side() -> None:
    assert BACKBONE.between(8.0, 12.0, 0.5) == [(8.0, 0.5), (9.5, 0.5), (9.5, 2.0)]
    assert BACKBONE.between(12.0, 8.0) == [(10.0, 2.0), (10.0, 0.0), (8.0, 0.0)]


def test_a_visit_goes_in_through_the_door_and_out_again() -> None:
    stop = Stop("room", 5.0, (5.0, 1.0), (0.0, 1.0), (4.0, 2.5, 7.0, 4.0))
    way = tours.visit(BACKBONE, stop, generator(1), points=3, offset_m=0.0)
    assert way[0] == way[-1] == (5.0, 0.0)
    assert way[1] == way[-2] == (5.0, pytest.approx(0.55))
    for x, y in way[4:-4]:
        assert 4.0 <= x <= 7.0
        assert 2.5 <= y <= 4.0


def test_a_solid_faces_outward() -> None:
    for faces in (box((0, 0, 0), (1, 1, 1), Material()), prism((0, 0), 1.0, 0, 1, Material())):
        points = np.concatenate([face.corners() for face in faces])
        middle = points.reshape(-1, 3).mean(axis=0)
        for face in faces:
            normal = np.cross(face.u, face.v)
            assert normal @ (face.corners().reshape(-1, 3).mean(axis=0) - middle) > 0.0


def test_turning_all_the_way_round_changes_nothing() -> None:
    face = sheet((1, 2, 0), (1, 0, 0), (0, 0, 1), Material())
    (same,) = turned([face], (3.0, 1.0), 2 * math.pi)
    np.testing.assert_allclose(same.corners(), face.corners(), atol=1e-12)
    (moved,) = placed([face], np.eye(3), np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(moved.corners()[..., 0], face.corners()[..., 0] + 1.0)


@given(st.integers(0, 200))
def test_the_corner_of_a_part_lies_in_that_part(part: int) -> None:
    blocks = Blocks(40.0, 22.0, 7)
    x, y = blocks.corner(part)
    assert blocks.part_at(x + 0.5, y + 0.5) == part


def test_where_no_room_is_known_the_way_goes_to_and_fro_along_the_backbone() -> None:
    hall = Backbone(((0.0, 0.0), (6.0, 0.0)))
    way = tours.wandering_way(hall, [], generator(1), 20.0, hall.length_m)
    assert tours.length(way) >= 20.0
    assert all(-0.01 <= x <= 6.01 and abs(y) <= 0.26 for x, y in way)
