"""Place fields, worked by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fpnav.errors import TruthError
from fpnav.evaluation.fields import (
    Fields,
    field_slope,
    fields_of,
    half_width_ratio,
    learned_activity,
    nearest_wins,
    occlusion,
    peak_error,
    roughness,
    roughness_ratio,
    silent,
    widths,
)


def tents(learned: list[float], half_width: float, step: float = 0.1, end: float = 4.0) -> Fields:
    """Triangular fields of height 1 about each place."""
    x = np.arange(0.0, end + 1e-9, step)
    apart = np.abs(x[:, None] - np.array(learned)[None, :])
    return Fields(x, np.maximum(1.0 - apart / half_width, 0.0), np.array(learned))


def test_the_nearest_of_symmetric_fields_wins_everywhere() -> None:
    found = nearest_wins(tents([1.0, 2.0, 3.0], 1.0))
    assert (found.value, found.n, found.of) == (1.0, 39, 39)


def test_silent_samples_are_counted_apart() -> None:
    fields = tents([1.0, 3.0], 0.55)
    assert silent(fields).n == 19
    assert nearest_wins(fields).of == 22


def test_the_peak_error_is_the_worst_of_the_places() -> None:
    fields = tents([1.0, 3.0], 1.0)
    moved = Fields(fields.position_m, fields.activity, fields.learned_m + np.array([0.1, 0.3]))
    assert peak_error(moved).value == pytest.approx(0.3)


def test_widths_are_read_between_samples() -> None:
    assert widths(tents([2.0], 1.0), 0.5) == pytest.approx([1.0])
    assert widths(tents([2.0], 1.0, step=0.3), 0.25)[0] == pytest.approx(1.5, abs=0.2)


def test_a_field_is_cut_at_the_ends_of_the_line() -> None:
    assert widths(tents([0.0], 1.0), 0.5) == pytest.approx([0.5])


def test_a_silent_place_has_no_width() -> None:
    fields = Fields(np.arange(3.0), np.zeros((3, 1)), np.zeros(1))
    assert widths(fields, 0.5).tolist() == [0.0]


def test_the_half_width_ratio_compares_means() -> None:
    assert half_width_ratio(tents([2.0], 1.5), tents([2.0], 0.5)).value == pytest.approx(3.0)


def test_a_straight_field_is_smooth() -> None:
    x = np.linspace(0.0, 5.0, 51)
    assert roughness(Fields(x, x[:, None], np.zeros(1))) == pytest.approx(0.0, abs=1e-12)


def test_alternating_activity_is_rough() -> None:
    x = np.arange(60.0)
    wave = Fields(x, (x % 2)[:, None], np.zeros(1))
    assert roughness(wave) == pytest.approx(0.5, abs=0.05)
    half = Fields(x, 0.5 * (x % 2)[:, None], np.zeros(1))
    assert roughness_ratio(half, wave).value == pytest.approx(0.5)


def test_activity_is_read_where_places_were_learned() -> None:
    fields = tents([1.04, 3.0], 1.0)
    assert learned_activity(fields).value == pytest.approx(0.96)


def test_fields_that_double_with_the_world_have_slope_one() -> None:
    scales = np.array([5.0, 10.0, 50.0])
    assert field_slope(scales, 2.0 * scales).value == pytest.approx(1.0)
    assert field_slope(scales, np.sqrt(scales)).value == pytest.approx(0.5)


def test_hiding_is_judged_beyond_where_it_begins() -> None:
    free = tents([1.0, 2.0, 3.0], 1.0)
    late = free.position_m >= 1.95
    dimmed = Fields(
        free.position_m, np.where(late[:, None], 0.8, 1.0) * free.activity, free.learned_m
    )
    ratio, winner = occlusion(dimmed, free, 1.95)
    assert (ratio.value, ratio.n, ratio.of) == (pytest.approx(0.8), 2, 3)
    assert winner.value == pytest.approx(20 / 21)


def line_result(**changes: object) -> SimpleNamespace:
    """Three samples along y on two places; the second listed place was learned first."""
    pose = [("truth", "<f8", (3,))]
    queries = np.array([((5.0, 1.0, 0.0),), ((5.0, 2.0, 0.0),), ((5.0, 0.0, 0.0),)], pose)
    references = np.array([((5.0, 2.0, 0.0),), ((5.0, 0.5, 0.0),)], pose)
    fields = {
        "queries": queries,
        "references": references,
        "owner": np.array([3, 7]),
        "places": np.array([[3, 7], [3, -1], [7, 3]]),
        "scores": np.array([[0.6, 0.5], [0.9, -math.inf], [0.8, 0.1]]),
    }
    return SimpleNamespace(**{**fields, **changes})


def test_fields_are_read_from_a_result_along_the_line() -> None:
    fields = fields_of(line_result())
    assert fields.position_m.tolist() == [0.0, 1.0, 2.0]
    assert fields.learned_m.tolist() == [0.0, 1.5]
    assert fields.activity.tolist() == [[0.9, 0.0], [0.6, 0.5], [0.1, 0.8]]


def test_without_truth_there_are_no_fields() -> None:
    queries = line_result().queries.copy()
    queries["truth"][0] = np.nan
    with pytest.raises(TruthError, match="true pose"):
        fields_of(line_result(queries=queries))
