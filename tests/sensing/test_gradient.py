"""The Deriche pair against its closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.sensing.gradient import deriche_kernels, deriche_radius, gradient_magnitude

ALPHAS = (0.5, 0.8, 1.0, 2.0)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_smoothing_sums_to_one_and_is_even(alpha: float) -> None:
    smooth, _ = deriche_kernels(alpha)
    assert smooth.sum() == pytest.approx(1.0, abs=1e-12)
    assert smooth == pytest.approx(smooth[::-1])


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_kernels_are_the_analytic_pair_but_for_the_tail(alpha: float) -> None:
    smooth, derivative = deriche_kernels(alpha)
    n = np.arange(-deriche_radius(alpha), deriche_radius(alpha) + 1)
    a = np.exp(-alpha)
    k = (1 - a) ** 2 / (1 + 2 * alpha * a - a**2)
    assert smooth == pytest.approx(k * (alpha * abs(n) + 1) * a ** abs(n), abs=1e-4)
    assert derivative == pytest.approx((1 - a) ** 2 / a * n * a ** abs(n), abs=1e-4)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_a_unit_step_gives_one(alpha: float) -> None:
    _, derivative = deriche_kernels(alpha)
    step = np.where(np.arange(len(derivative)) >= len(derivative) // 2, 1.0, 0.0)
    assert derivative @ step == pytest.approx(1.0, abs=1e-12)


def test_radii_are_those_the_tail_asks_for() -> None:
    assert (deriche_radius(0.8), deriche_radius(1.0)) == (15, 12)


@given(st.integers(0, 255))
def test_a_constant_image_has_no_gradient(level: int) -> None:
    image = np.full((12, 20), level, np.uint8)
    assert not gradient_magnitude(image, 1.0).any()


def test_the_magnitude_peaks_at_an_edge_and_stays_within_one() -> None:
    image = np.zeros((40, 60), np.uint8)
    image[:, 30:] = 200
    found = gradient_magnitude(image, 1.0)
    assert found.max() == 1.0
    assert found.min() >= 0.0
    assert set(np.unique(found.argmax(axis=1))) <= {29, 30}


def test_it_is_the_same_for_an_image_twice_as_bright() -> None:
    rng = np.random.default_rng(1)
    image = rng.integers(0, 120, (30, 40)).astype(np.uint8)
    assert gradient_magnitude(2 * image, 0.8) == pytest.approx(
        gradient_magnitude(image, 0.8), abs=1e-5
    )


def test_repeated_columns_do_not_change_the_scale() -> None:
    rng = np.random.default_rng(2)
    image = rng.integers(0, 255, (30, 80)).astype(np.uint8)
    padded = np.hstack([image[:, -20:], image, image[:, :20]])
    rolled = np.roll(image, 7, axis=1)
    again = np.hstack([rolled[:, -20:], rolled, rolled[:, :20]])
    first = gradient_magnitude(padded, 1.0, 20)[:, 20:-20]
    second = gradient_magnitude(again, 1.0, 20)[:, 20:-20]
    assert np.roll(first, 7, axis=1) == pytest.approx(second, abs=1e-4)
