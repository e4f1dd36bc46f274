"""Alignment that minds angles once the turn is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.strings import SCORES, SILENT, TAU, random_strings, strings, turned
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching import cyclic
from fpnav.matching.angled import angled_ratios
from fpnav.matching.strings import Strings

WIDTH = math.radians(15.0)


def angled(x: Strings, y: Strings, width: float = WIDTH) -> np.ndarray:
    return angled_ratios(x, 0, y, np.arange(len(y)), SCORES, SILENT, width)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, TAU), st.integers(0, 30), st.booleans())
def test_a_turned_string_still_matches_itself(
    seed: int, turn: float, shift: int, partial: bool
) -> None:
    x = random_strings(seed, 1, 20, shortest=8, partial=partial)
    found = angled(x, turned(x, turn, shift))[0]
    plain = cyclic.best_ratios(x, 0, turned(x, turn, shift), np.zeros(1, np.int64), SCORES)[0]
    assert plain == 1.0
    assert found == pytest.approx(1.0, abs=1e-3)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_minding_angles_never_gains(seed: int, partial: bool) -> None:
    x = random_strings(seed, 1, 16, partial=partial)
    y = random_strings(seed + 1, 6, 16, partial=partial)
    plain = cyclic.best_ratios(x, 0, y, np.arange(6), SCORES)
    assert (angled(x, y) <= plain + 1e-9).all()
    assert (angled(x, y) >= -1.0 - 1e-9).all()


def test_places_alike_in_order_only_come_apart() -> None:
    x = strings(["vcAv"], angles=[np.radians([0.0, 90.0, 180.0, 270.0])])
    near = strings(["vcAv"], angles=[np.radians([2.0, 91.0, 178.0, 271.0])])
    skewed = strings(["vcAv"], angles=[np.radians([0.0, 30.0, 60.0, 300.0])])
    assert cyclic.best_ratios(x, 0, skewed, np.zeros(1, np.int64), SCORES)[0] == 1.0
    assert angled(x, near)[0] > 0.95
    assert angled(x, skewed)[0] < 0.3


def test_a_small_error_costs_its_square() -> None:
    off = math.radians(6.0)
    x = strings(["vcAB"], angles=[[0.0, 1.0, 2.0, 3.0]])
    y = strings(["vcAB"], angles=[[off, 1.0, 2.0 + off, 3.0]])  # the turn is half of it
    expected = 1.0 - 2.0 * (1.0 - math.cos(off / 2.0)) / WIDTH**2
    assert angled(x, y)[0] == pytest.approx(expected, abs=1e-3)
    assert expected == pytest.approx(1.0 - (off / 2.0 / WIDTH) ** 2, abs=1e-3)


def test_a_wide_tolerance_is_the_first_pass() -> None:
    x, y = random_strings(3, 1, 20, shortest=10), random_strings(4, 5, 20)
    plain = cyclic.best_ratios(x, 0, y, np.arange(5), SCORES)
    assert angled(x, y, width=1e4) == pytest.approx(plain, abs=1e-3)


@pytest.mark.parametrize(("first", "second"), [("nnn", "nnn"), ("", "v"), ("v", ""), ("", "")])
def test_where_nothing_tells_the_turn_the_first_pass_stands(first: str, second: str) -> None:
    x, y = strings([first]), strings([second])
    assert angled(x, y)[0] == cyclic.best_ratios(x, 0, y, np.zeros(1, np.int64), SCORES)[0]


def test_a_batch_answers_as_its_members() -> None:
    x, y = random_strings(5, 1, 20, shortest=9), random_strings(6, 8, 24, partial=True)
    together = angled(x, y)
    alone = [angled(x, y.take([j]))[0] for j in range(8)]
    assert together.tolist() == alone
    assert len(angled_ratios(x, 0, y, np.zeros(0, np.int64), SCORES, SILENT, WIDTH)) == 0
