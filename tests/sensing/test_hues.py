"""Colour patches of an equal-angle strip."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.sensing.hues import BINS, hue_patches, hue_tallies


def bgr(hue_deg: float, saturation: float = 0.8, value: float = 0.7) -> tuple[int, int, int]:
    red, green, blue = colorsys.hsv_to_rgb(hue_deg / 360.0, saturation, value)
    return round(blue * 255), round(green * 255), round(red * 255)


def grey(width: int = 720) -> np.ndarray:
    return np.full((120, width, 3), 128, np.uint8)


@pytest.mark.parametrize("number", range(BINS))
def test_the_middle_of_every_bin_is_counted_in_it(number: int) -> None:
    image = grey()
    image[:, 100:140] = bgr(22.5 * (number + 0.5))
    tally = hue_tallies(image)
    assert tally[number, 100:140].min() == 120
    assert tally.sum() == 120 * 40


def test_the_papers_colours_are_orange_b_light_green_e_and_light_blue_i() -> None:
    for letter, hue_deg in (("B", 33.0), ("E", 100.0), ("I", 190.0)):
        image = grey()
        image[:, 100:140] = bgr(hue_deg)
        assert chr(ord("A") + hue_patches(image, circular=True).bins[0]) == letter


@pytest.mark.parametrize(
    "colour",
    [bgr(120.0, saturation=0.3), bgr(120.0, value=0.1), (0, 255, 0), (255, 255, 255)],
    ids=["pale", "dark", "overexposed", "white"],
)
def test_pale_dark_and_overexposed_pixels_have_no_hue(colour: tuple[int, int, int]) -> None:
    image = grey()
    image[:, 100:140] = colour
    assert hue_tallies(image).sum() == 0
    assert len(hue_patches(image, circular=True).bins) == 0


def test_a_patch_is_where_and_as_wide_as_the_colour() -> None:
    image = grey()
    image[:, 200:260] = bgr(210.0)
    found = hue_patches(image, circular=True)
    assert list(found.bins) == [9]
    assert found.columns[0] == pytest.approx(229.5, abs=0.1)
    assert found.widths[0] == pytest.approx(60.0, abs=6.0)
    assert found.certainty[0] == 1.0


def test_a_patch_over_the_seam_is_one() -> None:
    image = grey()
    image[:, :20] = image[:, -20:] = bgr(300.0)
    found = hue_patches(image, circular=True)
    assert len(found.bins) == 1
    assert found.columns[0] % 720 == pytest.approx(719.5, abs=0.1)


def test_the_same_patch_in_an_open_view_is_two() -> None:
    image = grey(120)
    image[:, :15] = image[:, -15:] = bgr(300.0)
    assert len(hue_patches(image, circular=False).bins) == 2


def test_slivers_are_dropped_and_walls_are_split() -> None:
    image = grey()
    image[:20, 100:101] = bgr(60.0)
    image[:, 300:500] = bgr(240.0)
    found = hue_patches(image, circular=True)
    assert set(found.bins) == {10}
    assert len(found.bins) == 2  # 100 degrees in two halves of 50
    assert np.diff(found.columns)[0] == pytest.approx(100.0, abs=5.0)


def test_a_view_full_of_one_hue_stands_out_nowhere() -> None:
    image = grey()
    image[...] = bgr(240.0)
    assert len(hue_patches(image, circular=True).bins) == 0


def test_a_lower_patch_is_less_certain() -> None:
    image = grey()
    image[:, 100:140] = bgr(240.0)
    image[:30, 400:440] = bgr(60.0)
    found = hue_patches(image, circular=True)
    assert list(found.bins) == [2, 10]
    assert found.certainty[1] == 1.0
    assert 0.3 <= found.certainty[0] < 0.8


@given(st.integers(0, 719))
def test_turning_the_view_turns_the_patches(shift: int) -> None:
    image = grey()
    image[:, 100:140], image[30:, 300:380] = bgr(30.0), bgr(200.0)
    before = hue_patches(image, circular=True)
    after = hue_patches(np.roll(image, shift, axis=1), circular=True)
    assert list(after.bins) == list(before.bins)
    assert np.allclose(after.columns % 720, (before.columns + shift) % 720, atol=1e-6)
    assert np.allclose(after.certainty, before.certainty)
