"""Walls ahead, and people who are none."""

from __future__ import annotations

import math

import pytest

from fpnav.sensing.front import Front


def seen(rows: list[tuple[float, float]]) -> Front:
    front = Front()
    for at_m, range_m in rows:
        front.see(at_m, range_m)
    return front


def test_a_wall_stays_where_it_is() -> None:
    front = seen([(0.1 * i, 2.0 - 0.1 * i + 0.01 * (-1) ** i) for i in range(10)])
    assert front.wall_m == pytest.approx(2.0, abs=0.02)


def test_somebody_coming_towards_the_robot_is_no_wall() -> None:
    assert math.isinf(seen([(0.1 * i, 2.0 - 0.3 * i) for i in range(5)]).wall_m)


def test_nothing_ahead_or_a_single_reading_is_no_wall() -> None:
    assert math.isinf(seen([(0.1 * i, math.inf) for i in range(5)]).wall_m)
    assert math.isinf(seen([(0.0, 1.0)]).wall_m)
    assert math.isinf(seen([]).wall_m)


def test_unknown_readings_say_nothing_and_old_ones_are_forgotten() -> None:
    front = seen(
        [(0.0, 5.0), *((1.0 + 0.1 * i, 1.0 - 0.1 * i) for i in range(4)), (1.35, math.nan)]
    )
    assert front.wall_m == pytest.approx(2.0)
    front.forget()
    assert math.isinf(front.wall_m)
