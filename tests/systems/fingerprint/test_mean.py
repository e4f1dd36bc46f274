"""The mean fingerprint."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.systems.fingerprint.mean import FuseRule, Mean, fuse, strongest
from fpnav.systems.fingerprint.symbols import features_of

TAU = 2.0 * math.pi
ROUND = np.array([[0.0, TAU], [0.0, TAU]])
RULE = FuseRule(math.radians(2.0), settle=4, certainty_min=0.15, features_max=60)


def features(*rows: tuple[str, float, float]) -> np.ndarray:
    letters = np.array([letter for letter, _, _ in rows], dtype="S1")
    degrees = np.array([angle for _, angle, _ in rows], dtype=float)
    return features_of(letters, np.radians(degrees), np.array([u for _, _, u in rows], dtype=float))


def matched(*pairs: tuple[int, int]) -> np.ndarray:
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def degrees(mean: Mean) -> np.ndarray:
    return np.degrees(mean.features["angle_rad"])


@given(st.integers(1, 9), st.floats(-3.0, 3.0))
def test_seeing_the_same_again_changes_neither_angles_nor_certainty(n: int, turn: float) -> None:
    own = features(("c", 10.0, 0.9), ("v", 100.0, 0.5), ("B", 200.0, 0.7))
    seen = own.copy()
    seen["angle_rad"] = np.mod(seen["angle_rad"] - turn, TAU)
    mean = fuse(Mean(own, ROUND, n), seen, ROUND, matched((0, 0), (1, 1), (2, 2)), turn, RULE)
    assert degrees(mean) == pytest.approx([10.0, 100.0, 200.0])
    assert mean.features["certainty"] == pytest.approx([0.9, 0.5, 0.7])
    assert mean.features["seen"].tolist() == [2, 2, 2]
    assert mean.observations == n + 1


def test_matched_features_meet_by_evidence() -> None:
    mean = Mean(features(("v", 10.0, 0.6)), ROUND, 2)
    found = fuse(mean, features(("v", 16.0, 0.6)), ROUND, matched((0, 0)), 0.0, RULE)
    assert degrees(found) == pytest.approx([12.0])
    assert found.features["certainty"] == pytest.approx([0.6])


def test_angles_meet_across_the_heading() -> None:
    mean = Mean(features(("v", 358.0, 0.5)), ROUND, 1)
    found = fuse(mean, features(("v", 4.0, 0.5)), ROUND, matched((0, 0)), 0.0, RULE)
    assert degrees(found) == pytest.approx([1.0])


def test_what_is_missed_fades_and_what_is_new_starts_low() -> None:
    mean = Mean(features(("c", 10.0, 0.8)), ROUND, 3)
    found = fuse(mean, features(("v", 90.0, 0.8)), ROUND, matched(), 0.0, RULE)
    assert found.features["certainty"] == pytest.approx([0.8 * 3 / 4, 0.8 / 4])


def test_certainty_becomes_the_frequency_of_being_seen() -> None:
    mean = Mean(features(("c", 10.0, 1.0), ("v", 90.0, 1.0)), ROUND, 1)
    for seen in (True, False, True, False, False):
        rows = features(("c", 10.0, 1.0), ("v", 90.0, 1.0)) if seen else features(("c", 10.0, 1.0))
        pairs = matched((0, 0), (1, 1)) if seen else matched((0, 0))
        mean = fuse(mean, rows, ROUND, pairs, 0.0, RULE)
    assert mean.features["certainty"] == pytest.approx([1.0, 3.0 / 6.0])


def test_what_no_sensor_covered_does_not_fade() -> None:
    ahead = np.array([[0.0, math.pi], [0.0, TAU]])
    mean = Mean(features(("c", 10.0, 0.8), ("c", 180.0, 0.8), ("v", 181.0, 0.8)), ROUND, 1)
    found = fuse(mean, features(), ahead, matched(), 0.0, RULE)
    assert found.features["certainty"] == pytest.approx([0.4, 0.8, 0.4])


def test_of_two_hues_the_one_with_more_evidence_stays() -> None:
    mean = Mean(features(("A", 10.0, 0.5)), ROUND, 3)
    for certainty, expected in ((0.9, b"A"), (1.0, b"A")):
        found = fuse(mean, features(("B", 10.0, certainty)), ROUND, matched((0, 0)), 0.0, RULE)
        assert found.features["type"].tolist() == [expected]
    weak = Mean(features(("A", 10.0, 0.3)), ROUND, 1)
    found = fuse(weak, features(("B", 10.0, 0.9)), ROUND, matched((0, 0)), 0.0, RULE)
    assert found.features["type"].tolist() == [b"B"]


def test_neighbours_of_one_type_become_one_and_keep_their_evidence() -> None:
    mean = Mean(features(("c", 10.0, 0.8), ("v", 10.5, 0.8)), ROUND, 1)
    found = fuse(mean, features(("c", 11.5, 0.6)), ROUND, matched(), 0.0, RULE)
    assert found.features["type"].tolist() == [b"v", b"c"]
    assert found.features["certainty"] == pytest.approx([0.4, 0.7])
    assert 10.0 < degrees(found)[1] < 11.5


def test_neighbours_across_the_heading_become_one() -> None:
    mean = Mean(features(("c", 359.5, 0.5), ("c", 0.5, 0.5)), ROUND, 1)
    found = fuse(mean, features(), ROUND, matched(), 0.0, RULE)
    assert len(found.features) == 1
    assert degrees(found)[0] % 360.0 == pytest.approx(0.0, abs=1e-6)


def test_faint_features_are_forgotten_once_the_mean_has_settled() -> None:
    row = features(("c", 10.0, 0.9), ("v", 90.0, 0.16))
    young = fuse(Mean(row, ROUND, 3), features(("c", 10.0, 0.9)), ROUND, matched((0, 0)), 0.0, RULE)
    assert len(young.features) == 2
    old = fuse(Mean(row, ROUND, 4), features(("c", 10.0, 0.9)), ROUND, matched((0, 0)), 0.0, RULE)
    assert old.features["type"].tolist() == [b"c"]


def test_the_most_certain_features_are_kept_in_their_order() -> None:
    rule = FuseRule(0.01, 4, 0.0, features_max=2)
    rows = features(("c", 10.0, 0.9), ("v", 50.0, 0.2), ("B", 90.0, 0.8))
    found = fuse(Mean(rows, ROUND, 1), rows, ROUND, matched((0, 0), (1, 1), (2, 2)), 0.0, rule)
    assert found.features["type"].tolist() == [b"c", b"B"]
    assert strongest(found, 1).features["type"].tolist() == [b"c"]
    assert len(strongest(found, 5).features) == 2


@pytest.mark.parametrize(
    ("first", "second", "turn", "expected"),
    [
        ((0.0, 2.0), (0.0, 2.0), 0.0, (0.0, 2.0)),
        ((0.0, 2.0), (0.0, 2.0), 1.0, (0.5, 3.0)),
        ((0.0, 0.0), (0.3, 2.0), 1.0, (1.3, 2.0)),
        ((0.0, 2.0), (0.0, 0.0), 1.0, (0.0, 2.0)),
        ((0.0, TAU), (0.0, 1.0), 2.0, (0.0, TAU)),
        ((3.0, 1.0), (-3.0, 1.0), 0.0, (math.pi, TAU - 5.0)),
        ((0.0, 3.5), (0.0, 3.5), 3.0, (0.0, TAU)),
    ],
)
def test_the_mean_covers_what_any_observation_covered(
    first: tuple[float, float],
    second: tuple[float, float],
    turn: float,
    expected: tuple[float, float],
) -> None:
    mean = Mean(features(), np.array([first, (0.0, 0.0)]), 1)
    found = fuse(mean, features(), np.array([second, (0.0, 0.0)]), matched(), turn, RULE)
    assert found.arcs[0, 1] == pytest.approx(expected[1])
    off = (found.arcs[0, 0] - expected[0] + math.pi) % TAU - math.pi
    assert off == pytest.approx(0.0, abs=1e-9)


def test_fusing_two_means_weighs_them_by_their_observations() -> None:
    mean = Mean(features(("c", 10.0, 0.9)), ROUND, 6)
    found = fuse(
        mean, features(("c", 10.0, 0.3)), ROUND, matched((0, 0)), 0.0, RULE, observations=2
    )
    assert found.features["certainty"] == pytest.approx([(6 * 0.9 + 2 * 0.3) / 8])
    assert found.observations == 8
