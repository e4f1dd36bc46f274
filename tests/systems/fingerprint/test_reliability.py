"""Stated certainty against how often features are seen again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import small_world
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fpnav.evaluation.calibration import calibration_error, skill
from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.fitting import fitted, following_rule
from fpnav.systems.fingerprint.following import counted
from fpnav.systems.fingerprint.model import KNOTS, hand_made
from fpnav.systems.fingerprint.presence import COLUMNS, probability
from fpnav.systems.fingerprint.record import record_of
from fpnav.systems.fingerprint.reliability import (
    Sightings,
    by_alignment,
    by_odometry,
    by_truth,
    calibrated,
    pooled,
    sightings,
)
from fpnav.systems.fingerprint.symbols import features_of
from fpnav.values import FloatArray, Pose2, Reference, Signature

PARAMS = FingerprintParams(certainty="calibrated")
RAW = hand_made(PARAMS)


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


def found_of(evidence: FloatArray, group: NDArray[np.int64], again: NDArray[np.bool_]) -> Sightings:
    return Sightings(evidence[:, 0], evidence, group, again)


def test_a_model_states_the_frequency_it_was_fitted_to() -> None:
    rng = np.random.default_rng(0)
    evidence = np.zeros((6000, len(COLUMNS)))
    evidence[:, 0] = rng.uniform(0.3, 1.0, 6000)
    again = rng.random(6000) < 0.2 + 0.5 * evidence[:, 0]
    model = calibrated(RAW, found_of(evidence, np.zeros(6000, np.int64), again))
    asked = features_of(np.full(3, b"v"), np.zeros(3), np.array([0.4, 0.6, 0.9]))
    evidence = np.zeros((3, len(COLUMNS)))
    evidence[:, 0] = asked["certainty"]
    stated = np.interp(probability(evidence, model.lean[0]), *model.curves[0])
    assert stated == pytest.approx([0.4, 0.5, 0.65], abs=0.05)
    assert np.array_equal(model.curves[1], RAW.curves[1])
    assert not model.lean[1].any()


def test_too_few_sightings_change_nothing() -> None:
    few = found_of(np.ones((5, len(COLUMNS))), np.zeros(5, np.int64), np.ones(5, bool))
    model = calibrated(RAW, few)
    assert np.array_equal(model.curves, RAW.curves)
    assert not model.lean.any()


def test_every_feature_is_followed_and_what_stays_is_seen_again() -> None:
    one = run(1)[0]
    for rule in (by_alignment(Aligner(PARAMS, RAW)), by_odometry, by_truth):
        found = sightings([one, one], RAW, rule, np.array([[0, 1]]))
        assert len(found.stated) == len(found.evidence) == len(one.parts["features"])
        assert found.again.all()
        assert set(found.group) <= {0, 1, 2}
        assert len(sightings([], RAW, rule).stated) == 0


def test_nothing_is_seen_again_where_no_pose_is_known() -> None:
    one = run(1)[0]
    lost = replace(one, reference=replace(one.reference, odometry=None))
    assert not sightings([one, lost], RAW, by_odometry, np.array([[0, 1]])).again.any()
    assert sightings([one, lost], RAW, by_truth, np.array([[0, 1]])).again.all()


def test_a_run_is_followed_by_odometry_and_where_it_has_none_by_the_alignment() -> None:
    signatures = run(2)
    aligner = Aligner(PARAMS, RAW)
    assert following_rule(signatures, aligner) is by_odometry
    lost = [replace(one, reference=replace(one.reference, odometry=None)) for one in signatures]
    assert following_rule(lost, aligner) is not by_odometry
    assert following_rule(lost, aligner)(lost[0], lost[0]).all()


def test_fitting_brings_the_stated_probability_to_the_observed() -> None:
    signatures = run()
    memory = Fingerprint(PARAMS).memory()
    memory.fit(signatures)
    found = sightings(signatures, memory.model, by_odometry)
    for group in range(3):
        same = found.group == group
        assert found.stated[same].mean() == pytest.approx(found.again[same].mean(), abs=0.05)
    assert memory.model.evidence[3] == len(found.stated)
    assert memory.model.curves.shape == (3, 2, KNOTS)
    assert memory.model.lean.shape == (3, len(COLUMNS) + 1)


STEADY, FLICKERING = 0.95, 0.3


def flickering(seed: int, count: int = 160) -> list[Signature]:
    """A hall whose corners are always there, and whose edges of equal looks are seen each time
    with the one probability or the other, by turns along the walls."""
    rng = np.random.default_rng(seed)
    corners = np.array([[x, y] for x in np.arange(-6.0, 32.0, 2.0) for y in (-4.0, 4.0)])
    edges = np.array([[x + 0.7, y] for x in np.arange(-6.0, 32.0, 1.0) for y in (-4.0, 4.0)])
    share = np.where(np.arange(len(edges)) % 4 < 2, STEADY, FLICKERING)
    frames = []
    for at in range(count):
        pose = Pose2(0.15 * at, 0.0, 0.0)
        points = np.concatenate([corners, edges[rng.random(len(edges)) < share]])
        offset = points - [pose.x_m, pose.y_m]
        letters = np.where(np.arange(len(points)) < len(corners), b"c", b"v")
        near = np.hypot(*offset.T) < 7.0
        rows = features_of(
            letters[near], np.arctan2(*offset[near].T[::-1]), np.full(near.sum(), 0.6)
        )
        rows["range_m"] = np.where(rows["type"] == b"c", np.hypot(*offset[near].T), np.nan)
        rows = rows[np.lexsort((rows["type"], rows["angle_rad"]))]
        reference = Reference(at, at, 0, 0.15 * at, pose, pose)
        frames.append((reference, {"features": rows}))
    record = record_of(np.array([[0.0, 6.3], [0.0, 6.3]]), b"")
    return [Signature(ref, record, {"features": one["features"]}) for ref, one in counted(frames)]


def test_what_was_seen_before_tells_steady_features_from_flickering_ones() -> None:
    model = fitted(flickering(1), PARAMS)
    found = {one: sightings(flickering(2), one, by_truth) for one in (model, RAW)}
    edges = found[model].group == 0
    again = found[model].again[edges]
    stated, raw = (found[one].stated[edges] for one in (model, RAW))
    constant = np.full(len(again), again.mean())
    assert calibration_error(stated, again) <= 0.05
    assert skill(constant, again) == pytest.approx(0.0)
    assert skill(raw, again) <= 0.0
    assert skill(stated, again) > 0.2
    assert stated.min() < 0.5
    assert stated.max() > 0.85
