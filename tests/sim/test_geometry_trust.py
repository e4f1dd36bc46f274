"""The sensors against closed forms: what stands where must be seen where it stands."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.sim_world import TRUE_LASER, TRUE_SONAR, block, box_room, pillar, stage_of
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.geometry import column_bearings, wrap
from fpnav.sim.seeds import generator
from fpnav.sim.sensors import eyes, ranges
from fpnav.sim.solids import Material, sheet
from fpnav.sim.stage import Stage
from fpnav.values import FloatArray, Pose2

WIDTH, DEPTH = 8.0, 6.0
GLASS = Material(glass=True, rough=0.0)
NOBODY = None


@pytest.fixture(scope="module")
def room() -> Stage:
    return stage_of(box_room(WIDTH, DEPTH))


def wall_distance(pose: Pose2, angle: float) -> float:
    """Distance to the wall of the box along a world angle."""
    c, s = math.cos(angle), math.sin(angle)
    along_x = ((WIDTH if c > 0 else 0.0) - pose.x_m) / c if abs(c) > 1e-12 else math.inf
    along_y = ((DEPTH if s > 0 else 0.0) - pose.y_m) / s if abs(s) > 1e-12 else math.inf
    return min(along_x, along_y)


@settings(max_examples=30)
@given(st.floats(0.5, 7.5), st.floats(0.5, 5.5), st.floats(-math.pi, math.pi))
def test_every_beam_measures_the_distance_to_the_wall(x: float, y: float, heading: float) -> None:
    stage, pose = _room(), Pose2(x, y, heading)
    scan = ranges.scan(stage.scene, NOBODY, pose, TRUE_LASER, generator(1))
    expected = [wall_distance(pose, heading + bearing) for bearing in scan.bearings_rad]
    np.testing.assert_allclose(scan.ranges_m, expected, atol=2e-4)


_ROOMS: list[Stage] = []


def _room() -> Stage:
    if not _ROOMS:
        _ROOMS.append(stage_of(box_room(WIDTH, DEPTH)))
    return _ROOMS[0]


@pytest.mark.parametrize("degrees", [180.0, 270.0])
def test_a_narrower_scanner_looks_ahead_symmetrically(room: Stage, degrees: float) -> None:
    laser = ranges.Laser(beams=181, field_of_view_deg=degrees)
    scan = ranges.scan(room.scene, NOBODY, Pose2(4, 3, 0), laser, generator(1))
    assert scan.bearings_rad[0] == pytest.approx(-math.radians(degrees) / 2)
    assert scan.bearings_rad[-1] == pytest.approx(math.radians(degrees) / 2)
    assert scan.bearings_rad[90] == pytest.approx(0.0, abs=1e-9)


def centre_of(weights: FloatArray, bearings: FloatArray) -> float:
    """Weighted mean bearing."""
    return math.atan2(weights @ np.sin(bearings), weights @ np.cos(bearings))


def panorama_bearing(stage: Stage, pose: Pose2, width: int) -> float:
    eye = eyes.PanoramaEye(width_px=width, height_px=24)
    light = stage.look(eyes.panorama_rays(eye), pose, 1.0, NOBODY)
    lit = (light.sum(axis=2) > 1.0).sum(axis=0).astype(float)
    return centre_of(lit, column_bearings(width))


def scan_bearing(stage: Stage, pose: Pose2) -> float:
    """Middle of the beams that fall short of the wall."""
    laser = ranges.Laser(
        beams=7200, noise_m=0.0, noise_share=0.0, dropouts=0.0, mixed=0.0, step_m=0.0
    )
    scan = ranges.scan(stage.scene, NOBODY, pose, laser, generator(1))
    wall = np.array([wall_distance(pose, pose.heading_rad + b) for b in scan.bearings_rad])
    return centre_of((scan.ranges_m < wall - 0.01).astype(float), scan.bearings_rad)


def camera_bearing(stage: Stage, pose: Pose2) -> float:
    eye = eyes.CameraEye()
    light = stage.look(eyes.camera_rays(eye), pose, 1.0, NOBODY)
    lit = np.flatnonzero(light[240].sum(axis=1) > 1.0)
    left, right = lit[0] - 0.5, lit[-1] + 0.5
    return sum(math.atan2(479 / 2 - edge, eye.focal_px) for edge in (left, right)) / 2


@pytest.mark.parametrize(
    ("x", "y", "heading"), [(3.0, 2.0, 0.3), (5.0, 4.0, -2.0), (2.0, 4.5, 3.0)]
)
def test_a_pillar_is_at_one_bearing_for_scan_panorama_and_camera(
    x: float, y: float, heading: float
) -> None:
    distance, bearing = 1.4, math.radians(12.0)
    px, py = x + distance * math.cos(heading + bearing), y + distance * math.sin(heading + bearing)
    stage, pose = stage_of([*box_room(WIDTH, DEPTH), *pillar(px, py)]), Pose2(x, y, heading)
    tolerance = math.radians(0.1)
    assert panorama_bearing(stage, pose, 1500) == pytest.approx(bearing, abs=tolerance)
    assert panorama_bearing(stage, pose, 720) == pytest.approx(bearing, abs=tolerance)
    assert scan_bearing(stage, pose) == pytest.approx(bearing, abs=tolerance)
    assert camera_bearing(stage, pose) == pytest.approx(bearing, abs=tolerance)


@pytest.mark.parametrize("degrees", range(-170, 180, 35))
def test_columns_point_where_the_conventions_say(degrees: int) -> None:
    bearing = math.radians(degrees)
    px, py = 4 + 2.0 * math.cos(bearing), 3 + 2.0 * math.sin(bearing)
    stage = stage_of([*box_room(WIDTH, DEPTH), *pillar(px, py, radius=0.05)])
    seen = panorama_bearing(stage, Pose2(4, 3, 0), 3600)
    assert abs(wrap(seen - bearing)) < math.radians(0.1)


def test_a_higher_thing_is_on_a_higher_row() -> None:
    lamp = sheet((7.9, 3.5, 1.9), (0, -1, 0), (0, 0, 0.2), Material(emission=5.0))
    stage = stage_of([*box_room(WIDTH, DEPTH), lamp])
    eye = eyes.PanoramaEye(width_px=1500, height_px=240)
    light = stage.look(eyes.panorama_rays(eye), Pose2(4, 3, 0), 1.0, NOBODY)
    row = light[:, 750].sum(axis=1).astype(float)
    elevation = (239 / 2 - row @ np.arange(240) / row.sum()) * 2 * math.pi / 1500
    assert elevation == pytest.approx(math.atan2(1.0, 3.9), abs=math.radians(0.15))


def test_the_omni_image_unwraps_to_the_panorama() -> None:
    from fpnav.sensing.panorama import unwrap

    bearing = math.radians(70.0)
    px, py = 4 + 2.0 * math.cos(bearing), 3 + 2.0 * math.sin(bearing)
    stage = stage_of([*box_room(WIDTH, DEPTH), *pillar(px, py)])
    eye = eyes.OmniEye()
    light = stage.look(eyes.omni_rays(eye), Pose2(4, 3, 0), 1.0, NOBODY)
    pixels = np.clip(light * 255, 0, 255).astype(np.uint8)
    strip = unwrap(pixels, eye.calibration()).astype(float)
    row = strip[40:-10].sum(axis=(0, 2))
    assert centre_of(row, column_bearings(len(row))) == pytest.approx(
        bearing, abs=math.radians(0.4)
    )


def test_the_offset_camera_sees_things_further_left_by_the_disparity() -> None:
    stage = stage_of([*box_room(WIDTH, DEPTH), *pillar(6.0, 3.0)])
    eye = eyes.CameraEye()

    def column(offset: bool) -> float:
        mount = eye.mount(offset=offset)
        place = Pose2(4.0 + mount.x_m, 3.0 + mount.y_m, 0.0)
        light = stage.look(eyes.camera_rays(eye), place, 1.0, NOBODY)
        row = light[240].sum(axis=1).astype(float)
        return float(row @ np.arange(480) / row.sum())

    disparity = column(offset=False) - column(offset=True)
    assert disparity == pytest.approx(eye.focal_px * eye.baseline_m / 2.0, abs=1.0)


def sonar_reading(stage: Stage, pose: Pose2, number: int) -> float:
    ring = ranges.ring(stage.scene, NOBODY, pose, TRUE_SONAR, generator(1))
    return float(ring.ranges_m[number])


@pytest.mark.parametrize("turn", [-12.0, -5.0, 0.0, 8.0, 14.0])
def test_a_sonar_cone_returns_the_nearest_surface_in_it(turn: float) -> None:
    # A wall at 2 m: the nearest point lies straight ahead of it as long as the cone covers that.
    stage = stage_of(box_room(4.0, 6.0))
    heading = math.radians(turn)
    pose = Pose2(2.0, 3.0, heading)
    start = 2.0 + TRUE_SONAR.radius_m * math.cos(heading)
    assert sonar_reading(stage, pose, 0) == pytest.approx(4.0 - start, abs=0.005)


def test_a_sonar_cone_sees_a_thin_post_inside_it_and_none_beside_it() -> None:
    wall = 4.0 - 2.0 - TRUE_SONAR.radius_m
    inside = stage_of([*box_room(4.0, 6.0), *pillar(3.2, 3.15, 0.05)])
    beside = stage_of([*box_room(4.0, 6.0), *pillar(3.2, 3.6, 0.05)])
    to_post = math.hypot(3.2 - 2.0 - TRUE_SONAR.radius_m, 0.15) - 0.05
    assert sonar_reading(inside, Pose2(2, 3, 0), 0) == pytest.approx(to_post, abs=0.01)
    assert sonar_reading(beside, Pose2(2, 3, 0), 0) == pytest.approx(wall, abs=0.005)


def test_the_nearest_of_two_surfaces_wins_whichever_it_is() -> None:
    stage = stage_of([*box_room(8.0, 6.0), *block(5.0, 3.2, 5.5, 5.0), *block(4.5, 1.0, 5.0, 2.8)])
    pose = Pose2(3.0, 3.0, 0.0)
    start = 3.0 + TRUE_SONAR.radius_m
    corner = math.hypot(4.5 - start, 0.2)
    assert sonar_reading(stage, pose, 0) == pytest.approx(corner, abs=0.02)


def test_a_smooth_wall_throws_slanting_sound_away() -> None:
    mirror = Material(rough=0.0)
    wall = sheet((4.0, 8.0, 0.0), (0, -10, 0), (0, 0, 3), mirror)
    stage = stage_of([wall])
    deaf = ranges.Sonar(noise_m=0.0, misses=1.0, cross_talk=0.0)
    straight = ranges.ring(stage.scene, NOBODY, Pose2(2, 3, 0.0), deaf, generator(1))
    slanting = ranges.ring(stage.scene, NOBODY, Pose2(2, 3, 0.9), deaf, generator(1))
    assert straight.ranges_m[0] == pytest.approx(1.79, abs=0.02)
    assert math.isinf(slanting.ranges_m[0])


def test_glass_lets_a_slanting_beam_through_and_stops_sound() -> None:
    pane = sheet((4.0, 6.0, 0.0), (0, -6, 0), (0, 0, 3), GLASS)
    stage = stage_of([*box_room(8.0, 6.0), pane])
    pose = Pose2(2.0, 3.0, 0.0)
    scan = ranges.scan(stage.scene, NOBODY, pose, TRUE_LASER, generator(1))
    beams = dict(enumerate(scan.ranges_m[360:].tolist()))  # every half degree from straight ahead
    assert beams[0] == pytest.approx(2.0, abs=1e-3)
    assert beams[40] == pytest.approx(6.0 / math.cos(math.radians(20)), abs=1e-3)
    assert sonar_reading(stage, pose, 0) == pytest.approx(2.0 - TRUE_SONAR.radius_m, abs=0.005)


def test_what_is_out_of_range_is_infinite_and_what_is_too_near_minus_infinite(room: Stage) -> None:
    short = ranges.Laser(range_max_m=2.0, range_min_m=1.0, dropouts=0.0, mixed=0.0)
    scan = ranges.scan(room.scene, NOBODY, Pose2(0.5, 3.0, 0.0), short, generator(1))
    assert math.isinf(scan.ranges_m[len(scan.ranges_m) // 2])
    assert scan.ranges_m[0] == -math.inf


def test_laser_noise_has_the_spread_asked_for(room: Stage) -> None:
    laser = ranges.Laser(noise_m=0.02, noise_share=0.0, dropouts=0.0, mixed=0.0, step_m=0.0)
    pose = Pose2(4, 3, 0)
    errors = np.concatenate(
        [
            ranges.scan(room.scene, NOBODY, pose, laser, generator(1, i)).ranges_m
            - ranges.scan(room.scene, NOBODY, pose, TRUE_LASER, generator(1)).ranges_m
            for i in range(10)
        ]
    )
    assert np.std(errors) == pytest.approx(0.02, rel=0.05)
    assert abs(np.mean(errors)) < 0.001


def test_dropouts_and_cross_talk_come_as_often_as_asked(room: Stage) -> None:
    pose = Pose2(4, 3, 0)
    laser = ranges.Laser(dropouts=0.1)
    lost = [
        np.isinf(ranges.scan(room.scene, NOBODY, pose, laser, generator(2, i)).ranges_m).mean()
        for i in range(10)
    ]
    assert np.mean(lost) == pytest.approx(0.1, abs=0.02)


def test_sonar_readings_are_in_steps(room: Stage) -> None:
    sonar = ranges.Sonar(step_m=0.05)
    ring = ranges.ring(room.scene, NOBODY, Pose2(4, 3, 0), sonar, generator(3))
    heard = ring.ranges_m[np.isfinite(ring.ranges_m)]
    np.testing.assert_allclose(heard, np.round(heard / 0.05) * 0.05, atol=1e-6)


def test_sonars_stand_around_the_robot_the_first_ahead() -> None:
    places = ranges.mounts(ranges.Sonar(count=16, radius_m=0.3))
    np.testing.assert_allclose(places[0], [0.3, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(places[4], [0.0, 0.3, math.pi / 2], atol=1e-12)
    np.testing.assert_allclose(places[12], [0.0, -0.3, -math.pi / 2], atol=1e-12)
