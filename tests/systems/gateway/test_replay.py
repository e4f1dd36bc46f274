"""From frames to signatures of gateways."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.hallways import Box, outline, ring_at, straight
from numpy.typing import NDArray

from fpnav.geometry import compose
from fpnav.systems.gateway import Gateway, GatewayParams
from fpnav.systems.gateway.params import PRESETS
from fpnav.systems.gateway.types import NAMES
from fpnav.values import (
    Calibration,
    Decoded,
    Frame,
    Image,
    LaserScan,
    Pose2,
    Reference,
    Signature,
)

WALLS = outline([(0, -1, 20, 1), (5, -6, 7, -1), (11, 1, 13, 6)])
POSES = straight(Pose2(1.0, 0.0, 0.0), 15.0)
FOV_RAD = math.radians(60.0)


def picture(x_px: int, *, mount: Pose2 | None = None) -> Image:
    """A dark post 20 pixels wide."""
    pixels = np.full((480, 480, 3), 150, np.uint8)
    pixels[100:400, x_px : x_px + 20] = 20
    calibration = Calibration(
        480, 480, horizontal_fov_rad=FOV_RAD, mount=mount or Pose2(0.0, 0.0, 0.0)
    )
    return Image(pixels, calibration)


def frames(
    roles: Sequence[str], *, odometry: bool = True, session: int = 0, poses: Sequence[Pose2] = POSES
) -> list[Frame]:
    made = []
    for index, pose in enumerate(poses):
        ring = ring_at(WALLS, pose)
        scan = LaserScan(ring.ranges_m, 0.0, 2 * math.pi / 24, 0.02, 6.0)
        values = {
            "sonar": ring,
            "scan": scan,
            "camera": picture(40 + 3 * index),
            "camera_offset": picture(10 + 3 * index, mount=Pose2(0.0, -0.12, 0.0)),
        }
        reference = Reference(
            index,
            index * 250_000_000,
            session=session,
            travelled_m=0.1 * index if odometry else math.nan,
            odometry=pose if odometry else None,
        )
        made.append(Frame(reference, {role: Decoded(values[role]) for role in roles}))
    return made


def signatures(made: Sequence[Frame], params: GatewayParams | None = None) -> list[Signature]:
    system = Gateway(params or GatewayParams())
    return list(system.assemble((frame.reference, system.describe(frame)) for frame in made))


def types(found: Sequence[Signature]) -> list[str]:
    return [NAMES[int(one.record["type"])] for one in found]


@pytest.mark.parametrize("preset", ["paper", "default"])
def test_a_scene_is_taken_at_every_gateway(preset: str) -> None:
    found = signatures(frames(["sonar", "camera", "camera_offset"]), PRESETS[preset])
    assert types(found) == ["RIGHT OPENING", "LEFT OPENING"]
    for one, centre in zip(found, (6.0, 12.0), strict=True):
        assert one.reference.odometry is not None
        assert one.reference.odometry.x_m == pytest.approx(centre, abs=0.11)
        place = compose(one.reference.odometry, Pose2(one.record["x_m"], one.record["y_m"], 0.0))
        assert place.x_m == pytest.approx(centre, abs=0.06)
        assert one.record["facings"] == 1
        assert one.parts["cues"]["direction"].tolist() == [-1, 1]
        expected = 40 + 3 * one.reference.index
        assert one.parts["cues"]["x_px"][0] == pytest.approx(expected - 1, abs=1.0)
        assert one.parts["cues"]["distance_m"] == pytest.approx([415.7 * 0.12 / 30] * 2, rel=0.02)


def test_sonar_alone_gives_types_and_no_cues() -> None:
    found = signatures(frames(["sonar"]))
    assert types(found) == ["RIGHT OPENING", "LEFT OPENING"]
    assert [int(one.record["facings"]) for one in found] == [0, 0]
    assert all(len(one.parts["cues"]) == 0 for one in found)


def test_a_laser_stands_in_for_sonar() -> None:
    sparse = GatewayParams(sonars=24, cone_deg=15.0)
    found = signatures(frames(["scan"]), sparse)
    assert types(found) == ["RIGHT OPENING", "LEFT OPENING"]


def test_a_camera_alone_gives_a_scene_every_metre() -> None:
    found = signatures(frames(["camera"]))
    assert types(found) == [""] * 16
    travelled = [one.reference.travelled_m for one in found]
    assert travelled == pytest.approx([float(metre) for metre in range(16)], abs=0.11)
    assert np.isnan(found[0].parts["cues"]["distance_m"]).all()


def test_pictures_without_odometry_are_all_kept() -> None:
    assert len(signatures(frames(["camera"], odometry=False)[:20])) == 20


def test_scenes_at_regular_spacing_are_an_option() -> None:
    params = GatewayParams(keep="spacing", spacing_m=2.0, look="always")
    assert len(signatures(frames(["sonar", "camera"]), params)) == 8


def test_without_odometry_a_speed_is_assumed() -> None:
    made = frames(["sonar"], odometry=False)
    assert types(signatures(made, GatewayParams(speed_mps=0.4))) == [
        "RIGHT OPENING",
        "LEFT OPENING",
    ]


def test_pictures_are_looked_at_only_where_a_side_is_open() -> None:
    system = Gateway(GatewayParams())
    looked = [
        int(system.describe(frame)["facing"][0]) == 0 for frame in frames(["sonar", "camera"])
    ]
    assert not any(looked[:30])
    assert all(looked[48:52])


def test_a_panning_camera_gives_a_scene_in_every_direction() -> None:
    made = []
    for index, frame in enumerate(frames(["sonar", "camera"])):
        pan = math.radians(45.0 * (index % 3 - 1))
        made.append(Frame(frame.reference, {**frame.payloads, "pan": Decoded(pan)}))
    found = signatures(made, GatewayParams(look="always"))
    assert [int(one.record["facings"]) for one in found] == [0b10000011] * 2
    assert set(found[0].parts["cues"]["facing"].tolist()) == {0, 1, 7}


def test_sessions_do_not_run_into_each_other() -> None:
    first, second = frames(["sonar"])[:60], frames(["sonar"], session=1)
    found = signatures([*first, *second])
    assert [one.reference.session for one in found] == [0, 1, 1]


def test_a_drop_out_of_the_ring_is_no_scene() -> None:
    made = frames(["sonar", "camera"])
    made[20] = Frame(made[20].reference, {"camera": made[20].payloads["camera"]})
    assert types(signatures(made)) == ["RIGHT OPENING", "LEFT OPENING"]


def test_gateways_come_in_travel_order() -> None:
    boxes: list[Box] = [(0, -1, 30, 1), (5, -6, 10, -1), (6, 1, 7.5, 6), (12, -6, 13.5, -1)]
    walls = outline(boxes)
    made = [
        Frame(
            Reference(i, i, travelled_m=0.1 * i, odometry=pose),
            {"sonar": Decoded(ring_at(walls, pose))},
        )
        for i, pose in enumerate(straight(Pose2(1.0, 0.0, 0.0), 20.0))
    ]
    order = [one.reference.index for one in signatures(made)]
    assert order == sorted(set(order))
    assert len(order) >= 2


def test_the_picture_counts_cues_per_cell() -> None:
    system = Gateway(GatewayParams())
    found = signatures(frames(["sonar", "camera"]))
    drawn = system.picture(found[0])
    assert drawn.kind == "grid"
    assert drawn.text == "RIGHT OPENING"
    values: NDArray[np.float64] | None = drawn.values
    assert values is not None
    assert values.shape == (5, 5)
    assert values.sum() == 6.0
