"""Intervals: the same every time, wider for runs than for independent draws, honest when small."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.evaluation.bootstrap import _resampled, interval, median, ratio


def test_every_draw_has_the_length_of_the_run_and_is_made_of_blocks() -> None:
    weights = np.vstack(list(_resampled(37, 10)))
    assert weights.shape == (1000, 37)
    assert (weights.sum(axis=1) == 37).all()
    assert (weights[:, 0] <= 4).all()


def test_the_interval_is_the_same_every_time() -> None:
    hits = np.random.default_rng(1).random(100) < 0.7
    first = interval(ratio(hits, np.ones(100)), 100)
    assert first == interval(ratio(hits, np.ones(100)), 100)
    assert first[0] < hits.mean() < first[1]


def test_runs_of_equal_outcomes_give_a_wider_interval_than_scattered_ones() -> None:
    runs = np.repeat([True, False] * 5, 20)
    scattered = np.tile([True, False], 100)
    wide = np.diff(interval(ratio(runs, np.ones(200)), 200))
    narrow = np.diff(interval(ratio(scattered, np.ones(200)), 200))
    assert wide > 5 * narrow


def test_independent_units_reproduce_the_binomial_interval() -> None:
    hits = np.arange(400) % 4 == 0
    low, high = interval(ratio(hits, np.ones(400)), 400, block=1)
    spread = 1.96 * np.sqrt(0.25 * 0.75 / 400)
    assert (low, high) == pytest.approx((0.25 - spread, 0.25 + spread), abs=0.01)


def test_fewer_than_two_blocks_have_no_interval() -> None:
    assert np.isnan(interval(ratio(np.ones(19), np.ones(19)), 19)).all()


def test_a_figure_no_draw_has_is_no_interval() -> None:
    assert np.isnan(interval(ratio(np.zeros(50), np.zeros(50)), 50)).all()


@given(st.lists(st.tuples(st.floats(-9, 9), st.integers(0, 4)), min_size=1, max_size=20))
def test_the_weighted_median_is_that_of_the_repeated_sample(
    units: list[tuple[float, int]],
) -> None:
    values = np.array([value for value, _ in units])
    weights = np.array([[float(count) for _, count in units]])
    repeated = np.repeat(values, weights[0].astype(int))
    found = median(values, np.ones(len(values), bool))(weights)[0]
    if len(repeated):
        assert found == pytest.approx(np.median(repeated))
    else:
        assert np.isnan(found)
