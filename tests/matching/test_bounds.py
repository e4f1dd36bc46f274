"""Upper bounds from bags of symbols."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.strings import SCORES, random_strings, strings
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching import compiled, rotations
from fpnav.matching.bounds import bags, most, ratio_bounds
from fpnav.matching.strings import SCORE_GRID


def bounds(x: object, y: object) -> np.ndarray:
    rows = np.arange(len(y))  # type: ignore[arg-type]
    earned = most(bags(x, SCORES), 0, bags(y, SCORES), rows, SCORES)  # type: ignore[arg-type]
    return ratio_bounds(x, 0, y, rows, earned)  # type: ignore[arg-type]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_no_alignment_beats_its_bound(seed: int, partial: bool) -> None:
    x, y = random_strings(seed, 1, 14, partial=partial), random_strings(seed + 1, 12, 14)
    scores = rotations.rotation_ratios(x, 0, y, np.arange(12), SCORES).max(axis=1)
    assert (bounds(x, y) >= scores).all()


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_the_compiled_bound_is_the_same(seed: int) -> None:
    x, y = bags(random_strings(seed, 2, 14), SCORES), bags(random_strings(seed + 1, 9, 14), SCORES)
    rows = np.array([8, 0, 3])
    first, second = most(x, 1, y, rows, SCORES), compiled.most(x, 1, y, rows, SCORES)
    assert first == pytest.approx(second, abs=1e-12)


def test_hues_two_bins_apart_cost_nothing_which_the_bound_must_grant() -> None:
    x, y = strings(["A"]), strings(["C"])
    assert rotations.rotation_ratios(x, 0, y, np.zeros(1, np.int64), SCORES)[0, 0] == 0.0
    assert bounds(x, y)[0] >= 0.0


def test_a_bag_holds_the_heaviest_first() -> None:
    found = bags(strings(["vcvv"], [[0.5, 1.0, 1.0, 0.25]]), SCORES)
    assert found.counts[0, 16] == 3
    assert found.best[0, 16].tolist() == [0.0, 1.0, 1.5, 1.75]
    assert found.best[0, 17].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert found.totals[0].sum() == 2.75


def test_equal_bags_are_bounded_by_one() -> None:
    found = bounds(strings(["vcA"]), strings(["Avc", "v"]))
    assert found[0] == pytest.approx(1.0, abs=6 * SCORE_GRID)
    assert found[1] < 0.4


def test_nothing_is_bounded_by_nought_and_partial_views_not_at_all() -> None:
    empty = strings([""])
    assert bounds(empty, empty).tolist() == [0.0]
    half = strings(["v"], arcs=[[(0.0, 1.0), (0.0, 1.0)]])
    assert bounds(half, strings(["v"])).tolist() == [np.inf]
