"""Greedy landmark selection against every other choice."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.systems.placecell.selection import EVIDENCE, select, worth_of


def value(worth: np.ndarray, columns: tuple[int, ...]) -> float:
    return float(np.sqrt(worth[:, columns].sum(axis=1)).sum())


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
@settings(deadline=None)
def test_greedy_is_within_its_guarantee(seed: int, budget: int) -> None:
    worth = np.random.default_rng(seed).random((5, 6))
    chosen = tuple(select(worth, budget).tolist())
    best = max(value(worth, one) for one in combinations(range(6), budget))
    assert len(chosen) == budget
    assert value(worth, chosen) >= (1 - 1 / np.e) * best


def test_columns_that_serve_different_panoramas_go_together() -> None:
    worth = np.array([[0.9, 0.8, 0.0], [0.9, 0.8, 0.0], [0.0, 0.0, 0.6]])
    assert select(worth, 2).tolist() == [0, 2]


def test_what_adds_nothing_is_taken_by_its_sum_then_its_place() -> None:
    worth = np.array([[1.0, 0.2, 0.6, 0.6]])
    assert select(worth, 3).tolist() == [0, 2, 3]
    assert select(np.zeros((2, 3)), 2).tolist() == [0, 1]


def test_a_budget_above_the_number_takes_all() -> None:
    assert select(np.ones((1, 2)), 5).tolist() == [0, 1]


def test_worth_is_activity_above_the_best_elsewhere() -> None:
    evidence = np.array([(0, 4, 1.0), (0, 6, 0.8), (2, 6, 0.5), (1, 5, 1.0)], EVIDENCE)
    found = worth_of(evidence, np.array([4, 6]), np.array([0.25, 0.6]))
    assert found == pytest.approx(np.array([[0.75, 0.2], [0.0, 0.0]]))


def test_without_evidence_nothing_has_worth() -> None:
    assert worth_of(np.zeros(0, EVIDENCE), np.array([1, 2]), np.zeros(2)).shape == (0, 2)
