"""Log-polar views against OpenCV's own resampling and closed forms."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from fpnav.sensing.logpolar import local_views, sample_offsets, standardised


def textured(height: int = 120, width: int = 160) -> np.ndarray:
    rng = np.random.default_rng(3)
    return cv2.GaussianBlur(rng.integers(0, 255, (height, width)).astype(np.uint8), (9, 9), 2.0)


def test_radii_grow_from_the_centre_by_equal_factors() -> None:
    across, down = sample_offsets(40.0, 16, 8)
    assert across[0] == pytest.approx(40.0 ** (np.arange(16) / 16) - 1.0)
    assert down[0] == pytest.approx(np.zeros(16), abs=1e-12)
    assert np.hypot(across, down).max() < 40.0


def test_rows_are_angles_from_the_x_axis_downwards() -> None:
    across, down = sample_offsets(10.0, 4, 4)
    assert np.arctan2(down[:, -1], across[:, -1]) == pytest.approx(
        [0.0, np.pi / 2, np.pi, -np.pi / 2]
    )


@pytest.mark.parametrize(("radius", "columns", "rows"), [(40.0, 32, 32), (20.0, 16, 16)])
def test_a_view_is_what_warp_polar_makes(radius: float, columns: int, rows: int) -> None:
    image = textured()
    points = np.array([[60, 60], [91, 55]])
    views = local_views(image, points, radius, columns, rows)
    how = cv2.INTER_LINEAR | cv2.WARP_FILL_OUTLIERS | cv2.WARP_POLAR_LOG
    for view, (x, y) in zip(views, points, strict=True):
        wanted = cv2.warpPolar(image, (columns, rows), (float(x), float(y)), radius, how)
        apart = np.abs(view.reshape(rows, columns).astype(int) - wanted)
        assert apart.max() <= 1


def test_no_points_give_no_views() -> None:
    assert local_views(textured(), np.zeros((0, 2), np.int64), 20.0, 16, 8).shape == (0, 128)


def test_a_disc_over_the_border_repeats_the_border() -> None:
    image = np.full((30, 30), 77, np.uint8)
    assert (local_views(image, np.array([[0, 29]]), 20.0, 16, 16) == 77).all()


def test_standardised_views_forget_brightness_and_contrast() -> None:
    rng = np.random.default_rng(4)
    view = rng.integers(20, 100, (3, 64))
    assert np.abs(standardised(view).astype(int) - standardised(2 * view + 30)).max() <= 1


def test_standardised_views_span_five_standard_deviations() -> None:
    view = np.array([[0.0] * 50 + [100.0] * 50])
    assert sorted(set(standardised(view)[0].tolist())) == [76, 178]


def test_a_flat_view_becomes_grey() -> None:
    assert set(standardised(np.full((1, 16), 9)).ravel().tolist()) == {128}
