"""Packed strings and the grid their scores lie on."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.strings import random_strings, strings
from hypothesis import given
from hypothesis import strategies as st

from fpnav.matching.strings import SCORE_GRID, WEIGHT_GRID, concatenated, on_grid


@given(st.floats(0.0, 4.0))
def test_the_grid_is_near_and_stays(value: float) -> None:
    once = on_grid(np.array([value]))
    assert abs(once[0] - value) <= WEIGHT_GRID / 2.0
    assert np.array_equal(on_grid(once), once)
    assert (once[0] / SCORE_GRID).is_integer()


@given(st.integers(0, 2**32 - 1))
def test_sums_of_grid_values_do_not_depend_on_order_or_width(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = on_grid(rng.uniform(-1.0, 1.0, 200), SCORE_GRID)
    shuffled = rng.permutation(values).astype(np.float32)
    narrow = np.cumsum(shuffled, dtype=np.float32)[-1]
    assert float(narrow) == values.sum()


def test_taking_strings_takes_all_that_belongs_to_them() -> None:
    batch = strings(["vc", "", "Anf"], arcs=[[[0, 1], [0, 2]], [[0, 3], [0, 4]], [[0, 5], [0, 6]]])
    some = batch.take([2, 0, 1])
    assert list(some.lengths) == [3, 2, 0]
    assert list(some.codes) == [0, 19, 18, 16, 17]
    assert some.arcs[:, 0, 1].tolist() == [5, 1, 3]
    assert some.totals == pytest.approx([2.3, 2.0, 0.0], abs=1e-4)
    assert len(batch.take([])) == 0


def test_padding_weighs_nothing() -> None:
    codes, weights, angles, real = strings(["vc", "", "A"]).padded()
    assert codes.shape == weights.shape == angles.shape == real.shape == (3, 2)
    assert real.tolist() == [[True, True], [False, False], [True, False]]
    assert (weights[~real] == 0.0).all()


def test_batches_are_joined_in_order() -> None:
    parts = [random_strings(seed, 3, 8) for seed in range(3)]
    whole = concatenated(parts)
    assert len(whole) == 9
    for at in range(9):
        one, other = whole.take([at]), parts[at // 3].take([at % 3])
        assert np.array_equal(one.codes, other.codes)
        assert np.array_equal(one.weights, other.weights)
        assert np.array_equal(one.arcs, other.arcs)
    assert len(concatenated([])) == 0
