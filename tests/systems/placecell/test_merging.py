"""Merging neurons and place cells: eq. 2, 3 and 4."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.systems.placecell.merging import cell_activity, counted, diffusion, merge


def test_linear_diffusion_falls_to_zero_at_rho_pi() -> None:
    apart = np.array([0.0, 0.165 * math.pi, 0.33 * math.pi, 2.0])
    assert diffusion(apart, 0.33, "linear") == pytest.approx([1.0, 0.5, 0.0, 0.0])


def test_gaussian_diffusion_has_half_rho_pi_as_its_deviation() -> None:
    apart = np.array([0.0, 0.1 * math.pi, 0.2 * math.pi, 0.4 * math.pi])
    found = diffusion(apart, 0.2, "gaussian")
    assert found == pytest.approx([1.0, math.exp(-0.5), math.exp(-2.0), 0.0])


def test_infinite_diffusion_ignores_the_angle() -> None:
    assert diffusion(np.array([0.0, 3.0]), 0.0, "linear").tolist() == [1.0, 1.0]


@given(st.floats(0.01, 1.0), st.sampled_from(["linear", "gaussian"]))
def test_diffusion_never_rises_with_the_angle(rho: float, shape: str) -> None:
    found = diffusion(np.linspace(0.0, math.pi, 50), rho, shape)
    assert found[0] == 1.0
    assert (np.diff(found) <= 0.0).all()


def excited(offsets: list[float]) -> tuple[list[int], np.ndarray]:
    neurons, activity = merge(
        np.array([7, 3, 7]),
        np.array([0.5, 1.0, 0.8]),
        np.array([0.0, 1.0, 0.3]),
        np.array([0.0, 1.0, 0.0]),
        np.array(offsets),
        0.33,
        "linear",
    )
    return neurons.tolist(), activity


def test_a_merging_neuron_takes_the_best_of_the_views() -> None:
    neurons, activity = excited([0.0])
    assert neurons == [3, 7]
    assert activity[:, 0] == pytest.approx([1.0, max(0.5, 0.8 * (1 - 0.3 / (0.33 * math.pi)))])


def test_headings_turn_the_views() -> None:
    _, activity = excited([0.0, -0.3, 2 * math.pi - 0.3])
    assert activity[1, 1] == pytest.approx(0.8)
    assert activity[:, 1] == pytest.approx(activity[:, 2])


def test_nothing_recognised_excites_nothing() -> None:
    none = np.zeros(0)
    neurons, activity = merge(none.astype(int), none, none, none, np.zeros(4), 0.33, "linear")
    assert len(neurons) == 0
    assert activity.shape == (0, 4)


@pytest.mark.parametrize(
    ("triplets", "rho", "wanted"), [(30, 1.0, 30), (30, 0.25, 8), (3, 0.33, 1), (0, 1.0, 1)]
)
def test_the_share_that_counts_is_rounded_up(triplets: int, rho: float, wanted: int) -> None:
    assert counted(np.array([triplets]), rho)[0] == wanted


def place(activity: list[float], rho: float) -> float:
    """Activity of one cell whose neurons have the given values."""
    values = np.array(activity)
    neurons = np.flatnonzero(values)
    keep = counted(np.array([len(values)]), rho)
    cells, found = cell_activity(
        neurons, values[neurons, None], np.zeros(len(values), int), keep, keep.astype(float)
    )
    return float(found[0, 0]) if len(cells) else 0.0


def test_equation_3_is_the_mean() -> None:
    assert place([1.0, 0.5, 0.0, 0.1], 1.0) == pytest.approx(0.4)


def test_equation_4_is_the_mean_of_the_best() -> None:
    assert place([0.1, 1.0, 0.5, 0.0], 0.5) == pytest.approx(0.75)
    assert place([0.1, 1.0, 0.5, 0.0], 0.25) == pytest.approx(1.0)


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12), st.floats(0.05, 1.0))
def test_equation_4_is_what_sorting_gives(values: list[float], rho: float) -> None:
    keep = max(1, math.ceil(round(len(values) * rho, 9)))
    wanted = sum(sorted(values, reverse=True)[:keep]) / keep
    assert place(values, rho) == pytest.approx(wanted)
    assert place(values, 1.0) <= place(values, rho) + 1e-12


def test_cells_do_not_mix() -> None:
    cell = np.array([0, 0, 2, 2, 2])
    cells, found = cell_activity(
        np.array([1, 2, 4]),
        np.array([[0.5], [1.0], [0.2]]),
        cell,
        np.array([2, 1, 1]),
        np.array([2.0, 1.0, 1.0]),
    )
    assert cells.tolist() == [0, 2]
    assert found[:, 0] == pytest.approx([0.25, 1.0])
