"""Grids over bearing: exact cosines under every shift."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.matching.grids import LARGEST, cosines, quantised
from fpnav.values import FloatArray

BINS, DEPTH = 24, 7
SHIFTS = np.arange(-5, 6)


def grid(seed: int) -> FloatArray:
    rng = np.random.default_rng(seed)
    return np.maximum(rng.normal(size=(BINS, DEPTH)), 0.0)


def plainly(
    x: FloatArray, cover_x: FloatArray, y: FloatArray, cover_y: FloatArray, shift: int
) -> float:
    moved, seen = np.roll(y, -shift, axis=0), np.roll(cover_y, -shift)
    both = cover_x & seen
    first, second = x[both].astype(float), moved[both].astype(float)
    norm = np.sqrt((first**2).sum() * (second**2).sum())
    return float((first * second).sum() / norm) if norm > 0 else 0.0


@pytest.mark.parametrize("width", [BINS, 12])
def test_the_kernel_equals_numpy_to_the_last_bit(width: int) -> None:
    grids = np.array([quantised(grid(seed)) for seed in range(6)])
    covers = np.array([np.roll(np.arange(BINS) < width, seed) for seed in range(6)])
    scores, shifts = cosines(grids[0], covers[0], grids, covers, np.arange(6), SHIFTS)
    for k in range(6):
        expected = [plainly(grids[0], covers[0], grids[k], covers[k], s) for s in SHIFTS]
        assert scores[k] == max(expected)
        assert shifts[k] == SHIFTS[int(np.argmax(expected))]


def test_a_shifted_grid_is_found_where_it_was_shifted_to() -> None:
    one, cover = quantised(grid(1)), np.ones(BINS, bool)
    moved = np.roll(one, 3, axis=0)
    scores, shifts = cosines(one, cover, moved[None], cover[None], np.zeros(1, np.int64), SHIFTS)
    assert scores[0] == pytest.approx(1.0)
    assert shifts[0] == 3


def test_grids_without_anything_are_alike_in_nothing() -> None:
    nothing, cover = np.zeros((BINS, DEPTH), np.int32), np.ones(BINS, bool)
    scores, _ = cosines(nothing, cover, nothing[None], cover[None], np.zeros(1, np.int64), SHIFTS)
    assert scores.tolist() == [0.0]


def test_the_largest_value_fills_the_scale() -> None:
    assert quantised(grid(2)).max() == LARGEST
    assert quantised(np.zeros((2, 2))).max() == 0
