"""Any camera image as an equal-angle strip."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.errors import LogError
from fpnav.sensing import panorama
from fpnav.values import Calibration, Image, Pose2


def marked(width: int, height: int, column: int, thick: int) -> np.ndarray:
    """Black image with one white post."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[:, column - thick : column + thick] = 255
    return pixels


def post_bearing(view: panorama.View) -> float:
    brightness = view.pixels[..., 0].astype(float).sum(axis=0)
    z = (brightness * np.exp(1j * view.bearings_rad)).sum()
    return float(np.angle(z))


def test_a_panorama_keeps_the_bearings_of_the_file_convention() -> None:
    view = panorama.from_panorama(Image(marked(1440, 200, 360, 4)))
    assert view.pixels.shape == (panorama.HEIGHT, panorama.WIDTH, 3)
    assert view.circular
    assert view.width_rad == pytest.approx(2.0 * math.pi)
    assert post_bearing(view) == pytest.approx(math.pi / 2.0, abs=1e-3)


def test_a_turned_camera_turns_the_bearings() -> None:
    calibration = Calibration(720, 120, mount=Pose2(0.0, 0.0, 0.5))
    straight = panorama.from_panorama(Image(marked(720, 120, 500, 4)))
    turned = panorama.from_panorama(Image(marked(720, 120, 500, 4), calibration))
    assert post_bearing(turned) - post_bearing(straight) == pytest.approx(0.5)


def test_a_small_panorama_is_enlarged() -> None:
    view = panorama.from_panorama(Image(marked(120, 25, 30, 1)))
    assert view.pixels.shape == (120, 720, 3)
    assert post_bearing(view) == pytest.approx(math.pi / 2.0, abs=0.01)


def test_the_blur_wraps_around_the_seam() -> None:
    pixels = np.zeros((120, 720, 3), np.uint8)
    pixels[:, 0] = 255
    view = panorama.from_panorama(Image(pixels))
    assert view.pixels[60, -1, 0] == view.pixels[60, 1, 0] > 0


@pytest.mark.parametrize("fov_deg", [40.0, 60.0, 90.0])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_forward_camera_has_pinhole_bearings(fov_deg: float, share: float) -> None:
    width, column = 640, round(640 * share)
    calibration = Calibration(width, 480, horizontal_fov_rad=math.radians(fov_deg))
    view = panorama.from_camera(Image(marked(width, 480, column, 3), calibration))
    focal = width / 2.0 / math.tan(math.radians(fov_deg) / 2.0)
    assert not view.circular
    assert view.centre_rad == pytest.approx(0.0, abs=1e-9)
    assert math.degrees(view.width_rad) == pytest.approx(fov_deg)
    expected = math.atan2(width / 2.0 - column, focal)
    assert post_bearing(view) == pytest.approx(expected, abs=math.radians(0.2))


@pytest.mark.parametrize(
    ("calibration", "found"),
    [
        (None, "found none"),
        (Calibration(640, 480), "found none"),
        (Calibration(640, 480, horizontal_fov_rad=math.radians(200.0)), "found 200.0 degrees"),
    ],
)
def test_a_camera_without_its_field_of_view_says_how_to_give_it(
    calibration: Calibration | None, found: str
) -> None:
    with pytest.raises(LogError, match=r"--hfov") as caught:
        panorama.from_camera(Image(marked(640, 480, 300, 3), calibration))
    assert found in str(caught.value)


def catadioptric(bearing_rad: float, size: int = 401) -> Image:
    """Ring of radii 60..180 around the centre with one post; up is ahead."""
    rows, columns = np.mgrid[0:size, 0:size]
    centre = (size - 1) / 2.0
    bearing = np.arctan2(centre - columns, centre - rows)
    off = np.abs((bearing - bearing_rad + np.pi) % (2 * np.pi) - np.pi)
    radius = np.hypot(rows - centre, columns - centre)
    pixels = np.zeros((size, size, 3), np.uint8)
    pixels[(off < 0.05) & (radius >= 120.0) & (radius <= 180.0)] = 255
    calibration = Calibration(
        size, size, centre_x_px=centre, centre_y_px=centre, radius_in_px=60.0, radius_out_px=180.0
    )
    return Image(pixels, calibration)


@pytest.mark.parametrize("bearing_deg", [-135.0, -40.0, 0.0, 75.0, 170.0])
def test_an_omni_image_unwraps_with_ahead_in_the_middle_and_far_on_top(bearing_deg: float) -> None:
    view = panorama.from_omni(catadioptric(math.radians(bearing_deg)))
    assert math.degrees(post_bearing(view)) == pytest.approx(bearing_deg, abs=0.6)
    rows = view.pixels[..., 0].astype(float).sum(axis=1)
    assert rows[:50].min() > 10.0 * rows[70:].max()


def test_an_omni_image_without_its_radii_says_what_is_needed() -> None:
    image = catadioptric(0.0)
    with pytest.raises(LogError, match=r"radius_in_px < radius_out_px"):
        panorama.from_omni(Image(image.pixels))
    with pytest.raises(LogError, match="centre_x_px"):
        panorama.from_omni(Image(image.pixels, Calibration(401, 401, radius_out_px=180.0)))


def test_grey_world_makes_the_channel_means_equal() -> None:
    pixels = np.zeros((120, 720, 3), np.uint8)
    pixels[...] = (60, 90, 120)
    view = panorama.white_balanced(panorama.from_panorama(Image(pixels)))
    assert view.pixels.reshape(-1, 3).mean(axis=0) == pytest.approx([90.0, 90.0, 90.0])


def test_grey_is_luminance_from_zero_to_one() -> None:
    view = panorama.from_panorama(Image(np.full((120, 720, 3), 255, np.uint8)))
    assert panorama.grey(view) == pytest.approx(1.0)
