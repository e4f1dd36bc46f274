"""Strips aligned, votes of keypoints, scores by a cohort: against plain versions of each."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.matching.banded import banded_scores, shifted_means, strip_distances, turned_sums
from fpnav.matching.cohort import cohort_rows, standard_scores
from fpnav.matching.neighbours import FAR, Bundle, background, nearest, votes

RNG = np.random.default_rng(5)


def plain_alignment(values: NDArray[np.float32], band: int) -> float:
    count = len(values)
    table = np.zeros((count + 1, count + 1))
    for i in range(1, count + 1):
        for j in range(1, count + 1):
            met = table[i - 1, j - 1] + values[i - 1, j - 1] if abs(i - j) <= band else -np.inf
            table[i, j] = max(met, table[i - 1, j], table[i, j - 1])
    return float(table[-1, -1])


@pytest.mark.parametrize("band", [0, 1, 3, 20])
def test_the_banded_alignment_is_the_plain_one(band: int) -> None:
    values = RNG.normal(size=(6, 12, 12)).astype(np.float32)
    expected = [plain_alignment(one, band) for one in values]
    assert banded_scores(values, band) == pytest.approx(expected, abs=1e-5)


def test_distances_are_euclidean() -> None:
    query = RNG.normal(size=(4, 7)).astype(np.float32)
    members = RNG.normal(size=(3, 4, 7)).astype(np.float32)
    found = strip_distances(query, members)
    expected = np.linalg.norm(query[None, :, None] - members[:, None], axis=3)
    assert found == pytest.approx(expected, abs=1e-4)


def test_a_turned_circle_is_found_under_its_turn() -> None:
    query = RNG.normal(size=(10, 5)).astype(np.float32)
    sums = turned_sums(strip_distances(query, np.roll(query, 3, axis=0)[None]))
    assert int(sums[0].argmin()) == 3
    assert sums[0, 3] == pytest.approx(0.0, abs=1e-2)


def test_shifts_are_means_over_what_overlaps() -> None:
    values = RNG.normal(size=(1, 6, 6)).astype(np.float32)
    expected = [np.diagonal(values[0], shift).mean() for shift in range(-2, 3)]
    assert shifted_means(values, 2)[0] == pytest.approx(expected, abs=1e-6)


def unit_rows(count: int) -> NDArray[np.float32]:
    rows = RNG.normal(size=(count, 8)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def test_nearest_is_the_least_distance_in_each_image_and_far_in_an_empty_one() -> None:
    images = [unit_rows(5), np.zeros((0, 8), np.float32), unit_rows(3)]
    query = unit_rows(4)
    found = nearest(query, Bundle.of(images))
    for column in (0, 2):
        expected = np.square(query[:, None] - images[column][None]).sum(axis=2).min(axis=1)
        assert found[:, column] == pytest.approx(expected, abs=1e-5)
    assert (found[:, 1] == FAR).all()


def test_what_every_image_holds_votes_for_none() -> None:
    common, rare = unit_rows(1), unit_rows(1)
    images = Bundle.of([np.concatenate([common, rare]), common, common, common])
    distances = nearest(np.concatenate([common, rare]), images)
    limit = background(distances)
    found = votes(distances, limit)
    assert found[0] > 0.0
    assert found[1:] == pytest.approx(np.zeros(3), abs=1e-5)


def test_some_images_of_a_bundle() -> None:
    images = [unit_rows(5), unit_rows(2), unit_rows(3)]
    some = Bundle.of(images).of_rows(np.array([2, 0]))
    assert np.array_equal(some.flat, np.concatenate([images[2], images[0]]))
    assert len(some) == 2


def test_a_cohort_is_spread_evenly_and_its_best_tenth_is_left_out() -> None:
    assert list(cohort_rows(3)) == [0, 1, 2]
    rows = cohort_rows(1000)
    assert len(rows) == 64
    assert (rows[0], rows[-1]) == (0, 999)
    cohort = np.concatenate([RNG.normal(2.0, 3.0, 90), np.full(10, 1e6)])
    found = standard_scores(np.array([2.0, 8.0]), cohort)
    kept = np.sort(cohort)[:90]
    assert found == pytest.approx((np.array([2.0, 8.0]) - kept.mean()) / kept.std())


def test_a_cohort_that_is_all_alike_says_nothing() -> None:
    assert not standard_scores(np.array([1.0, 2.0]), np.ones(10)).any()
