"""Focus points: the filter's closed forms, strict maxima, greedy spacing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.sensing.focus import DogFilter, Region, focus_points, local_maxima

WHOLE = Region(0, 100, 0, 50)


def spikes(points: dict[tuple[int, int], float], shape: tuple[int, int] = (50, 100)) -> np.ndarray:
    image = np.zeros(shape, np.float32)
    for (x, y), height in points.items():
        image[y, x] = height
    return image


def test_the_centre_of_the_mask_is_the_difference_of_the_peaks() -> None:
    dog = DogFilter.of_size(3.0, 4.0, 15, half=True)
    mask = dog.mask()
    assert mask.shape == (29, 29)
    assert mask[14, 14] == pytest.approx(1 / (2 * math.pi * 9) - 1 / (2 * math.pi * 16))


def test_the_mask_is_the_formula_at_every_distance() -> None:
    dog = DogFilter.of_size(1.0, 2.0, 5, half=True)
    y, x = np.mgrid[-4:5, -4:5]
    d2 = x**2 + y**2
    wanted = np.exp(-d2 / 2) / (2 * math.pi) - np.exp(-d2 / 8) / (8 * math.pi)
    assert dog.mask() == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("sigmas", "size", "half", "rest"),
    [((3, 4), 15, True, 0.0006), ((3, 4), 15, False, 0.093), ((1, 2), 5, True, 0.045)],
)
def test_half_size_leaves_next_to_no_response_to_brightness(
    sigmas: tuple[float, float], size: int, half: bool, rest: float
) -> None:
    dog = DogFilter.of_size(*sigmas, size, half=half)
    assert dog.mask().sum() == pytest.approx(rest, rel=0.1)


def test_the_reach_is_half_the_size_less_one() -> None:
    reaches = [DogFilter.of_size(1.0, 2.0, size, half=True).reach_px for size in (15, 10, 5, 3)]
    assert reaches == [6, 4, 1, 1]


def test_the_response_is_the_image_correlated_with_the_mask() -> None:
    dog = DogFilter.of_size(1.0, 2.0, 4, half=True)
    found = dog.response(spikes({(20, 25): 1.0}))
    assert found[22:29, 17:24] == pytest.approx(dog.mask(), abs=1e-7)


def test_a_maximum_must_be_above_zero_and_above_all_around() -> None:
    image = spikes({(10, 10): 1.0, (40, 10): 1.0, (42, 10): 1.0, (70, 10): -1.0})
    assert local_maxima(image, 3, WHOLE).tolist() == [[10, 10]]
    assert local_maxima(image, 1, WHOLE).tolist() == [[10, 10], [40, 10], [42, 10]]


def test_maxima_at_the_image_corner_count() -> None:
    assert local_maxima(spikes({(0, 0): 1.0, (99, 49): 2.0}), 3, WHOLE).tolist() == [
        [0, 0],
        [99, 49],
    ]


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_maxima_are_those_a_plain_loop_finds(seed: int, reach: int) -> None:
    image = np.random.default_rng(seed).integers(-2, 4, (12, 15)).astype(np.float32)
    wanted = []
    for y in range(12):
        for x in range(15):
            window = image[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1]
            if image[y, x] > 0 and (window >= image[y, x]).sum() == 1:
                wanted.append([x, y])
    assert local_maxima(image, reach, Region(0, 15, 0, 12)).tolist() == wanted


def test_points_come_strongest_first_within_the_region() -> None:
    image = spikes({(10, 10): 1.0, (50, 20): 3.0, (80, 30): 2.0, (50, 48): 9.0})
    points, strength = focus_points(image, 2, 2, Region(0, 100, 5, 40), 0.0)
    assert points.tolist() == [[50, 20], [80, 30]]
    assert strength.tolist() == [3.0, 2.0]


def test_a_weaker_point_too_near_a_stronger_one_is_left_out() -> None:
    image = spikes({(10, 10): 3.0, (16, 10): 2.0, (22, 10): 1.0})
    points, _ = focus_points(image, 2, 9, WHOLE, 10.0)
    assert points.tolist() == [[10, 10], [22, 10]]


def test_points_at_the_exact_spacing_are_both_kept() -> None:
    image = spikes({(10, 10): 3.0, (16, 18): 2.0})
    points, _ = focus_points(image, 2, 9, WHOLE, 10.0)
    assert len(points) == 2


def test_shut_columns_hold_no_point() -> None:
    image = spikes({(10, 10): 3.0, (50, 10): 2.0})
    shut = np.arange(100) < 20
    points, _ = focus_points(image, 2, 9, Region(0, 100, 0, 50, shut=shut), 5.0)
    assert points.tolist() == [[50, 10]]


def test_spacing_reaches_around_a_panorama() -> None:
    image = spikes({(1, 10): 3.0, (98, 10): 2.0})
    around, _ = focus_points(image, 2, 9, Region(0, 100, 0, 50, period_px=100), 5.0)
    flat, _ = focus_points(image, 2, 9, WHOLE, 5.0)
    assert (len(around), len(flat)) == (1, 2)


def test_an_empty_response_has_no_points() -> None:
    points, strength = focus_points(spikes({}), 2, 9, WHOLE, 5.0)
    assert points.shape == (0, 2)
    assert strength.shape == (0,)
