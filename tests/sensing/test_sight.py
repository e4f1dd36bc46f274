"""Where the pixels of panoramas, mirror images and cameras point."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.errors import LogError
from fpnav.geometry import column_bearings
from fpnav.sensing.sight import camera_sight, hidden_columns, omni_sight, panorama_sight
from fpnav.values import Calibration, Image, Pose2


def image(height: int, width: int, **calibration: float | Pose2) -> Image:
    pixels = np.zeros((height, width, 3), np.uint8)
    return Image(pixels, Calibration(width, height, **calibration) if calibration else None)


def test_a_panorama_keeps_the_bearings_of_its_columns() -> None:
    sight = panorama_sight(image(40, 240), 240)
    points = np.column_stack([np.arange(240), np.full(240, 20)])
    assert sight.directions(points)[0] == pytest.approx(column_bearings(240))


def test_a_panorama_of_another_size_is_resampled_with_square_pixels() -> None:
    sight = panorama_sight(image(25, 120), 750)
    assert sight.pixels.shape == (156, 750)
    assert sight.circular


def test_a_known_vertical_field_of_view_decides_the_rows() -> None:
    sight = panorama_sight(image(100, 720, vertical_fov_rad=math.radians(60)), 720)
    assert sight.pixels.shape == (120, 720)


def test_elevation_counts_from_the_horizon_upwards() -> None:
    sight = panorama_sight(image(120, 720, horizon_row=29.5), 720)
    _, elevation = sight.directions(np.array([[0, 29], [0, 31], [0, 119]]))
    assert np.degrees(elevation) == pytest.approx([0.25, -0.75, -44.75])


def test_without_calibration_the_horizon_is_the_middle_row() -> None:
    _, elevation = panorama_sight(image(121, 720), 720).directions(np.array([[0, 60], [0, 50]]))
    assert np.degrees(elevation) == pytest.approx([0.0, 5.0])


def test_the_horizon_moves_with_the_resampling() -> None:
    sight = panorama_sight(image(60, 360, horizon_row=10.0), 720)
    assert sight.horizon_row == pytest.approx(20.5)


def test_a_mounted_panorama_is_turned() -> None:
    sight = panorama_sight(image(40, 240, mount=Pose2(0.0, 0.0, 0.5)), 240)
    middle, _ = sight.directions(np.array([[119, 20]]))
    assert middle[0] == pytest.approx(column_bearings(240)[119] + 0.5)


def test_a_camera_has_the_resolution_of_the_panorama_at_its_centre() -> None:
    sight = camera_sight(image(144, 192, horizontal_fov_rad=math.radians(60)), 1045)
    assert sight.pixels.shape == (144, 192)
    assert not sight.circular


def test_the_edge_of_a_camera_image_is_half_its_field_of_view_away() -> None:
    sight = camera_sight(image(480, 480, horizontal_fov_rad=math.radians(60)), 2612)
    width = sight.pixels.shape[1]
    bearing, _ = sight.directions(np.array([[0, 0], [width - 1, 0]]))
    assert np.degrees(bearing) == pytest.approx([30.0, -30.0], abs=0.1)


def test_a_panned_camera_looks_where_it_is_panned() -> None:
    camera = image(91, 101, horizontal_fov_rad=1.0, mount=Pose2(0.0, 0.0, 3.0))
    sight = camera_sight(camera, 628, pan_rad=0.5)
    middle = np.array([[sight.pixels.shape[1] // 2, sight.pixels.shape[0] // 2]])
    bearing, elevation = sight.directions(middle)
    assert bearing[0] == pytest.approx(3.5 - 2 * math.pi, abs=0.01)
    assert elevation[0] == pytest.approx(0.0, abs=0.01)


def test_off_the_axis_a_camera_row_rises_less() -> None:
    sight = camera_sight(image(200, 200, horizontal_fov_rad=math.radians(90)), 628)
    corner = np.array([[0, 0], [sight.pixels.shape[1] // 2, 0]])
    _, elevation = sight.directions(corner)
    assert np.degrees(elevation) == pytest.approx([35.1, 44.8], abs=0.5)


def test_a_camera_of_unknown_field_of_view_is_refused() -> None:
    with pytest.raises(LogError, match="--hfov"):
        camera_sight(image(10, 10), 360)


def test_a_mirror_image_becomes_a_panorama() -> None:
    omni = image(200, 200, centre_x_px=100, centre_y_px=100, radius_in_px=20, radius_out_px=90)
    sight = omni_sight(omni, 720)
    assert sight.circular
    assert sight.pixels.shape == (140, 720)


def test_a_mirror_image_without_radii_is_refused() -> None:
    with pytest.raises(LogError, match="radii"):
        omni_sight(image(200, 200), 720)


def test_columns_without_any_scene_are_hidden_with_their_neighbours() -> None:
    pixels = np.tile(np.arange(40, dtype=np.uint8)[:, None], (1, 30))
    pixels[:, 10:13] = 90
    assert np.flatnonzero(hidden_columns(pixels, 2)).tolist() == [8, 9, 10, 11, 12, 13, 14]
    assert not hidden_columns(np.delete(pixels, slice(10, 13), axis=1), 2).any()


def test_grey_is_the_luminance() -> None:
    pixels = np.zeros((10, 60, 3), np.uint8)
    pixels[:, :, 1] = 100
    assert set(np.unique(panorama_sight(Image(pixels), 60).pixels)) == {59}
