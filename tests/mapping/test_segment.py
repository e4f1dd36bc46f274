"""Thresholds on novelties, hand-worked."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.mapping.segment import otsu, resolve_threshold
from fpnav.systems.base import MapRule
from fpnav.values import FloatArray

novelties = st.lists(st.floats(0.0, 1.0), min_size=2, max_size=60)


def auto(values: list[float], nodes: int = 0, rule: Literal["auto", "otsu"] = "auto") -> float:
    return resolve_threshold(MapRule(rule, nodes), lambda: np.array(values))


def never() -> FloatArray:
    raise AssertionError("the novelties were asked for")


def test_a_number_is_taken_as_it_is_and_asks_for_nothing() -> None:
    assert resolve_threshold(MapRule(0.55), never) == 0.55


def test_auto_is_the_quantile_that_gives_so_many_places() -> None:
    # 5 novelties, 3 places: quantile at 1 - 2/5, which lies at 2.4 in .1 .2 .3 .8 .9
    assert auto([0.1, 0.9, 0.2, 0.8, 0.3], 3) == pytest.approx(0.5)


def test_auto_of_the_paper_is_at_962_thousandths() -> None:
    assert auto(np.linspace(0.0, 1.0, 499).tolist(), 20) == pytest.approx(1 - 19 / 499)


@given(
    st.lists(st.integers(0, 1000).map(lambda n: n / 1000), min_size=1, max_size=40, unique=True),
    st.data(),
)
def test_auto_cuts_one_time_less_than_there_are_places(
    values: list[float], data: st.DataObject
) -> None:
    nodes = data.draw(st.integers(1, len(values) + 1))
    cuts = np.sum(np.array(values) >= auto(values, nodes))
    assert cuts == nodes - 1


def test_more_places_than_signatures_cut_everywhere() -> None:
    assert auto([0.3, 0.2, 0.4], 50) == 0.2


def test_otsu_of_two_clusters_is_the_middle_of_the_empty_valley() -> None:
    # bins of 1/64: 0.1 falls in bin 6, 0.6 in bin 38; any border between 7/64 and 38/64 splits
    assert otsu(np.array([0.1] * 9 + [0.6] * 3)) == pytest.approx((7 + 38) / 2 / 64)


def test_auto_without_a_number_of_places_and_otsu_are_the_valley_within_limits() -> None:
    assert auto([0.1, 0.1, 0.6]) == auto([0.1, 0.1, 0.6], rule="otsu") == pytest.approx(45 / 128)
    assert auto([0.01, 0.01, 0.1]) == 0.3
    assert auto([0.8, 0.9, 1.0]) == 0.8


def test_one_value_a_rounding_error_outside_or_none_at_all_give_a_middling_threshold() -> None:
    assert 0.3 <= auto([0.4]) <= 0.8
    assert 0.3 <= auto([-1e-17, -1e-17]) <= 0.8
    assert auto([]) == auto([np.nan]) == pytest.approx(0.55)


@given(novelties)
def test_otsu_splits_as_well_as_the_best_border(values: list[float]) -> None:
    centres = np.minimum((np.array(values) * 64).astype(int), 63) + 0.5

    def between(border: float) -> float:
        low, high = centres[centres < border * 64], centres[centres >= border * 64]
        if len(low) == 0 or len(high) == 0:
            return 0.0
        return float(len(low) * len(high) * (low.mean() - high.mean()) ** 2)

    best = max(between(edge / 64) for edge in range(65))
    assert between(otsu(np.array(values))) == pytest.approx(best)
