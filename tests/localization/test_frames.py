"""Matches smoothed over reference frames: against the sum over all paths, the gate, the runs."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.localization.frames import JUMP, likelihoods, posterior, smoothed_frames
from fpnav.systems.base import Recall


def recall_of(scores: NDArray[np.float64]) -> Recall:
    order = np.argsort(-scores, axis=1, kind="stable")
    values = np.take_along_axis(scores, order, axis=1)
    places = np.where(np.isfinite(values), order, -1)
    return Recall(places, values, np.full(values.shape, np.nan))


def starts(count: int) -> NDArray[np.bool_]:
    return np.arange(count) == 0


def test_the_posterior_is_the_sum_over_all_paths() -> None:
    rng = np.random.default_rng(0)
    likelihood = rng.uniform(0.1, 1.0, (3, 4))
    window = (-1, 2)
    step = np.array(
        [[(1 - JUMP) * (-1 <= j - i <= 2) / 4 + JUMP / 4 for j in range(4)] for i in range(4)]
    )
    expected = np.zeros((3, 4))
    for path in itertools.product(range(4), repeat=3):
        weight = 0.25 * np.prod([likelihood[t, path[t]] for t in range(3)])
        weight *= step[path[0], path[1]] * step[path[1], path[2]]
        for t in range(3):
            expected[t, path[t]] += weight
    expected /= expected.sum(axis=1, keepdims=True)
    assert posterior(likelihood, starts(3), window) == pytest.approx(expected)


@pytest.mark.parametrize("backwards", [False, True])
def test_a_query_that_was_lost_is_held_by_its_neighbours(backwards: bool) -> None:
    rng = np.random.default_rng(1)
    scores = rng.normal(0.0, 1.0, (60, 70))
    true = np.arange(60)[::-1] if backwards else np.arange(60)
    scores[np.arange(60), true] += 8.0
    scores[30, true[30]] -= 8.0
    found = smoothed_frames(recall_of(scores), starts(60), 70)
    assert np.argmax(scores[30]) != true[30]
    assert abs(found.places[30, 0] - true[30]) <= 3
    assert np.mean(found.places[:, 0] == true) > 0.95


def test_where_no_window_explains_the_run_nothing_is_smoothed() -> None:
    rng = np.random.default_rng(2)
    scores = rng.normal(0.0, 1.0, (40, 50))
    scores[np.arange(40), rng.permutation(50)[:40]] += 12.0
    recall = recall_of(scores)
    assert smoothed_frames(recall, starts(40), 50) is recall


def test_what_is_no_candidate_is_never_answered() -> None:
    rng = np.random.default_rng(3)
    scores = rng.normal(0.0, 1.0, (40, 40))
    scores[np.arange(5, 40), np.arange(35)] += 6.0
    scores[np.triu_indices(40)] = -np.inf
    found = smoothed_frames(recall_of(scores), starts(40), 40)
    rows, ranks = np.nonzero(found.places >= 0)
    assert (found.places[rows, ranks] < rows).all()
    assert found.places[0, 0] == -1
    assert (np.diff(np.where(found.places >= 0, found.scores, -1e9), axis=1) <= 0.0).all()


def test_another_run_begins_anew() -> None:
    rng = np.random.default_rng(4)
    likelihood = likelihoods(rng.normal(size=(6, 9)))
    begins = np.array([True, False, False, True, False, False])
    both = posterior(likelihood, begins, (-1, 3))
    apart = [posterior(part, starts(3), (-1, 3)) for part in (likelihood[:3], likelihood[3:])]
    assert both == pytest.approx(np.concatenate(apart))
