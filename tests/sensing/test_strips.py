"""Strips of images: attributes, circles, and what light does not change."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.sensing.strips import (
    COLOUR,
    EDGES,
    SHAPE,
    STRIP_PX,
    TONE,
    WIDTH,
    colour_bins,
    gradient_cells,
    strips_of,
)


def scene(width: int = 256, height: int = 64) -> NDArray[np.uint8]:
    rng = np.random.default_rng(3)
    blocks = rng.integers(40, 160, (height // 8, width // 16, 3), dtype=np.uint8)
    return np.repeat(np.repeat(blocks, 8, axis=0), 16, axis=1)


def test_a_strip_has_all_its_attributes() -> None:
    found = strips_of(scene(), 32, circular=False)
    assert found.shape == (32, WIDTH)
    assert np.isfinite(found).all()


def test_turning_a_panorama_turns_its_strips() -> None:
    image = scene(90 * STRIP_PX, 64)
    turned = np.roll(image, 7 * STRIP_PX, axis=1)
    first = strips_of(image, 90, circular=True)
    second = strips_of(turned, 90, circular=True)
    assert np.roll(first, 7, axis=0) == pytest.approx(second, abs=1e-4)


def test_brighter_light_leaves_edges_and_grey_patches_as_they_are() -> None:
    image = scene()
    bright = np.clip(image * 1.5, 0, 255).astype(np.uint8)
    dim, lit = (strips_of(one, 32, circular=False) for one in (image, bright))
    other = strips_of(scene()[:, ::-1], 32, circular=False)
    for kind in (EDGES, SHAPE, TONE):
        assert np.abs(dim - lit)[:, kind].mean() < 0.15 * np.abs(dim - other)[:, kind].mean()


def test_hue_and_grey_shares_sum_to_one_in_each_half() -> None:
    shares = np.square(strips_of(scene(), 32, circular=False)[:, COLOUR])
    assert shares.sum(axis=1) == pytest.approx(np.ones(32), abs=1e-5)


def test_a_grey_pixel_has_no_hue_and_a_red_one_no_grey() -> None:
    pixels = np.array([[[120, 120, 120], [0, 0, 255]]], np.uint8)
    bins = colour_bins(pixels)
    assert bins[0, 0, :10].sum() == pytest.approx(0.0)
    assert bins[0, 1, 0] == pytest.approx(1.0)


def test_a_vertical_edge_falls_in_the_bins_of_a_horizontal_gradient() -> None:
    grey = np.zeros((16, 16), np.float32)
    grey[:, 8:] = 1.0
    cells = gradient_cells(grey, circular=False).sum(axis=(0, 1))
    assert cells[0] == pytest.approx(cells[-1])
    assert cells[[0, -1]].sum() == pytest.approx(cells.sum())


def test_an_image_of_one_colour_is_survived() -> None:
    flat = np.full((25, 120, 3), 90, np.uint8)
    assert np.isfinite(strips_of(flat, 90, circular=True)).all()
