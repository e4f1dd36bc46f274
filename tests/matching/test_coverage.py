"""Partial fields of view: what is excused and what is not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.strings import SCORES, TAU, random_strings, strings
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching import compiled, rotations
from fpnav.matching.coverage import alike, comparable
from fpnav.matching.strings import Strings

FULL = (0.0, TAU)
HALF = (0.0, math.pi)
NONE = (0.0, 0.0)

ROOM = "cvcAcvcB"
ANGLES = np.radians([-80.0, -40.0, 0.0, 40.0, 80.0, 120.0, 180.0, 240.0]) % TAU


def room(keep: np.ndarray, laser: tuple[float, float], camera: tuple[float, float]) -> Strings:
    text = "".join(letter for letter, kept in zip(ROOM, keep, strict=True) if kept)
    order = np.argsort(ANGLES[keep])
    letters = "".join(text[at] for at in order)
    return strings([letters], angles=[ANGLES[keep][order]], arcs=[[laser, camera]])


EVERYTHING = np.ones(8, bool)
AHEAD = np.cos(ANGLES) > 0.0
CORNERS = np.array([letter == "c" for letter in ROOM])


def best(x: Strings, y: Strings) -> float:
    rows = np.zeros(1, np.int64)
    numpy_path = rotations.rotation_ratios(x, 0, y, rows, SCORES)
    assert np.array_equal(compiled.rotation_ratios(x, 0, y, rows, SCORES), numpy_path)
    return float(numpy_path.max())


def test_views_that_cover_as_much_are_alike() -> None:
    half, full = np.array([HALF, NONE]), np.array([FULL, NONE])
    assert alike(half, half)
    assert alike(half, np.array([(1.0, math.pi), NONE]))
    assert not alike(half, full)
    assert alike(np.array([half, full]), full).tolist() == [False, True]


def test_half_a_view_of_a_place_matches_the_whole() -> None:
    whole, half = room(EVERYTHING, FULL, FULL), room(AHEAD, HALF, HALF)
    assert best(half, whole) == 1.0
    assert best(whole, half) == 1.0


def test_without_the_rule_half_a_view_would_miss_the_rest() -> None:
    whole, half = room(EVERYTHING, FULL, FULL), room(AHEAD, HALF, HALF)
    blind = Strings(half.codes, half.weights, half.angles_rad, half.offsets, whole.arcs, half.fixed)
    assert best(blind, whole) < 0.8


def test_a_missing_sensor_excuses_all_its_symbols() -> None:
    whole, corners = room(EVERYTHING, FULL, FULL), room(CORNERS, FULL, NONE)
    assert best(corners, whole) == 1.0
    assert best(whole, corners) == 1.0


def test_a_correspondence_needs_both_sensors_and_empty_space_any() -> None:
    x = strings(["cfvn"], arcs=[[FULL, FULL]])
    y = strings(["cn"], arcs=[[FULL, NONE]])
    seen_x, seen_y = comparable(x, 0, y, 0, SCORES)
    assert seen_x[0].tolist() == [True, False, False, True]
    assert seen_y.all()


def test_views_that_overlap_in_part_excuse_nothing() -> None:
    x = strings(["vv"], angles=[[0.2, 1.2]], arcs=[[NONE, (0.0, 3.0)]])
    y = strings(["vv"], angles=[[0.2, 1.4]], arcs=[[NONE, (1.0, 2.0)]])
    seen_x, seen_y = comparable(x, 0, y, 0, SCORES)
    # rotation 0 turns by 0: arc 0..2 of y reaches past -1.5..1.5 of x; rotation 1 turns by -1:
    # then -2.5..0.5 holds nothing of it either
    assert seen_x.all()
    assert seen_y.all()


def test_a_contained_view_excuses_what_lies_outside_it() -> None:
    x = strings(["vvv"], angles=[[0.1, 1.0, 2.5]], arcs=[[NONE, FULL]])
    y = strings(["vv"], angles=[[0.1, 1.0]], arcs=[[NONE, (0.5, 1.4)]])
    seen_x, seen_y = comparable(x, 0, y, 0, SCORES)
    assert seen_x[0].tolist() == [True, True, False]
    assert seen_x[1].tolist() == [False, True, False]  # x_1 in place of y_0
    assert seen_y.all()
    assert best(x, y) == 1.0


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_partial_views_stay_within_the_limits(seed: int) -> None:
    x = random_strings(seed, 1, 12, partial=True, shortest=1)
    y = random_strings(seed + 1, 6, 12, partial=True)
    found = rotations.rotation_ratios(x, 0, y, np.arange(6), SCORES)
    assert (np.abs(found) <= 1.0).all()
    assert rotations.rotation_ratios(x, 0, x, np.zeros(1, np.int64), SCORES).max() == 1.0


@pytest.mark.parametrize("turn", [0.0, 0.7, 3.0, 5.5])
def test_the_contained_view_may_look_anywhere(turn: float) -> None:
    whole, half = room(EVERYTHING, FULL, FULL), room(AHEAD, HALF, HALF)
    arcs = half.arcs.copy()
    arcs[..., 0] = (arcs[..., 0] + turn + math.pi) % TAU - math.pi
    angles = (half.angles_rad + turn) % TAU
    order = np.argsort(angles)
    turned = Strings(
        half.codes[order], half.weights[order], angles[order], half.offsets, arcs, half.fixed
    )
    assert best(turned, whole) == 1.0
