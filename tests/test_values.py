"""Values decode once, say what is unknown, and keep their conventions."""

from __future__ import annotations

import math
import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from fpnav.values import Decoded, Frame, LaserScan, Pose2, Reference


def scan(ranges: list[float], mount: Pose2 | None = None) -> LaserScan:
    return LaserScan(
        np.array(ranges, dtype=np.float32),
        angle_min_rad=-math.pi / 2,
        angle_increment_rad=math.pi / 2,
        range_min_m=0.1,
        range_max_m=10.0,
        mount=mount or Pose2(0.0, 0.0, 0.0),
    )


class Counting:
    """A payload that knows how often it was decoded."""

    def __init__(self) -> None:
        self.times = 0

    def decode(self) -> str:
        self.times += 1
        return "seen"


def test_beams_point_from_the_first_angle_counter_clockwise() -> None:
    assert scan([1, 1, 1]).bearings_rad == pytest.approx([-math.pi / 2, 0.0, math.pi / 2])


def test_only_hits_within_the_limits_are_valid() -> None:
    beams = scan([math.nan, math.inf, -math.inf, 0.05, 0.1, 10.0, 10.5])
    assert beams.valid.tolist() == [False, False, False, False, True, True, False]


def test_points_stand_in_the_robot_frame_through_the_mount() -> None:
    beams = scan([2.0, math.inf, 1.0], mount=Pose2(1.0, 0.0, math.pi / 2))
    assert beams.points_m() == pytest.approx(np.array([[3.0, 0.0], [0.0, 0.0]]))


def test_a_field_of_view_is_one_increment_a_beam_and_at_most_a_turn() -> None:
    assert scan([1.0] * 3).field_of_view_rad == pytest.approx(1.5 * math.pi)
    assert scan([1.0] * 5).field_of_view_rad == pytest.approx(2.0 * math.pi)


def test_a_frame_decodes_a_role_once_and_only_when_asked() -> None:
    payload = Counting()
    frame = Frame(Reference(0, 0), {"camera": payload})
    assert payload.times == 0
    assert frame.camera == frame.camera == "seen"  # type: ignore[comparison-overlap]
    assert payload.times == 1


def test_a_role_without_a_message_is_none() -> None:
    frame = Frame(Reference(0, 0), {})
    slots = (frame.panorama, frame.omni, frame.camera, frame.camera_offset, frame.scan, frame.sonar)
    assert set(slots) == {None}
    assert frame.pan_rad is None


def test_every_slot_reads_its_own_role() -> None:
    roles = ("panorama", "omni", "camera", "camera_offset", "scan", "sonar", "pan")
    frame = Frame(Reference(0, 0), {role: Decoded(role) for role in roles})
    found = [
        frame.panorama, frame.omni, frame.camera, frame.camera_offset,
        frame.scan, frame.sonar, frame.pan_rad,
    ]  # fmt: skip
    assert found == list(roles)


def test_a_frame_travels_to_other_processes_undecoded() -> None:
    reference = Reference(3, 7, travelled_m=1.0, heading_rad=0.0)
    frame = Frame(reference, {"pan": Decoded(0.5)})
    assert frame.pan_rad == 0.5
    again = pickle.loads(pickle.dumps(frame))
    assert again.reference == reference
    assert again._cache == {}
    assert again.pan_rad == 0.5


def test_values_cannot_be_changed_behind_your_back() -> None:
    with pytest.raises(FrozenInstanceError):
        Pose2(0.0, 0.0, 0.0).x_m = 1.0  # type: ignore[misc]
