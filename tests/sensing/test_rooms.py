"""In and out of rooms, by the distances to either side."""

from __future__ import annotations

import math

import pytest

from fpnav.sensing.rooms import Pinch, Room

Rows = list[tuple[float, float]]


def room() -> Room:
    made = Room(2.5, 2.6)
    made.enter()
    return made


def through(one: Room, rows: Rows, start_m: float = 0.0) -> list[Pinch]:
    found = (one.through(start_m + 0.1 * i, *row) for i, row in enumerate(rows))
    return [pinch for pinch in found if pinch is not None]


BEFORE: Rows = [(3.0, 3.0)] * 12


def test_an_exit_ahead_is_where_the_sides_are_near() -> None:
    one = room()
    (found,) = through(one, BEFORE + [(0.5, 0.5)] * 4 + [(5.0, 5.0)] * 3)
    assert found.open_m == pytest.approx(1.15)
    assert found.close_m == pytest.approx(1.55)
    assert found.width_m == pytest.approx(1.0)
    assert found.corner_m == pytest.approx(2.5)
    assert not one.on


def test_an_exit_into_a_narrow_corridor_stays_narrow() -> None:
    (found,) = through(room(), BEFORE + [(0.5, 0.5)] * 14)
    assert math.isnan(found.close_m)


def test_a_cupboard_on_one_side_is_no_exit() -> None:
    one = room()
    assert through(one, [(0.7, 3.5)] * 12 + [(0.7, 1.5)] * 14 + [(0.7, 3.5)] * 5) == []
    assert one.on


def test_a_single_near_reading_is_no_exit() -> None:
    assert through(room(), [*BEFORE, (0.5, 0.5), *BEFORE]) == []


def test_the_corner_is_where_the_nearer_side_wall_stands() -> None:
    (found,) = through(room(), [(0.9, 4.0)] * 12 + [(0.5, 0.5)] * 4 + [(5.0, 5.0)] * 3)
    assert found.corner_m == pytest.approx(0.4)


def test_outside_a_room_there_are_no_exits() -> None:
    assert through(Room(2.5, 2.6), BEFORE + [(0.5, 0.5)] * 4 + [(5.0, 5.0)] * 3) == []


def test_unknown_sides_say_nothing() -> None:
    rows = BEFORE + [(math.nan, 0.5)] * 4 + [(5.0, 5.0)] * 3
    assert through(room(), rows) == []


def test_far_sides_without_walls_are_a_room_after_three_readings() -> None:
    one = Room(2.5, 2.6)
    for i in range(3):
        assert not one.on
        one.look(0.1 * i, 3.0, 4.0, walls=False)
    assert one.on


def test_far_sides_of_an_opening_are_no_room() -> None:
    one = Room(2.5, 2.6)
    for i in range(9):
        one.look(0.1 * i, 3.0, 4.0, walls=True)
    assert not one.on


def test_having_left_far_sides_mean_nothing_until_the_next_leg() -> None:
    one = room()
    one.leave()
    for i in range(9):
        one.look(0.1 * i, 3.0, 4.0, walls=False)
    assert not one.on
    one.leg()
    for i in range(9):
        one.look(0.1 * i, 3.0, 4.0, walls=False)
    assert one.on


def test_a_metre_of_corridor_ends_the_room() -> None:
    one = room()
    for i in range(10):
        one.look(0.1 * i, 1.0, 1.2, walls=True)
    assert one.on
    one.look(1.0, 1.0, 1.2, walls=True)
    assert not one.on
