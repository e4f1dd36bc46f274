"""Standard parts of a system."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from fpnav.systems.base import Needs, no_verification, spread_likelihood
from fpnav.values import FloatArray


def likelihood(scores: object) -> FloatArray:
    return spread_likelihood(None, np.asarray(scores, dtype=np.float64))


def test_needs_name_the_groups_of_which_no_role_is_there() -> None:
    needs = Needs(("scan", "panorama", "camera"), (("panorama", "camera"), ("scan",)))
    assert needs.missing(["camera"]) == (("scan",),)
    assert needs.missing([]) == (("panorama", "camera"), ("scan",))
    assert needs.missing(["scan", "panorama", "odometry"]) == ()


def test_likelihood_falls_to_a_fifth_over_the_spread_of_a_row() -> None:
    scores = np.linspace(0.0, 1.0, 41)  # quantiles 2.5 and 97.5 are the second and last but one
    found = likelihood(scores)
    assert found[-1] == 1.0
    assert found[1] / found[-2] == pytest.approx(1 / 5)


def test_rows_are_judged_each_by_its_own_spread() -> None:
    rows = np.array([[0.0, 1.0, 2.0], [0.0, 10.0, 20.0]])
    assert likelihood(rows)[0] == pytest.approx(likelihood(rows)[1])


def test_what_was_not_recalled_is_as_likely_as_the_worst() -> None:
    found = likelihood([0.0, -np.inf, 1.0, np.nan])
    assert found[1] == found[3] == found[0] < found[2] == 1.0


@pytest.mark.parametrize("row", [[0.4], [0.4, 0.4], [-np.inf, -np.inf], [math.nan, -np.inf]])
def test_a_row_without_spread_is_flat_and_says_nothing_on_stderr(row: list[float]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert likelihood([row]).tolist() == [[1.0] * len(row)]
        assert likelihood(row).tolist() == [1.0] * len(row)


def test_no_rows_and_no_places_have_no_likelihood() -> None:
    assert likelihood(np.zeros((0, 4))).shape == (0, 4)
    assert likelihood(np.zeros((3, 0))).shape == (3, 0)


def test_the_standard_verification_has_no_opinion() -> None:
    assert no_verification(None, None, []) is None  # type: ignore[arg-type]
