"""Stated certainty against how often features are seen again."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import small_world
from hypothesis import given
from hypothesis import strategies as st

from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.model import KNOTS, hand_made
from fpnav.systems.fingerprint.reliability import Sightings, fitted_curves, pooled, sightings
from fpnav.values import Signature

PARAMS = FingerprintParams(certainty="calibrated")


def run(count: int = 30) -> list[Signature]:
    system = Fingerprint(PARAMS)
    frames = small_world.route(count, ["panorama", "scan"])
    return list(system.assemble((one.reference, system.describe(one)) for one in frames))


@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.1, 5.0)), max_size=20))
def test_pooled_values_rise_and_keep_their_mean(rows: list[tuple[float, float]]) -> None:
    values, weights = np.array(rows).reshape(-1, 2).T
    found = pooled(values, weights)
    assert (np.diff(found) >= -1e-12).all()
    assert (found * weights).sum() == pytest.approx((values * weights).sum())


def test_values_that_rise_already_stay() -> None:
    assert pooled(np.array([0.1, 0.2, 0.9]), np.ones(3)).tolist() == [0.1, 0.2, 0.9]
    assert pooled(np.array([0.9, 0.1]), np.array([1.0, 3.0])).tolist() == pytest.approx([0.3, 0.3])


def test_a_curve_states_the_frequency_it_was_fitted_to() -> None:
    rng = np.random.default_rng(0)
    stated = rng.uniform(0.3, 1.0, 6000)
    again = rng.random(6000) < 0.2 + 0.5 * stated
    group = np.zeros(6000, np.int64)
    curves = fitted_curves(Sightings(stated, group, again), hand_made(PARAMS).curves)
    found = np.interp([0.4, 0.6, 0.9], *curves[0])
    assert found == pytest.approx([0.4, 0.5, 0.65], abs=0.05)
    assert np.array_equal(curves[1], hand_made(PARAMS).curves[1])


def test_too_few_sightings_change_nothing() -> None:
    few = Sightings(np.ones(5), np.zeros(5, np.int64), np.ones(5, bool))
    assert np.array_equal(fitted_curves(few, hand_made(PARAMS).curves), hand_made(PARAMS).curves)


def test_every_feature_is_followed_and_what_stays_is_seen_again() -> None:
    one = run(1)[0]
    aligner = Aligner(PARAMS, hand_made(PARAMS))
    found = sightings([one, one], aligner, np.array([[0, 1]]))
    assert len(found.stated) == len(one.parts["features"])
    assert found.again.all()
    assert set(found.group) <= {0, 1, 2}
    assert len(sightings([], aligner).stated) == 0


def test_fitting_brings_the_stated_probability_to_the_observed() -> None:
    signatures = run()
    memory = Fingerprint(PARAMS).memory()
    memory.fit(signatures)
    found = sightings(signatures, Aligner(PARAMS, hand_made(PARAMS)))
    stated = np.empty(len(found.stated))
    for group, (knots, values) in enumerate(memory.model.curves):
        same = found.group == group
        stated[same] = np.interp(found.stated[same], knots, values)
        assert stated[same].mean() == pytest.approx(found.again[same].mean(), abs=0.05)
    assert memory.model.evidence[3] == len(found.stated)
    assert memory.model.curves.shape == (3, 2, KNOTS)
