"""The dynamic neural field: the cases of systems.md 2.7."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.geometry import angular_distance
from fpnav.navigation.field import heading_of, input_to, settled


def heading(wanted: float, *blocked: float) -> float | None:
    found = heading_of(math.radians(wanted), [(math.radians(at), 1.0) for at in blocked])
    return None if found is None else math.degrees(found)


@pytest.mark.parametrize("wanted", [0.0, 90.0, 200.0, 359.0])
def test_without_obstacles_the_field_settles_on_the_heading_wanted(wanted: float) -> None:
    assert heading(wanted) == pytest.approx(wanted, abs=1.0)


def test_an_obstacle_pushes_the_heading_aside() -> None:
    assert heading(90.0, 80.0) == pytest.approx(122.0, abs=4.0)
    assert heading(90.0, 100.0) == pytest.approx(55.0, abs=4.0)


def test_two_obstacles_about_the_way_leave_none() -> None:
    assert heading(90.0, 60.0, 120.0) is None


def test_an_obstacle_behind_does_not_matter() -> None:
    assert heading(0.0, 180.0) == pytest.approx(0.0, abs=1.0)


def test_a_far_obstacle_pushes_less() -> None:
    near = heading_of(0.0, [(0.2, 1.0)])
    far = heading_of(0.0, [(0.2, 0.2)])
    assert near is not None
    assert far is not None
    assert angular_distance(far, 0.0) < angular_distance(near, 0.0)


def test_one_peak_remains() -> None:
    u = settled(input_to(1.0, []))
    above = u > 0.0
    assert 0 < above.sum() < 120
    assert (above != np.roll(above, -1)).sum() == 2
