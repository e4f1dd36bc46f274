"""The product rule on the paper's own numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.systems.gateway.bayes import (
    LEAST,
    log_evidence,
    normalised,
    posterior,
    vision_likelihood,
)

SONAR_B = [0.02, 0.31, 0.31, 0.31, 0.06, 0.0, 0.0]
SONAR_E = [0.06, 0.11, 0.11, 0.11, 0.61, 0.0, 0.0]
EVEN = [1.0] * 7


def test_match_percentages_become_the_likelihoods_of_the_paper() -> None:
    found = vision_likelihood([0.25, 0.90, 0.75], 0.10)
    assert found == pytest.approx([0.25 / 1.9, 0.90 / 1.9, 0.75 / 1.9])
    # The paper prints .3947 as .40, so that its row adds up to one.
    assert found == pytest.approx([0.13, 0.47, 0.40], abs=0.0055)


def test_no_match_at_all_counts_a_tenth() -> None:
    assert vision_likelihood([0.0, 0.4], 0.10) == pytest.approx([0.2, 0.8])


def test_the_misread_gateway_is_corrected_as_in_the_paper() -> None:
    """D seen as a right room: .11 against .61 by sonar becomes .42 against .25."""
    vision = vision_likelihood([0.0, 0.28, 0.28, 0.93, 0.0, 0.0, 0.0], 0.10)
    found = posterior(EVEN, vision, SONAR_E)
    assert found[3] / found[4] == pytest.approx(0.42 / 0.25, abs=0.01)
    assert np.argmax(found) == 3
    assert np.argmax(SONAR_E) == 4


def test_exactly_the_papers_posterior_from_likelihoods_that_give_it() -> None:
    target = np.array([0.06, 0.13, 0.14, 0.42, 0.25, 0.0, 0.0])
    vision = normalised(np.divide(target, SONAR_E, out=np.zeros(7), where=target > 0))
    assert posterior(EVEN, vision, SONAR_E) == pytest.approx(target / target.sum())
    assert posterior(EVEN, vision, SONAR_E)[3:5] == pytest.approx([0.42, 0.25])
    assert vision[3] / vision[4] == pytest.approx(9.3, abs=0.05)


def test_a_plain_match_of_a_gives_the_papers_95_percent() -> None:
    vision = [0.4, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]
    sonar = [0.82, 0.04, 0.04, 0.04, 0.04, 0.0, 0.0]
    assert posterior(EVEN, vision, sonar)[0] == pytest.approx(0.95, abs=0.005)


def test_places_sonar_cannot_tell_are_told_by_sight() -> None:
    vision = vision_likelihood([0.1, 0.8, 0.4, 0.3, 0.2, 0.2, 0.5], 0.10)
    found = posterior(EVEN, vision, SONAR_B)
    assert np.argmax(found) == 1
    assert found[5] == found[6] == 0.0


def test_evidence_is_weighed_equally_and_the_prior_too() -> None:
    one, other = [0.2, 0.8], [0.7, 0.3]
    assert posterior([1, 1], one, other) == pytest.approx(posterior([1, 1], other, one))
    assert posterior(one, [1, 1], other) == pytest.approx(posterior([1, 1], one, other))


def test_evidence_for_nothing_is_even_and_zero_has_a_logarithm() -> None:
    assert normalised([0.0, 0.0]) == pytest.approx([0.5, 0.5])
    assert normalised(np.zeros((2, 0))).shape == (2, 0)
    assert log_evidence([0.0, 1.0]) == pytest.approx([math.log(LEAST), 0.0])
