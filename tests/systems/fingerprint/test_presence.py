"""How likely a feature is seen again by what its fingerprint says of it."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.systems.fingerprint.presence import COLUMNS, fitted_lean, probability, table
from fpnav.systems.fingerprint.symbols import features_of


def test_the_table_says_how_fast_a_bearing_turns() -> None:
    rows = features_of(
        np.array([b"c", b"c", b"c"]), np.deg2rad([0.0, 90.0, 180.0]), np.full(3, 0.7)
    )
    rows["range_m"], rows["seen"] = [2.0, 2.0, 0.1], [1, 3, 6]
    found = dict(zip(COLUMNS, table(rows).T, strict=True))
    assert found["certainty"] == pytest.approx([0.7] * 3)
    assert found["seen"].tolist() == [1.0, 3.0, 6.0]
    assert found["parallax"] == pytest.approx([0.0, 0.5, 0.0], abs=1e-12)
    assert found["range"] == pytest.approx(np.log([2.0, 2.0, 0.3]))
    assert found["ahead"] == pytest.approx([1.0, 0.0, -1.0], abs=1e-12)
    assert table(rows[:0]).shape == (0, len(COLUMNS))


def test_a_logistic_is_recovered_from_what_it_made() -> None:
    rng = np.random.default_rng(3)
    evidence = rng.normal([0.5, 3.0, 0.2, 1.0, 0.0], [0.2, 1.5, 0.2, 0.6, 0.7], (40_000, 5))
    true = np.array([1.5, 0.4, -3.0, 0.3, 0.6, -1.2])
    again = rng.random(len(evidence)) < probability(evidence, true)
    assert fitted_lean(evidence, again) == pytest.approx(true, abs=0.15)


def test_a_column_that_never_changes_weighs_nothing() -> None:
    rng = np.random.default_rng(4)
    evidence = rng.normal(0.0, 1.0, (500, 5))
    evidence[:, 1] = 0.1
    lean = fitted_lean(evidence, rng.random(500) < 0.5)
    assert lean[1] == 0.0
    assert np.isfinite(lean).all()


def test_outcomes_all_alike_leave_finite_weights() -> None:
    evidence = np.random.default_rng(5).normal(0.0, 1.0, (100, 5))
    for outcome in (np.ones(100, bool), np.zeros(100, bool)):
        lean = fitted_lean(evidence, outcome)
        assert np.isfinite(lean).all()
        assert np.abs(probability(evidence, lean) - outcome).max() < 0.1
