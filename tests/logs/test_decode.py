"""Rows D and E of the fault catalogue: what sensors and frames get wrong."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace as Shape
from typing import Any

import numpy as np
import pytest
from helpers.logs import START_NS, STEP_NS, scan, write_log

from fpnav.logs import messages
from fpnav.logs.container import Damaged
from fpnav.logs.decode import heading_of, pan_of, pose_of, range_limits, scan_of, yaw_of
from fpnav.logs.frames import open_log
from fpnav.logs.transforms import TransformTree
from fpnav.logs.writer import LogWriter
from fpnav.values import LaserScan, Pose2


def laser(**changes: Any) -> Any:
    made = messages.laser_scan(START_NS, "laser", LaserScan(
        np.array([1, 2, 3], np.float32), -0.5, 0.5, 0.1, 10.0))  # fmt: skip
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def test_e1_special_values_stay_apart() -> None:
    values = np.array([np.nan, np.inf, -np.inf, 0.0, 0.05, 5.0, 50.0], np.float32)
    found = scan_of(laser(ranges=values))
    assert np.array_equal(found.ranges_m, values, equal_nan=True)
    assert found.valid.tolist() == [False, False, False, False, False, True, False]


def test_e2_scans_of_other_sizes_are_kept(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        for i, beams in enumerate([720, 719, 721, 720]):
            writer.scan(START_NS + i * STEP_NS, scan(beams))

    with open_log(write_log(tmp_path / "a.mcap", fill), strict=True) as log:
        assert [len(f.scan.ranges_m) for f in log.frames() if f.scan] == [720, 719, 721, 720]


def test_e3_the_increment_counts_and_not_the_last_angle() -> None:
    assert scan_of(laser(angle_max=99.0)).bearings_rad.tolist() == [-0.5, 0.0, 0.5]


def test_e4_a_clockwise_scan_is_reversed() -> None:
    found = scan_of(laser(angle_min=0.5, angle_increment=-0.5))
    assert found.bearings_rad.tolist() == [-0.5, 0.0, 0.5]
    assert found.ranges_m.tolist() == [3, 2, 1]


@pytest.mark.parametrize(
    ("code", "changes"),
    [
        ("E501", {"angle_increment": 0.0}),
        ("E501", {"angle_increment": math.nan}),
        ("E501", {"angle_min": math.inf}),
        ("E502", {"ranges": np.zeros(0, np.float32)}),
    ],
)
def test_e4_e6_a_scan_without_a_geometry_is_refused(code: str, changes: dict[str, Any]) -> None:
    with pytest.raises(Damaged) as caught:
        scan_of(laser(**changes))
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ((0.1, 10.0), (0.1, 10.0)),
        ((0.0, 0.0), (0.0, math.inf)),
        ((5.0, 1.0), (0.0, math.inf)),
        ((math.nan, 3.0), (0.0, math.inf)),
        ((-1.0, 3.0), (0.0, 3.0)),
    ],
)
def test_e5_limits_that_contradict_are_none(
    given: tuple[float, float], expected: tuple[float, float]
) -> None:
    assert range_limits(*given) == expected


def test_e7_intensities_of_another_length_are_ignored() -> None:
    assert len(scan_of(laser(intensities=np.ones(99, np.float32))).ranges_m) == 3


def transform(parent: str, child: str, x: float, turn: tuple[float, ...]) -> Any:
    rotation = Shape(**dict(zip("xyzw", turn, strict=True)))
    return Shape(
        header=Shape(frame_id=parent),
        child_frame_id=child,
        transform=Shape(translation=Shape(x=x, y=0.0, z=0.2), rotation=rotation),
    )


LEVEL = (0.0, 0.0, 0.0, 1.0)
ROLLED = (1.0, 0.0, 0.0, 0.0)


def test_e8_a_sensor_upside_down_is_mirrored() -> None:
    tree = TransformTree()
    tree.add([transform("base_link", "laser", 0.3, ROLLED)])
    found = tree.mount("laser")
    assert found == (Pose2(pytest.approx(0.3), 0.0, 0.0), True)
    mirrored = scan_of(laser(), Pose2(0.3, 0, 0), flipped=True)
    assert mirrored.ranges_m.tolist() == [3, 2, 1]
    assert mirrored.bearings_rad.tolist() == [-0.5, 0.0, 0.5]


def test_e9_a_leading_slash_makes_no_difference() -> None:
    tree = TransformTree()
    tree.add([transform("/base_link", "/laser", 0.3, LEVEL)])
    assert tree.mount("laser") == tree.mount("/laser") is not None


def test_e10_chains_resolve_and_loops_and_gaps_do_not() -> None:
    tree = TransformTree()
    tree.add([transform("base_link", "plate", 0.1, LEVEL), transform("plate", "laser", 0.2, LEVEL)])
    tree.add([transform("a", "b", 1.0, LEVEL), transform("b", "a", 1.0, LEVEL)])
    tree.add([transform("x", "x", 1.0, LEVEL)])
    assert tree.mount("laser") == (Pose2(pytest.approx(0.3), 0.0, 0.0), False)
    assert tree.mount("robot1/base_link") == (Pose2(0.0, 0.0, 0.0), False)
    for frame in ("a", "x", "", "nowhere"):
        assert tree.mount(frame) is None


def test_an_optical_frame_looks_along_its_z_axis() -> None:
    tree = TransformTree()
    tree.add([transform("base_link", "eye_optical", 0.1, (-0.5, 0.5, -0.5, 0.5))])
    mount, upside_down = tree.mount("eye_optical") or (Pose2(9, 9, 9), True)
    assert mount.heading_rad == pytest.approx(0.0)
    assert not upside_down


def quaternion(length: float, yaw_rad: float = 0.3) -> Any:
    half = yaw_rad / 2
    return Shape(x=0.0, y=0.0, z=length * math.sin(half), w=length * math.cos(half))


@pytest.mark.parametrize("length", [1.0, 1.0005, 0.9995])
def test_e11_nearly_unit_quaternions_are_taken(length: float) -> None:
    assert heading_of(quaternion(length)) == pytest.approx(0.3)


@pytest.mark.parametrize("length", [0.0, 0.9, 1.1, math.nan])
def test_e11_others_are_refused(length: float) -> None:
    with pytest.raises(Damaged, match="quaternion of length"):
        heading_of(quaternion(length))


def test_e11_a_pose_that_is_no_number_is_refused() -> None:
    made = messages.odometry(START_NS, Pose2(math.nan, 0, 0), 0.0, 0.0)
    with pytest.raises(Damaged, match="position"):
        pose_of(messages.ODOMETRY, made)


def test_an_imu_without_orientation_has_no_heading() -> None:
    made = messages.imu(START_NS, 0.5)
    assert yaw_of(made) == pytest.approx(0.5)
    made.orientation_covariance[0] = -1.0
    with pytest.raises(Damaged, match="gives no orientation"):
        yaw_of(made)


@pytest.mark.parametrize(
    ("names", "positions", "expected"),
    [
        (["pan"], [0.5], 0.5),
        (["turret"], [0.5], 0.5),
        (["wheel", "camera_pan"], [9.0, 0.5], 0.5),
        (["left_wheel", "right_wheel"], [1.0, 2.0], None),
        (["pan"], [], None),
        ([], [], None),
    ],
)
def test_the_pan_joint_is_told_by_its_name(
    names: list[str], positions: list[float], expected: float | None
) -> None:
    made = Shape(name=names, position=np.array(positions))
    if expected is not None:
        assert pan_of(made) == expected
        return
    with pytest.raises(Damaged, match="no pan joint"):
        pan_of(made)


def test_e15_a_ring_with_a_silent_transducer_is_marked(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        for i in range(4):
            for number in range(3):
                if (i, number) != (2, 1):
                    made = messages.sonar_range(
                        START_NS + i * STEP_NS, f"s{number}", 1.0 + number, 0.4, 0.1, 5.0
                    )
                    writer.message(f"/us/{number}", messages.RANGE, made, START_NS + i, None)

    with open_log(write_log(tmp_path / "a.mcap", fill)) as log:
        rings = [frame.sonar for frame in log.frames()]
    assert np.isnan(rings[2].ranges_m).tolist() == [False, True, False]
    assert not np.isnan(rings[3].ranges_m).any()


def test_d_damaged_images_are_counted_and_their_frames_left_out(tmp_path: Path) -> None:
    from helpers.logs import jpeg

    def fill(writer: LogWriter) -> None:
        for i in range(5):
            data = jpeg() if i != 3 else jpeg()[:-2]
            writer.image("camera", START_NS + i * STEP_NS, data)

    with open_log(write_log(tmp_path / "a.mcap", fill), max_loss=0.5) as log:
        assert [frame.reference.index for frame in log.frames()] == [0, 1, 2, 4]
        assert log.ledger.topic("/camera").skipped == {"E406": 1}
        assert log.ledger.topic("/camera").in_file == 5
