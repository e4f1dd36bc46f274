"""Keypoints: unit descriptors, none on a blank wall, the same ones from a shifted image."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.sensing.keypoints import keypoints, unit
from fpnav.sensing.thumbnails import patch_normalised, thumbnail


def texture(seed: int = 1) -> NDArray[np.uint8]:
    rng = np.random.default_rng(seed)
    blocks = rng.integers(0, 255, (24, 32, 3), dtype=np.uint8)
    return np.repeat(np.repeat(blocks, 10, axis=0), 10, axis=1)


def test_descriptors_have_length_one() -> None:
    points = keypoints(texture())
    assert 50 < len(points) <= 200
    assert np.linalg.norm(unit(points), axis=1) == pytest.approx(np.ones(len(points)))
    assert points["x"].max() <= 1.0


def test_a_blank_wall_has_no_keypoints() -> None:
    assert len(keypoints(np.full((240, 320, 3), 180, np.uint8))) == 0


def test_a_shifted_image_keeps_most_of_its_keypoints() -> None:
    image = texture()
    first = keypoints(image)
    second = keypoints(np.roll(image, 20, axis=1))
    likeness = (unit(first) @ unit(second).T).max(axis=1)
    assert np.mean(likeness > 0.95) > 0.5


def test_patches_of_a_thumbnail_have_mean_zero_and_deviation_one() -> None:
    small = patch_normalised(texture(), 64, 32, 8)
    patches = small.reshape(4, 8, 8, 8).transpose(0, 2, 1, 3).reshape(32, 64)
    assert patches.mean(axis=1) == pytest.approx(np.zeros(32), abs=1e-5)
    assert patches.std(axis=1) == pytest.approx(np.ones(32), abs=1e-4)


def test_a_flat_patch_is_zero_and_luminance_lies_between_nought_and_one() -> None:
    flat = np.full((60, 80, 3), 255, np.uint8)
    assert not patch_normalised(flat, 16, 8, 8).any()
    assert thumbnail(flat, 16, 8) == pytest.approx(np.ones((8, 16)))
