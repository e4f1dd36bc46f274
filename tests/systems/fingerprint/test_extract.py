"""From frames to features."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.errors import LogError
from fpnav.systems.fingerprint.extract import features_of_frame
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.values import Decoded, Frame, Image, Pose2, Reference

POSE = Pose2(4.0, 0.2, 0.3)
TAU = 2.0 * math.pi


def extracted(*roles: str, **settings: object) -> tuple[np.ndarray, np.ndarray]:
    params = FingerprintParams(**settings)  # type: ignore[arg-type]
    return features_of_frame(small_world.frame(0, POSE, roles), params)


def letters(rows: np.ndarray) -> set[str]:
    return {letter.decode() for letter in rows["type"]}


def test_laser_and_panorama_give_corners_edges_and_hues() -> None:
    rows, arcs = extracted("scan", "panorama")
    assert {"c", "v"} < letters(rows)
    assert letters(rows) & set("ABCDEFGHIJKLMNOP")
    assert arcs[:, 1] == pytest.approx([TAU, TAU])
    assert (np.diff(rows["angle_rad"]) >= 0.0).all()
    assert ((rows["certainty"] > 0.0) & (rows["certainty"] <= 1.0)).all()
    corners = rows["type"] == b"c"
    assert np.isfinite(rows["range_m"][corners]).all()
    assert np.isnan(rows["range_m"][~corners]).all()


def test_one_sensor_gives_its_own_features_only() -> None:
    laser, laser_arcs = extracted("scan")
    camera, camera_arcs = extracted("panorama")
    assert letters(laser) == {"c"}
    assert "c" not in letters(camera)
    assert laser_arcs[:, 1] == pytest.approx([TAU, 0.0])
    assert camera_arcs[:, 1] == pytest.approx([0.0, TAU])


def test_a_sensor_can_be_switched_off() -> None:
    both = "scan", "panorama"
    assert letters(extracted(*both, use_camera=False)[0]) == {"c"}
    assert "c" not in letters(extracted(*both, use_laser=False)[0])
    nothing, arcs = extracted(*both, use_laser=False, use_camera=False)
    assert len(nothing) == 0
    assert not arcs.any()


def test_a_forward_camera_sees_its_field_of_view() -> None:
    rows, arcs = extracted("camera")
    degrees = (np.degrees(rows["angle_rad"]) + 180.0) % 360.0 - 180.0
    assert len(rows) > 0
    assert (np.abs(degrees) <= 31.0).all()
    assert math.degrees(arcs[1, 1]) == pytest.approx(60.0)
    assert arcs[1, 0] == pytest.approx(0.0)


def test_a_raw_omnidirectional_image_sees_what_the_panorama_sees() -> None:
    flat, _ = extracted("panorama")
    raw, arcs = extracted("omni")
    assert arcs[1, 1] == pytest.approx(TAU)
    edges = flat["angle_rad"][(flat["type"] == b"v") & (flat["certainty"] > 0.6)]
    found = raw["angle_rad"][raw["type"] == b"v"]
    off = np.abs((edges[:, None] - found[None, :] + np.pi) % TAU - np.pi).min(axis=1)
    assert np.median(off) < math.radians(1.5)


def test_a_forward_camera_without_calibration_says_how_to_give_it() -> None:
    image = Image(np.zeros((120, 160, 3), np.uint8))
    frame = Frame(Reference(0, 0), {"camera": Decoded(image)})
    with pytest.raises(LogError, match="--hfov"):
        features_of_frame(frame, FingerprintParams())


def test_laser_fov_narrows_what_was_sensed() -> None:
    rows, arcs = extracted("scan", laser_fov_deg=180.0)
    assert math.degrees(arcs[0, 1]) == pytest.approx(180.0)
    assert (np.cos(rows["angle_rad"]) >= -1e-9).all()


def test_a_dropped_out_frame_has_no_features_and_covers_nothing() -> None:
    rows, arcs = features_of_frame(Frame(Reference(0, 0), {}), FingerprintParams())
    assert len(rows) == 0
    assert not arcs.any()


def test_turning_the_robot_turns_the_features() -> None:
    straight = features_of_frame(
        small_world.frame(0, Pose2(4.0, 0.2, 0.0), ["panorama", "scan"]), FingerprintParams()
    )[0]
    turn = TAU / 36.0
    turned = features_of_frame(
        small_world.frame(0, Pose2(4.0, 0.2, turn), ["panorama", "scan"]), FingerprintParams()
    )[0]
    for letter in (b"v", b"c"):
        before = straight["angle_rad"][straight["type"] == letter]
        after = turned["angle_rad"][turned["type"] == letter]
        off = (before[:, None] - after[None, :] - turn + np.pi) % TAU - np.pi
        assert np.median(np.abs(off).min(axis=1)) < math.radians(1.0)


def test_grey_world_changes_hues_only() -> None:
    plain, _ = extracted("panorama")
    balanced, _ = extracted("panorama", white_balance=True)
    edges = [rows["angle_rad"][rows["type"] == b"v"] for rows in (plain, balanced)]
    assert np.array_equal(*edges)
