"""Penalised segmentation by exact dynamic programming."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching.changepoint import contrast, segment_by_contrast, similarity_band


def band_of(matrix: np.ndarray, longest: int) -> np.ndarray:
    return similarity_band(len(matrix), longest, lambda i, j: float(matrix[i, j]))


def fading(count: int, changes: tuple[int, ...] = (), drop: float = 0.5) -> np.ndarray:
    """Likeness that falls off with distance, and by a factor across every change."""
    at = np.arange(count)
    alike = np.exp(-0.1 * np.abs(at[:, None] - at[None]))
    part = np.searchsorted(np.array(changes), at, side="right")
    return np.asarray(alike * drop ** np.abs(part[:, None] - part[None]))


def segmentations(count: int, least: int) -> list[tuple[int, ...]]:
    found = []
    for cuts in range(count):
        for inner in itertools.combinations(range(1, count), cuts):
            if (np.diff([0, *inner]) >= least).all():
                found.append((0, *inner))
    return found


@settings(max_examples=60)
@given(st.lists(st.floats(-0.5, 1.0), min_size=1, max_size=9), st.floats(0.0, 0.6),
       st.integers(1, 4))  # fmt: skip
def test_no_segmentation_gains_more(values: list[float], penalty: float, least: int) -> None:
    gains = np.array(values)
    found = tuple(segment_by_contrast(gains, penalty, least).tolist())
    options = segmentations(len(gains), least)
    assert found in options
    most = max(sum(gains[t] - penalty for t in one[1:]) for one in options)
    assert sum(gains[t] - penalty for t in found[1:]) == pytest.approx(most, abs=1e-9)


def test_contrast_is_the_mean_deficit_of_the_pairs_across_a_border() -> None:
    rng = np.random.default_rng(4)
    matrix = rng.uniform(0.0, 1.0, (12, 12))
    width = 3
    usual = [np.nan] + [np.mean([matrix[i, i + d] for i in range(12 - d)]) for d in (1, 2, 3)]
    found = contrast(band_of(matrix, width + 1))
    for t in range(1, 12):
        pairs = [(i, j) for i in range(t) for j in range(t, 12) if j - i <= width]
        assert found[t] == pytest.approx(np.mean([usual[j - i] - matrix[i, j] for i, j in pairs]))


def test_borders_stand_where_the_stream_changes_and_nowhere_else() -> None:
    matrix = fading(60, changes=(14, 31, 47))
    starts = segment_by_contrast(contrast(band_of(matrix, 6)), 0.1, 5)
    assert starts.tolist() == [0, 14, 31, 47]


def test_a_stream_that_only_fades_is_one_segment() -> None:
    assert segment_by_contrast(contrast(band_of(fading(60), 6)), 0.05, 5).tolist() == [0]


def test_no_view_has_no_segment_and_one_view_has_one() -> None:
    assert segment_by_contrast(np.zeros(0), 0.1, 3).tolist() == []
    assert segment_by_contrast(contrast(band_of(np.ones((1, 1)), 6)), 0.1, 3).tolist() == [0]
