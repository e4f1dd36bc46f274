"""The plain recurrence in numpy and its traceback."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.strings import SCORES, plain_score, random_strings, strings, symbols
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching import linear


def filled(x: object, y: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    pair = linear.pair_scores(x.codes, x.weights, y.codes, y.weights, SCORES)  # type: ignore[attr-defined]
    gaps_x = linear.gap_costs(x.codes, x.weights, SCORES)  # type: ignore[attr-defined]
    gaps_y = linear.gap_costs(y.codes, y.weights, SCORES)  # type: ignore[attr-defined]
    return linear.table(pair, gaps_x, gaps_y), pair, gaps_x


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_the_table_ends_in_the_score_of_the_recurrence(seed: int) -> None:
    x, y = random_strings(seed, 1, 15), random_strings(seed + 1, 1, 15)
    expected = plain_score(symbols(x, 0), symbols(y, 0), SCORES)
    assert filled(x, y)[0][-1, -1] == pytest.approx(expected, abs=1e-4)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_the_path_traced_back_earns_the_score(seed: int) -> None:
    x, y = random_strings(seed, 1, 15), random_strings(seed + 1, 1, 15)
    values, pair, gaps_x = filled(x, y)
    partner = linear.traceback(values, pair, gaps_x)
    matched = np.flatnonzero(partner >= 0)
    assert (np.diff(partner[matched]) > 0).all()  # order is kept
    gaps_y = linear.gap_costs(y.codes, y.weights, SCORES)
    earned = pair[partner[matched], matched].sum()
    paid = np.delete(gaps_x, partner[matched]).sum() + np.delete(gaps_y, matched).sum()
    assert earned - paid == values[-1, -1]


def test_of_equal_paths_the_one_that_matches_is_taken() -> None:
    x, y = strings(["A"]), strings(["E"])  # a mismatch costs as much as two gaps
    values, pair, gaps_x = filled(x, y)
    assert values[-1, -1] == -1.0
    assert linear.traceback(values, pair, gaps_x).tolist() == [0]


def test_running_sums_begin_with_nought() -> None:
    assert linear.cumulated(np.array([1.0, 2.0])).tolist() == [0.0, 1.0, 3.0]
    assert linear.cumulated(np.zeros((0, 2))).tolist() == [[0.0, 0.0]]
