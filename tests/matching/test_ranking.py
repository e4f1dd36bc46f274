"""Rankings of references."""

from __future__ import annotations

import numpy as np

from fpnav.matching.ranking import ranked


def test_the_best_come_first_and_ties_by_column() -> None:
    columns, values = ranked(np.array([[0.2, 0.9, 0.2, 0.9]]), 3, None)
    assert columns.tolist() == [[1, 3, 0]]
    assert values.tolist() == [[0.9, 0.9, 0.2]]


def test_what_is_not_allowed_is_left_out_and_gaps_are_padded() -> None:
    allowed = np.array([[False, True, False], [False, False, False]])
    columns, values = ranked(np.array([[0.9, 0.1, 0.5], [0.9, 0.1, 0.5]]), 4, allowed)
    assert columns.tolist() == [[1, -1, -1, -1], [-1] * 4]
    assert values.tolist() == [[0.1] + [-np.inf] * 3, [-np.inf] * 4]


def test_no_columns_are_a_ranking_of_nothing() -> None:
    columns, values = ranked(np.zeros((2, 0)), 2, None)
    assert columns.tolist() == [[-1, -1], [-1, -1]]
    assert np.isneginf(values).all()
