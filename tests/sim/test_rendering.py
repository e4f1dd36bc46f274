"""Casting, shading, light and film."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.sim_world import DARK, NIGHT, block, box_room, pillar, stage_of

from fpnav.geometry import column_bearings
from fpnav.sim import light, textures
from fpnav.sim.grid import cast_grid, stride_of, view_of
from fpnav.sim.light import Daylight, Lamp
from fpnav.sim.raycast import Caster, from_point
from fpnav.sim.scene import LEVELS, compile_scene, mip_levels
from fpnav.sim.seeds import generator
from fpnav.sim.sensors import eyes, film
from fpnav.sim.sensors.film import Film, Mask
from fpnav.sim.solids import Material, sheet
from fpnav.sim.world import Visuals
from fpnav.values import Pose2

SUN = Daylight(0.0, math.radians(30.0), sun=3.0, sky=0.0, clouds=0.0)
WHITE = Material(colour=(1.0, 1.0, 1.0))


def test_an_empty_set_of_triangles_is_never_hit() -> None:
    rays = np.array([[1.0, 0.0, 0.0]], dtype=np.float32)
    nothing = Caster(np.zeros((0, 3, 3)))
    assert nothing.cast(from_point((0, 0, 0), rays), rays).triangle[0] == -1
    assert not nothing.blocked(from_point((0, 0, 0), rays), rays, np.ones(1, np.float32))[0]


def test_a_ray_is_blocked_only_within_its_reach() -> None:
    wall = Caster(sheet((2, 1, -1), (0, -2, 0), (0, 0, 2), DARK).corners())
    rays = np.array([[1.0, 0.0, 0.0]] * 2, dtype=np.float32)
    reach = np.array([1.9, 2.1], dtype=np.float32)
    assert wall.blocked(from_point((0, 0, 0), rays), rays, reach).tolist() == [False, True]


def test_sparse_casting_finds_what_full_casting_finds() -> None:
    faces = [*box_room(8, 6), *pillar(5, 4), *block(2, 1, 2.6, 1.5), *block(6, 2, 6.3, 2.4)]
    scene = stage_of(faces).scene
    eye = eyes.PanoramaEye(width_px=1500, height_px=240)
    rays = eyes.panorama_rays(eye)
    view = view_of(rays.directions, Pose2(4.0, 3.0, 0.4), 1.0)
    full = cast_grid(scene, view, 1500, 1)
    sparse = cast_grid(scene, view, 1500, stride_of(rays.pixel_rad))
    chosen = view.all()
    cast = scene.solid.cast(from_point(view.origin, chosen), chosen)
    np.testing.assert_array_equal(full.triangle, cast.triangle)
    np.testing.assert_allclose(full.distance_m, cast.distance_m, rtol=1e-3)
    same = scene.owner[full.triangle] == scene.owner[sparse.triangle]
    assert same.mean() > 0.999
    np.testing.assert_allclose(full.distance_m[same], sparse.distance_m[same], rtol=1e-4)


def test_vertical_edges_are_cast_in_every_column() -> None:
    scene = stage_of([*box_room(8, 6), *pillar(5.5, 3.0, 0.004)]).scene
    eye = eyes.PanoramaEye(width_px=1500, height_px=240)
    rays = eyes.panorama_rays(eye)
    view = view_of(rays.directions, Pose2(4.0, 3.0, 0.0), 1.0)
    full, sparse = (
        cast_grid(scene, view, 1500, stride).distance_m.reshape(240, 1500) for stride in (1, 4)
    )
    np.testing.assert_array_equal(full.min(axis=0) < 2.0, sparse.min(axis=0) < 2.0)


@pytest.mark.parametrize(("pixel_deg", "rows"), [(0.5, 2), (0.24, 4), (2.0, 1), (0.05, 4)])
def test_rows_are_skipped_up_to_a_degree_or_four(pixel_deg: float, rows: int) -> None:
    assert stride_of(math.radians(pixel_deg)) == rows


@pytest.mark.parametrize("name", sorted(textures.KINDS))
def test_every_texture_is_a_picture_and_the_same_for_the_same_seed(name: str) -> None:
    made = textures.make_texture(f"{name}:3", 7)
    assert made.shape == (256, 256, 3)
    assert 0.0 <= made.min() < made.max() <= 1.0
    np.testing.assert_array_equal(made, textures.make_texture(f"{name}:3", 7))


@pytest.mark.parametrize("name", ["plaster", "concrete", "grass", "asphalt", "foliage", "wood"])
def test_tiled_textures_go_on_across_their_rims(name: str) -> None:
    made = textures.make_texture(name, 1)
    across = np.abs(made[:, 0] - made[:, -1]).mean()
    within = np.abs(np.diff(made, axis=1)).mean()
    assert across < 4.0 * within + 0.02


def test_variants_and_seeds_differ() -> None:
    first = textures.make_texture("poster:1", 1)
    assert np.abs(first - textures.make_texture("poster:2", 1)).mean() > 0.02
    assert np.abs(first - textures.make_texture("poster:1", 2)).mean() > 0.02


def test_mip_levels_keep_the_mean() -> None:
    flat = mip_levels(textures.make_texture("brick", 1))
    assert len(flat) == sum((256 >> level) ** 2 for level in range(LEVELS))
    np.testing.assert_allclose(flat[-1], flat[: 256 * 256].mean(axis=0), atol=40)


def floor_light(
    faces: list, lamps: tuple[Lamp, ...], daylight: Daylight, x: float, y: float
) -> float:
    """Direct light on the floor, the first face, at a point."""
    scene = compile_scene(faces, 1, 0.1)
    points, normals, patch = light.texels(scene.patches)
    direct = light._from_lamps(scene.solid, points, normals, lamps)
    direct += light._from_sun(scene.solid, points, normals, daylight)
    away = np.hypot(points[:, 0] - x, points[:, 1] - y) + 1e3 * (patch != 0)
    return float(direct[away.argmin(), 1])


FLOOR = sheet((0, 0, 0), (6, 0, 0), (0, 6, 0), WHITE)


def test_open_ground_gets_the_sun_by_its_height() -> None:
    lit = floor_light([FLOOR], (), SUN, 3.0, 3.0)
    assert lit == pytest.approx(3.0 * math.sin(math.radians(30.0)) * 0.94, rel=1e-3)


def test_a_wall_casts_its_shadow_as_far_as_the_sun_says() -> None:
    # The sun stands to the east: a wall of height 1 shades 1 / tan 30 deg = 1.73 m to its west.
    low = [FLOOR, sheet((4.0, 6.0, 0.0), (0, -6, 0), (0, 0, 1.0), WHITE)]
    assert floor_light(low, (), SUN, 3.0, 3.0) == 0.0
    assert floor_light(low, (), SUN, 2.4, 3.0) == 0.0
    assert floor_light(low, (), SUN, 2.1, 3.0) > 1.0


def test_at_night_there_is_no_sun() -> None:
    assert floor_light([FLOOR], (), NIGHT, 3.0, 3.0) == 0.0


def test_a_lamp_is_brightest_below_itself_and_hidden_behind_a_block() -> None:
    lamp = (Lamp(3.0, 3.0, 2.5, (1.0, 1.0, 1.0)),)
    below, beside = (floor_light([FLOOR], lamp, NIGHT, x, 3.0) for x in (3.0, 5.0))
    assert below > 2 * beside > 0.0
    table = sheet((2.5, 2.5, 1.0), (1, 0, 0), (0, 1, 0), WHITE)
    assert floor_light([FLOOR, table], lamp, NIGHT, 3.0, 3.0) == 0.0


def test_the_gather_lights_what_no_lamp_reaches() -> None:
    faces = [FLOOR, sheet((2.5, 2.5, 1.0), (1, 0, 0), (0, 1, 0), WHITE)]
    scene = compile_scene(faces, 1, 0.5)
    sky = Daylight(0.0, 0.5, sun=0.0, sky=1.0, clouds=1.0)
    baked = light.bake(scene, (), sky, rays=64, ambient=0.0)
    points, _, patch = light.texels(scene.patches)
    shaded = (np.abs(points[:, :2] - 3.0).max(axis=1) < 0.3) & (patch == 0)
    assert 0.0 < baked[shaded].mean() < 0.9 * baked[patch == 0].mean()


def test_hemisphere_directions_are_unit_upward_and_cosine_weighted() -> None:
    made = light.hemisphere(4000)
    np.testing.assert_allclose(np.linalg.norm(made, axis=1), 1.0, atol=1e-5)
    assert made[:, 2].min() > 0.0
    assert made[:, 2].mean() == pytest.approx(2.0 / 3.0, abs=0.01)


def test_emission_is_seen_as_it_is() -> None:
    glow = sheet((7.0, 4.0, 0.5), (0, -2, 0), (0, 0, 1), Material(emission=2.0))
    stage = stage_of([glow])
    eye = eyes.CameraEye(width_px=32, height_px=32, fov_deg=4.0)
    seen = stage.look(eyes.camera_rays(eye), Pose2(4, 3, 0), 1.0, None)
    expected = 2.0 * mip_levels(textures.make_texture("plain", 1))[-1] / 65535.0
    np.testing.assert_allclose(seen.mean(axis=(0, 1)), expected, rtol=0.05)


def test_rays_that_hit_nothing_see_the_sky() -> None:
    day = Daylight(0.0, 0.5, sun=1.0, sky=1.0, clouds=0.0)
    stage = stage_of([FLOOR], daylight=day)
    eye = eyes.PanoramaEye(width_px=360, height_px=90)
    seen = stage.look(eyes.panorama_rays(eye), Pose2(3, 3, 0), 1.0, None)
    top, horizon = seen[0].mean(axis=0), seen[44].mean(axis=0)
    assert top[2] > top[0]
    assert horizon.mean() > top.mean()


def test_haze_turns_the_distance_into_horizon() -> None:
    wall = sheet((80.0, 40.0, -40.0), (0, -80, 0), (0, 0, 80), Material(emission=5.0))
    day = Daylight(0.0, 0.5, sun=0.0, sky=1.0, clouds=0.0)
    eye = eyes.CameraEye(width_px=32, height_px=32, fov_deg=10.0)
    clear, hazy = (
        stage_of([wall], daylight=day, visuals=Visuals(haze_m=haze))
        .look(eyes.camera_rays(eye), Pose2(0, 0, 0), 1.0, None)
        .mean()
        for haze in (1e5, 20.0)
    )
    assert clear > 4.0
    assert hazy < 1.5


GREY = np.full((40, 120, 3), 0.3, dtype=np.float32)
PERFECT = Film(
    exposure_spread=0.0, vignette=0.0, blur_px=0.0, shot_noise=0.0, read_noise=0.0, rolling=0.0
)


def developed(light_level: float, **given: float) -> np.ndarray:
    values = {name: getattr(PERFECT, name) for name in PERFECT.__struct_fields__}
    made = Film(**{**values, **given})
    return film.develop(GREY * light_level, made, generator(1), 0.0, around=True)


def test_full_exposure_evens_out_the_light_and_none_does_not() -> None:
    full = [developed(level, exposure=1.0).mean() for level in (0.5, 2.0)]
    none = [developed(level, exposure=0.0).mean() for level in (0.5, 2.0)]
    assert full[0] == pytest.approx(full[1], abs=1.0)
    assert none[1] > 1.3 * none[0]


def test_noise_is_as_strong_as_asked_and_none_where_none_is() -> None:
    assert developed(1.0).std() < 0.6
    assert developed(1.0, shot_noise=0.05, read_noise=0.02).std() > 3.0


def test_the_rim_is_darker_by_the_vignette() -> None:
    made = developed(1.0, vignette=0.5)
    assert made[0].mean() < 0.8 * made[20].mean()


def test_turning_smears_sideways_only() -> None:
    picture = np.zeros((40, 120, 3), dtype=np.float32)
    picture[:, 60:] = 1.0
    sharp, smeared = (
        film.develop(picture, PERFECT, generator(1), smear, around=False) for smear in (0.0, 9.0)
    )
    assert (np.abs(np.diff(sharp[20, :, 0].astype(int))) > 5).sum() == 1
    assert (np.abs(np.diff(smeared[20, :, 0].astype(int))) > 5).sum() > 5
    assert np.ptp(smeared[:, 30].astype(int)) == 0


def test_a_panorama_blurs_across_its_seam() -> None:
    picture = np.zeros((40, 120, 3), dtype=np.float32)
    picture[:, 0] = 1.0
    soft = Film(**{**{n: getattr(PERFECT, n) for n in PERFECT.__struct_fields__}, "blur_px": 1.5})
    made = film.develop(picture, soft, generator(1), 0.0, around=True)
    np.testing.assert_allclose(made[20, 1].astype(int), made[20, -1].astype(int), atol=2)


def test_the_mask_hides_its_share_about_its_bearing_once_it_is_time() -> None:
    pixels = np.full((10, 720, 3), 200, dtype=np.uint8)
    mask = Mask(share=0.5, from_share=0.5, centre_deg=90.0, grey=10)
    assert film.hide(pixels, mask, 0.4) is pixels
    hidden = film.hide(pixels, mask, 0.6)[0, :, 0] == 10
    assert hidden.mean() == pytest.approx(0.5, abs=0.01)
    assert (hidden == (column_bearings(720) > 0.0)).mean() > 0.99


def test_jpeg_bytes_come_back_as_nearly_the_same_pixels() -> None:
    pixels = np.repeat(np.linspace(0, 255, 64).astype(np.uint8)[None, :, None], 32, 0).repeat(3, 2)
    back = film.decode(film.encode(pixels, 90))
    assert np.abs(back.astype(int) - pixels).mean() < 3.0


def test_the_same_moment_gives_the_same_pixels() -> None:
    noisy = Film()
    one, two = (film.develop(GREY, noisy, generator(4), 0.0, around=True) for _ in range(2))
    np.testing.assert_array_equal(one, two)
    other = film.develop(GREY, noisy, generator(5), 0.0, around=True)
    assert (one != other).any()
