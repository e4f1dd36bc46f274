"""Penalised segmentation by exact dynamic programming."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.matching.changepoint import segment_by_count, segment_by_penalty, similarity_band


def kernel(seed: int, count: int) -> np.ndarray:
    points = np.random.default_rng(seed).normal(0.0, 1.0, (count, 2)).cumsum(axis=0)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.exp(-apart)


def band_of(matrix: np.ndarray, longest: int) -> np.ndarray:
    return similarity_band(len(matrix), longest, lambda i, j: float(matrix[i, j]))


def cost(matrix: np.ndarray, starts: tuple[int, ...]) -> float:
    bounds = [*starts, len(matrix)]
    return sum((b - a) - matrix[a:b, a:b].sum() / (b - a) for a, b in itertools.pairwise(bounds))


def segmentations(count: int, longest: int, least: int) -> list[tuple[int, ...]]:
    found = []
    for cuts in range(count):
        for inner in itertools.combinations(range(1, count), cuts):
            lengths = np.diff([0, *inner, count])
            if lengths.max() <= longest and (lengths[:-1] >= least).all():
                found.append((0, *inner))
    return found


@settings(max_examples=30)
@given(st.integers(0, 9999), st.floats(0.0, 2.0), st.integers(3, 9), st.integers(1, 3))
def test_no_segmentation_is_cheaper(seed: int, penalty: float, longest: int, least: int) -> None:
    matrix = kernel(seed, 9)
    found = tuple(segment_by_penalty(band_of(matrix, longest), penalty, least).tolist())
    options = segmentations(9, longest, least)
    assert found in options
    cheapest = min(cost(matrix, one) + penalty * len(one) for one in options)
    assert cost(matrix, found) + penalty * len(found) == pytest.approx(cheapest)


@settings(max_examples=30)
@given(st.integers(0, 9999), st.integers(1, 6), st.integers(1, 2))
def test_no_segmentation_into_as_many_is_cheaper(seed: int, segments: int, least: int) -> None:
    matrix = kernel(seed, 9)
    found = tuple(segment_by_count(band_of(matrix, 9), segments, least).tolist())
    options = [one for one in segmentations(9, 9, least) if len(one) == len(found)]
    assert len(found) == min(segments, 9 // least)
    assert cost(matrix, found) == pytest.approx(min(cost(matrix, one) for one in options))


def blocks(*lengths: int) -> np.ndarray:
    owner = np.repeat(np.arange(len(lengths)), lengths)
    return np.where(owner[:, None] == owner[None, :], 0.8, 0.2) + 0.2 * np.eye(len(owner))


def test_blocks_are_found_where_they_begin() -> None:
    band = band_of(blocks(12, 7, 20), 39)
    assert segment_by_penalty(band, 2.0).tolist() == [0, 12, 19]
    assert segment_by_count(band, 3).tolist() == [0, 12, 19]


def test_a_high_penalty_makes_one_segment_and_none_makes_every_view_one() -> None:
    band = band_of(blocks(5, 5), 10)
    assert segment_by_penalty(band, 100.0).tolist() == [0]
    assert segment_by_penalty(band, 0.0).tolist() == list(range(10))


def test_no_segment_is_longer_than_the_band() -> None:
    band = band_of(np.ones((10, 10)), 4)
    assert (np.diff([*segment_by_penalty(band, 5.0), 10]) <= 4).all()
    assert len(segment_by_count(band, 1)) == 3


def test_too_many_segments_for_the_least_length_are_fewer() -> None:
    assert len(segment_by_count(band_of(np.ones((10, 10)), 10), 9, least=3)) == 3


@pytest.mark.parametrize("count", [0, 1])
def test_streams_of_nothing_and_of_one_view(count: int) -> None:
    band = similarity_band(count, 5, lambda i, j: 1.0)
    assert segment_by_penalty(band, 1.0).tolist() == list(range(count))
    assert segment_by_count(band, 3).tolist() == list(range(count))
