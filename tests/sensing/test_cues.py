"""Vertical edges of images drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.sensing.cues import SIZE_PX, EdgeRule, lengths, square_grey, vertical_cues

RULE = EdgeRule()


def blank(value: float = 0.5) -> NDArray[np.float32]:
    return np.full((SIZE_PX, SIZE_PX), value, np.float32)


def post(left: int, right: int, top: int, bottom: int, value: float = 0.1) -> NDArray[np.float32]:
    image = blank()
    image[top : bottom + 1, left : right + 1] = value
    return image


def test_a_dark_post_has_an_edge_to_dark_and_one_to_light() -> None:
    cues = vertical_cues(post(200, 229, 100, 299), RULE)
    assert cues["direction"].tolist() == [-1, 1]
    assert cues["x_px"] == pytest.approx([199.0, 229.0], abs=1.0)
    assert cues["top_px"] == pytest.approx([100.0, 100.0], abs=2.0)
    assert lengths(cues) == pytest.approx([200.0, 200.0], abs=4.0)
    assert np.isnan(cues["distance_m"]).all()
    assert (cues["facing"] == 0).all()


def test_a_light_post_is_the_other_way_round() -> None:
    cues = vertical_cues(post(200, 229, 100, 299, value=0.9), RULE)
    assert cues["direction"].tolist() == [1, -1]


def test_edges_come_from_left_to_right() -> None:
    image = np.minimum(post(300, 340, 50, 250), post(100, 140, 200, 400))
    assert (np.diff(vertical_cues(image, RULE)["x_px"]) > 0).all()


@pytest.mark.parametrize(("rows", "found"), [(58, 0), (62, 2)])
def test_an_edge_shorter_than_60_pixels_is_none(rows: int, found: int) -> None:
    cues = vertical_cues(post(200, 260, 100, 100 + rows - 1), RULE)
    assert len(cues) == found


def test_horizontal_edges_are_none() -> None:
    assert len(vertical_cues(post(0, SIZE_PX - 1, 200, 260), RULE)) == 0


def test_a_slanting_edge_is_none() -> None:
    image = blank()
    for row in range(SIZE_PX):
        image[row, 100 + row // 2 :] = 0.1
    assert len(vertical_cues(image, RULE)) == 0


def test_an_edge_that_leans_by_a_few_pixels_is_one_and_by_more_is_none() -> None:
    for lean, found in ((5, 1), (9, 0)):
        image = blank()
        for row in range(SIZE_PX):
            image[row, 200 + row * lean // SIZE_PX :] = 0.1
        assert len(vertical_cues(image, RULE)) == found


def test_a_gap_of_five_rows_is_bridged_and_a_longer_one_is_not() -> None:
    for gap, found in ((3, 2), (20, 4)):
        image = post(200, 260, 100, 299)
        image[200 : 200 + gap, 200:261] = 0.5
        assert len(vertical_cues(image, RULE)) == found


def test_a_blank_image_has_no_edges() -> None:
    assert len(vertical_cues(blank(), RULE)) == 0


def test_the_grain_of_a_blank_wall_is_an_edge_only_without_a_floor() -> None:
    image = blank()
    image[100:300, 240:] += 0.01
    assert len(vertical_cues(image, RULE)) == 1
    assert len(vertical_cues(image, EdgeRule(floor=0.03))) == 0


def test_the_strength_is_that_of_the_sobel_kernel() -> None:
    cues = vertical_cues(post(200, 260, 100, 299, value=0.3), RULE)
    assert cues["strength"] == pytest.approx([0.8, 0.8], rel=0.05)


def test_images_of_any_size_become_square_and_grey() -> None:
    pixels = np.zeros((384, 512, 3), np.uint8)
    pixels[:, 256:] = (255, 255, 255)
    grey = square_grey(pixels)
    assert grey.shape == (480, 480)
    assert grey.dtype == np.float32
    assert (grey.min(), grey.max()) == pytest.approx((0.0, 1.0))
    cues = vertical_cues(grey, RULE)
    assert cues["x_px"] == pytest.approx([239.5], abs=1.0)
    assert lengths(cues)[0] >= 476
