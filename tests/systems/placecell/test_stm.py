"""Short-term memory: how long what was seen lasts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.systems.placecell.stm import Held, explore, largest, nothing


def run(values: list[float], qmax: int, *, literal: bool = False) -> list[float]:
    """Activity of one neuron after each panorama, seen as given."""
    held, out = nothing(1), []
    for value in values:
        held = explore(held, np.array([value]), fires=True, qmax=qmax, literal=literal)
        out.append(float(held.m[0]))
    return out


@pytest.mark.parametrize("qmax", [1, 2, 4, 7])
def test_a_triplet_survives_exactly_qmax_panoramas(qmax: int) -> None:
    seen = run([0.9] + [0.0] * (qmax + 1), qmax)
    assert seen == [0.9] * qmax + [0.0, 0.0]


def test_no_extended_memory_is_the_plain_reset() -> None:
    values = [0.9, 0.3, 0.0, 0.5]
    assert run(values, 0) == run(values, 1) == values


def test_a_rise_renews_the_protection() -> None:
    assert run([0.5, 0.7, 0.0, 0.0, 0.0], 3) == [0.5, 0.7, 0.7, 0.7, 0.0]


def test_a_weaker_sight_neither_lowers_nor_renews() -> None:
    assert run([0.9, 0.5, 0.5, 0.0], 2) == [0.9, 0.9, 0.5, 0.5]


def test_the_formula_to_the_letter_loses_what_arrives_in_the_step_of_a_reset() -> None:
    assert run([0.9, 0.0, 0.5, 0.0, 0.0], 2) == [0.9, 0.9, 0.5, 0.5, 0.0]
    assert run([0.9, 0.0, 0.5, 0.0, 0.0], 2, literal=True) == [0.9, 0.9, 0.5, 0.0, 0.0]


def test_to_the_letter_the_loss_comes_with_the_next_view() -> None:
    held = Held(np.array([0.9]), np.array([1]))
    held = explore(held, np.array([0.5]), fires=True, qmax=2, literal=True)
    held = explore(held, np.array([0.0]), fires=False, qmax=2, literal=True)
    assert held.m[0] == 0.0


SEQUENCES = st.lists(
    st.lists(st.sampled_from([0.0, 0.2, 0.5, 0.9]), min_size=1, max_size=4),
    min_size=1,
    max_size=12,
)


@given(SEQUENCES, st.integers(1, 5))
def test_a_panorama_at_once_leaves_what_view_after_view_leaves(
    panoramas: list[list[float]], qmax: int
) -> None:
    once, stepwise = nothing(1), nothing(1)
    for views in panoramas:
        once = explore(once, np.array([max(views)]), fires=True, qmax=qmax)
        for number, value in enumerate(views):
            stepwise = explore(stepwise, np.array([value]), fires=number == 0, qmax=qmax)
        assert once.m[0] == stepwise.m[0]


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12), st.integers(1, 5))
def test_what_is_held_is_never_below_what_is_seen(values: list[float], qmax: int) -> None:
    assert all(held >= value for held, value in zip(run(values, qmax), values, strict=True))


def test_neurons_recruited_since_are_active_and_protected() -> None:
    grown = Held(np.array([0.3]), np.array([1])).grown(3, 4)
    assert grown.m.tolist() == [0.3, 1.0, 1.0]
    assert grown.q.tolist() == [1, 4, 4]


def test_the_window_is_the_largest_of_the_last_panoramas() -> None:
    assert largest([np.array([0.2]), np.array([0.1, 0.4])], 3).tolist() == [0.2, 0.4, 0.0]
