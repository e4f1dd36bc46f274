"""Score tables and packing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.scoring import (
    cut_open,
    is_open,
    score_table,
    sigma_table,
    strings_of,
    type_weights,
    visible_table,
)
from fpnav.systems.fingerprint.symbols import ALPHABET, C, F, N, V, parse, text

TAU = 2.0 * math.pi


def test_sigma_is_symmetric_with_ones_for_equals() -> None:
    sigma = sigma_table()
    assert np.array_equal(sigma, sigma.T)
    assert (np.diag(sigma) == 1.0).all()
    assert np.abs(sigma).max() == 1.0


def test_hues_are_alike_around_the_circle() -> None:
    sigma = sigma_table()
    assert sigma[0, [15, 1, 2, 14, 3, 8]].tolist() == [0.5, 0.5, 0.0, 0.0, -1.0, -1.0]


def test_a_correspondence_asserts_a_corner_and_an_edge() -> None:
    sigma = sigma_table()
    assert (sigma[V, F], sigma[C, F], sigma[V, C], sigma[V, N], sigma[F, N]) == (
        0.4, 0.4, -0.5, -1.0, -1.0,
    )  # fmt: skip


def test_weights_and_gaps_are_the_parameters() -> None:
    params = FingerprintParams(weight_v=0.9, weight_c=0.8, weight_f=0.7, weight_n=0.2, gamma=0.6)
    weights = type_weights(params)
    assert weights[[0, V, C, F, N]].tolist() == [1.0, 0.9, 0.8, 0.7, 0.2]
    assert (score_table(params).gap == 0.6).all()


def test_each_sensor_sees_its_own_symbols() -> None:
    seen = visible_table()  # columns: none, laser, camera, both
    assert seen[C].tolist() == [False, True, False, True]
    assert seen[V].tolist() == seen[0].tolist() == [False, False, True, True]
    assert seen[F].tolist() == [False, False, False, True]
    assert seen[N].tolist() == [False, True, True, True]
    assert seen.shape == (len(ALPHABET), 4)


@pytest.mark.parametrize(
    ("laser", "camera", "expected"), [(TAU, 0.0, False), (3.0, 1.0, True), (3.0, TAU, False)]
)
def test_a_view_is_open_where_no_sensor_sees_all_round(
    laser: float, camera: float, expected: bool
) -> None:
    assert is_open(np.array([[0.0, laser], [0.0, camera]])) is expected


def test_an_open_view_starts_at_its_right_edge() -> None:
    rows = parse("vcAB")
    rows["angle_rad"] = np.radians([0.0, 60.0, 300.0, 330.0])
    half = np.array([[0.0, math.pi], [0.0, 0.0]])
    assert text(cut_open(rows, half)) == "ABvc"
    assert text(cut_open(rows, np.array([[0.0, TAU], [0.0, 0.0]]))) == "vcAB"
    rear = np.array([[math.pi, math.pi], [0.0, 0.0]])
    rows["angle_rad"] = np.radians([100.0, 170.0, 190.0, 260.0])
    assert text(cut_open(rows, rear)) == "vcAB"


def test_packed_weights_are_type_times_certainty() -> None:
    half = np.array([[0.0, math.pi], [0.0, 0.0]])
    weights = type_weights(FingerprintParams())
    packed = strings_of([parse("vn", 0.5), parse("")], [half, half], weights, "view")
    assert packed.weights == pytest.approx([0.5, 0.15], abs=1e-4)
    assert packed.lengths.tolist() == [2, 0]
    assert packed.fixed.all()
    assert not strings_of([parse("v")], [half], weights, "all").fixed.any()
    assert len(strings_of([], [], weights, "all")) == 0
