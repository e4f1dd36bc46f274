"""Headings without a compass."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.systems.placecell.compass import search_grid, visual_heading
from fpnav.systems.placecell.neurons import neuron_azimuth


@pytest.mark.parametrize(("step_deg", "count"), [(5.0, 72), (7.0, 52), (90.0, 4)])
def test_the_search_goes_all_around_in_even_steps(step_deg: float, count: int) -> None:
    grid = search_grid(math.radians(step_deg))
    assert len(grid) == count
    assert np.diff(grid) == pytest.approx(2 * math.pi / count)


def test_landmarks_agree_on_the_heading() -> None:
    bearing = np.radians([0.0, 40.0, -120.0])
    found = visual_heading(np.ones(3), bearing, bearing + math.radians(300.3))
    assert math.degrees(found) == pytest.approx(300.5, abs=1e-6)


def test_the_heavier_vote_wins() -> None:
    azimuth = np.radians([10.0, 100.0, 102.0])
    found = visual_heading(np.array([0.9, 0.5, 0.5]), np.zeros(3), azimuth)
    assert math.degrees(found) == pytest.approx(101.0, abs=1.0)


def test_without_votes_there_is_no_heading() -> None:
    assert math.isnan(visual_heading(np.zeros(0), np.zeros(0), np.zeros(0)))
    assert math.isnan(visual_heading(np.zeros(2), np.zeros(2), np.zeros(2)))


def test_two_degree_neurons_take_the_nearest_azimuth() -> None:
    azimuth = np.radians([0.9, 1.1, 359.5, -3.2])
    assert np.degrees(neuron_azimuth(azimuth, 180)) == pytest.approx([0.0, 2.0, 0.0, 356.0])
    assert neuron_azimuth(azimuth, 0) == pytest.approx(np.mod(azimuth, 2 * math.pi))
