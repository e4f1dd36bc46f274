"""Vertical edges of an equal-angle strip."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.sensing.edges import smooth, vertical_edges


def steps(width: int, *columns: int, height: int = 120) -> np.ndarray:
    """Grey image that changes between dark and bright at each column."""
    level = np.zeros(width, bool)
    for column in columns:
        level[column:] ^= True
    row = np.where(level, 0.8, 0.2).astype(np.float32)
    return np.tile(row, (height, 1))


def test_a_step_is_an_edge_between_its_columns() -> None:
    columns, certainty = vertical_edges(steps(720, 100, 400), circular=True)
    assert columns == pytest.approx([99.5, 399.5], abs=0.51)
    assert (certainty > 0.99).all()


def test_an_image_without_structure_has_no_edges() -> None:
    columns, certainty = vertical_edges(np.full((120, 720), 0.5, np.float32), circular=True)
    assert len(columns) == len(certainty) == 0


def test_horizontal_edges_do_not_count() -> None:
    image = np.full((120, 720), 0.2, np.float32)
    image[60:] = 0.9
    assert len(vertical_edges(image, circular=True)[0]) == 0


def test_a_circular_view_has_the_edge_at_its_seam_and_an_open_view_has_not() -> None:
    image = steps(720, 300)  # dark 0..299, bright 300..719: circularly a second edge at the seam
    assert len(vertical_edges(image, circular=True)[0]) == 2
    assert len(vertical_edges(image, circular=False)[0]) == 1


def test_neighbours_within_three_degrees_are_one_edge() -> None:
    image = steps(720, 100, 104, 300, 320)
    columns, _ = vertical_edges(image, circular=True)
    assert len(columns) == 3
    assert 98.0 <= columns[0] <= 105.0


def test_a_taller_edge_is_more_certain() -> None:
    image = steps(720, 100, 110)
    image[:70, 395:410] = 0.8
    image[:, 600:610] = 0.8
    columns, certainty = vertical_edges(image, circular=True)
    tall = certainty[np.abs(columns - 599.5).argmin()]
    short = certainty[np.abs(columns - 394.5).argmin()]
    assert 0.3 <= short < tall <= 1.0


@given(st.integers(0, 719))
def test_turning_the_view_turns_the_edges(shift: int) -> None:
    image = steps(720, 100, 160, 333, 500)
    before, certainty = vertical_edges(image, circular=True)
    after, certainty_after = vertical_edges(np.roll(image, shift, axis=1), circular=True)
    turned = np.sort((before + shift) % 720)
    assert np.allclose(np.sort(after % 720), turned, atol=1e-6)
    assert np.allclose(np.sort(certainty), np.sort(certainty_after))


@given(st.lists(st.floats(0.0, 1.0), min_size=9, max_size=30), st.sampled_from([1, 3, 7]))
def test_smoothing_is_the_mean_over_the_window(values: list[float], columns: int) -> None:
    row = np.array(values)
    half = columns // 2
    at = np.arange(len(row))[:, None] + np.arange(-half, half + 1)[None, :]
    assert np.allclose(smooth(row, columns, circular=True), row[at % len(row)].mean(axis=1))
    clipped = row[np.clip(at, 0, len(row) - 1)].mean(axis=1)
    assert np.allclose(smooth(row, columns, circular=False), clipped)


def test_an_open_view_may_have_an_edge_next_to_its_border() -> None:
    image = steps(120, 2)
    columns, _ = vertical_edges(image, circular=False)
    assert len(columns) == 1
    assert columns[0] == pytest.approx(1.5, abs=1.0)
