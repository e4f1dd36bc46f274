"""From images to local views and signatures."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.constellations import scenery
from msgspec import structs

from fpnav.geometry import angular_distance
from fpnav.sensing.sight import panorama_sight
from fpnav.systems.placecell import Placecell, PlacecellParams
from fpnav.systems.placecell.assembly import signatures
from fpnav.systems.placecell.extract import features_of_frame, views_of
from fpnav.systems.placecell.params import LATE, PRESETS
from fpnav.values import Calibration, Decoded, Frame, Image, Pose2, Reference

PARAMS = PRESETS["fig7b"]


def frame(index: int = 0, *, heading: float = math.nan, **payloads: object) -> Frame:
    reference = Reference(index, index * 10**9, heading_rad=heading)
    return Frame(reference, {role: Decoded(value) for role, value in payloads.items()})


def camera(seed: int) -> Image:
    pixels = scenery(seed, 144, 720)[:, :192]
    return Image(np.ascontiguousarray(pixels), Calibration(192, 144, math.radians(60)))


def test_views_are_strongest_first_and_no_more_than_asked_for() -> None:
    rows, pixels = views_of(panorama_sight(Image(scenery(1)), 750), PARAMS)
    assert 5 < len(rows) <= 30
    assert pixels.shape == (len(rows), 256)
    assert (np.diff(rows["strength"]) <= 0).all()


def test_turning_the_panorama_turns_the_bearings_and_nothing_else() -> None:
    image = scenery(2, 120, 750)
    rows, pixels = views_of(panorama_sight(Image(image), 750), PARAMS)
    turned = np.ascontiguousarray(np.roll(image, 125, axis=1))
    again, same = views_of(panorama_sight(Image(turned), 750), PARAMS)
    assert np.abs(pixels.astype(int) - same).max() <= 1
    shifted = rows["bearing_rad"] - 2 * math.pi * 125 / 750
    assert angular_distance(again["bearing_rad"], shifted) == pytest.approx(0.0, abs=1e-5)
    assert again["elevation_rad"] == pytest.approx(rows["elevation_rad"])


def test_a_bright_spot_is_found_where_it_is() -> None:
    pixels = np.zeros((120, 720, 3), np.uint8)
    pixels[38:43, 178:183] = 255
    params = structs.replace(PARAMS, width=720)
    rows, _ = views_of(panorama_sight(Image(pixels), 720), params)
    assert len(rows) > 0
    near = np.degrees(angular_distance(rows["bearing_rad"], math.radians(180 - 90.25)))
    assert near.max() < 6.0
    assert np.degrees(rows["elevation_rad"]) == pytest.approx(9.75, abs=6.0)


def test_discs_stay_clear_of_the_upper_and_lower_border() -> None:
    rows, _ = views_of(panorama_sight(Image(scenery(3)), 750), PARAMS)
    reach = math.degrees(rows["elevation_rad"].max())
    assert reach < (62.6 - 20) * 360 / 750


def test_views_may_show_the_gradient_or_be_standardised() -> None:
    sight = panorama_sight(Image(scenery(4)), 750)
    plain = views_of(sight, PARAMS)[1]
    gradient = views_of(sight, structs.replace(PARAMS, patch_source="gradient"))[1]
    level = views_of(sight, structs.replace(PARAMS, patch_norm="meanstd"))[1]
    assert plain.shape == gradient.shape == level.shape
    assert level.mean(axis=1) == pytest.approx(127.5, abs=8)
    assert not np.array_equal(plain, gradient)


def test_an_image_of_nothing_gives_no_views() -> None:
    blank = Image(np.full((120, 720, 3), 80, np.uint8))
    found = features_of_frame(frame(panorama=blank), PARAMS)
    assert len(found["views"]) == len(found["pixels"]) == 0


def test_no_disc_touches_what_is_hidden() -> None:
    image = scenery(9, 120, 750)
    image[:, 300:500] = 90
    params = structs.replace(PARAMS, drop_hidden=True)
    rows, _ = views_of(panorama_sight(Image(image), 750), params)
    away = np.degrees(angular_distance(rows["bearing_rad"], math.radians(180 - 400 * 0.48)))
    assert len(rows) > 5
    assert away.min() >= (100 + 20) * 0.48


def test_a_frame_without_a_camera_gives_no_views() -> None:
    assert len(features_of_frame(frame(), PARAMS)["views"]) == 0


def test_the_panorama_goes_before_the_camera() -> None:
    both = frame(panorama=Image(scenery(5)), camera=camera(5))
    alone = frame(panorama=Image(scenery(5)))
    assert np.array_equal(
        features_of_frame(both, PARAMS)["pixels"], features_of_frame(alone, PARAMS)["pixels"]
    )


def test_a_panned_camera_sees_at_its_pan_angle() -> None:
    ahead = features_of_frame(frame(camera=camera(6), pan=0.0), PRESETS["fig8"])
    left = features_of_frame(frame(camera=camera(6), pan=1.0), PRESETS["fig8"])
    assert len(ahead["views"]) > 0
    turn = left["views"]["bearing_rad"] - ahead["views"]["bearing_rad"]
    assert turn == pytest.approx(1.0, abs=1e-5)
    assert (ahead["panned"][0], left["panned"][0]) == (True, True)


def sweep(count: int, params: PlacecellParams, **states: float) -> list[tuple]:
    out = []
    for number in range(count):
        one = frame(number, camera=camera(number), pan=0.1 * number, **states)
        out.append((one.reference, features_of_frame(one, params)))
    return out


def test_images_of_a_sweep_make_one_panorama() -> None:
    params = structs.replace(PRESETS["fig8"], streaming=False, images=3)
    images = sweep(7, params)
    made = list(signatures(iter(images), params))
    assert [one.reference.index for one in made] == [2, 5]
    assert int(made[0].record["images"]) == 3
    assert len(made[0].parts["views"]) == sum(len(f["views"]) for _, f in images[:3])


def test_streaming_images_complete_a_panorama_each() -> None:
    params = structs.replace(PRESETS["fig8"], images=3)
    made = list(signatures(iter(sweep(5, params)), params))
    assert [one.reference.index for one in made] == [2, 3, 4]
    assert set(made[0].parts["views"]["image"].tolist()) == {0, 1, 2}


def test_earlier_images_are_seen_from_the_present_heading() -> None:
    params = structs.replace(PRESETS["fig8"], images=2)
    images = sweep(2, params)
    turned = [(Reference(i, i, heading_rad=0.3 * i), f) for i, (_, f) in enumerate(images)]
    views = next(signatures(iter(turned), params)).parts["views"]
    old = views["bearing_rad"][views["image"] == 1]
    assert old == pytest.approx(images[0][1]["views"]["bearing_rad"] - 0.3, abs=1e-5)


def test_odometry_tells_the_turn_before_the_compass_does() -> None:
    params = structs.replace(PRESETS["fig8"], images=2)
    images = sweep(2, params)
    poses = [Pose2(0, 0, 0.0), Pose2(0, 0, 0.5)]
    turned = [
        (Reference(i, i, heading_rad=0.1 * i, odometry=poses[i]), f)
        for i, (_, f) in enumerate(images)
    ]
    views = next(signatures(iter(turned), params)).parts["views"]
    old = views["bearing_rad"][views["image"] == 1]
    assert old == pytest.approx(images[0][1]["views"]["bearing_rad"] - 0.5, abs=1e-5)


def test_a_sweep_does_not_reach_over_sessions() -> None:
    params = structs.replace(PRESETS["fig8"], images=2)
    images = sweep(3, params)
    split = [(Reference(i, i, session=int(i == 2)), f) for i, (_, f) in enumerate(images)]
    assert [one.reference.index for one in signatures(iter(split), params)] == [1]


def test_images_of_a_camera_that_does_not_pan_stand_alone() -> None:
    params = PRESETS["fig8"]
    one = frame(camera=camera(1))
    made = list(signatures(iter([(one.reference, features_of_frame(one, params))]), params))
    assert len(made) == 1


def test_table_1_is_in_the_presets() -> None:
    rows = {
        "fig3b": (1500, 0.8, 3, 4, 15, 32, 40, 0.8, 4, 0.33, 0.0, "linear", 0, 1.0),
        "fig4c": (1500, 0.8, 3, 4, 15, 32, 40, 0.8, 4, 0.33, 0.0, "linear", 4, 1.0),
        "fig7b": (750, 1.0, 1, 2, 5, 16, 20, 0.8, 4, 0.2, 1.0, "gaussian", 4, 0.25),
        "fig8": (1045, 0.8, 2, 4, 10, 16, 35, 0.8, 3, 0.33, 0.33, "gaussian", 18, 0.33),
    }
    for name, wanted in rows.items():
        p = PRESETS[name]
        found = (p.width, p.deriche, p.dog_sigma1, p.dog_sigma2, p.dog_size, p.patch_rows,
                 p.radius, p.rt, p.interpretations, p.rho_az, p.rho_el, p.diffusion, p.qmax,
                 p.rho_l)  # fmt: skip
        assert found == wanted
        assert p.patch_rows == p.patch_columns
    assert PRESETS["paper"] == PRESETS["fig4c"]


def test_what_acts_late_does_not_change_views() -> None:
    image = frame(panorama=Image(scenery(7)))
    late = structs.replace(PARAMS, rt=0.5, rho_az=0.1, qmax=1, heading="search")
    assert {"rt", "rho_az", "qmax", "heading"} <= LATE
    first, second = features_of_frame(image, PARAMS), features_of_frame(image, late)
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_the_picture_shows_the_views_in_the_order_of_the_panorama() -> None:
    system = Placecell(PARAMS)
    one = frame(panorama=Image(scenery(8)))
    signature = next(system.assemble([(one.reference, system.describe(one))]))
    picture = system.picture(signature)
    assert picture.kind == "grid"
    assert picture.values is not None
    assert picture.values.shape == (16, 16 * len(signature.parts["views"]))
    assert (np.diff(picture.bearings_rad) <= 0).all()
    assert picture.text == f"{len(signature.parts['views'])} views"
