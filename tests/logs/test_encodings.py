"""One drive in every message encoding reads as the same frames."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import mcaps
from helpers.encodings import (
    CALIBRATION,
    ENCODERS,
    FOXGLOVE,
    FRAMES,
    MOUNT,
    Sent,
    descriptors,
    encoded_drive,
    foxglove_values,
    pose,
    scan,
)
from helpers.logs import START_NS, STEP_NS, jpeg

from fpnav.geometry import compose
from fpnav.logs import messages
from fpnav.logs.codecs import ChannelFacts, Codec
from fpnav.logs.container import Damaged
from fpnav.logs.decode import scan_of
from fpnav.logs.encodings import codec_for
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.values import Frame, Pose2


def same_pose(first: Pose2 | None, second: Pose2) -> bool:
    assert first is not None
    found = (first.x_m, first.y_m, first.heading_rad)
    return found == pytest.approx((second.x_m, second.y_m, second.heading_rad), abs=1e-6)


def check_scan(frame: Frame, number: int) -> None:
    expected = scan(number)
    assert frame.scan is not None
    assert np.array_equal(frame.scan.ranges_m, expected.ranges_m, equal_nan=True)
    assert frame.scan.bearings_rad == pytest.approx(expected.bearings_rad)
    assert frame.scan.valid.tolist() == [True, False, False, False, True]
    assert same_pose(frame.scan.mount, MOUNT)


def check_ros_roles(frame: Frame, number: int) -> None:
    """Roles that Foxglove has no schemas for."""
    assert frame.sonar is not None
    assert frame.sonar.ranges_m.tolist() == [0.5 + number]
    assert frame.sonar.mounts[0] == pytest.approx([MOUNT.x_m, MOUNT.y_m, MOUNT.heading_rad])
    assert frame.pan_rad == pytest.approx(0.2 * number)
    assert frame.reference.heading_rad == pytest.approx(0.1 * number)
    assert frame.reference.label == f"room {number}"


@pytest.mark.parametrize("encoding", ENCODERS)
@pytest.mark.parametrize("ingested", [False, True], ids=["as it is", "ingested"])
def test_every_role_reads_the_same(encoding: str, ingested: bool, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(encoded_drive(encoding))
    if ingested:
        done = ingest([path], tmp_path / "b.mcap")
        assert done.messages["scan"] == done.messages["camera"] == FRAMES
        path = tmp_path / "b.mcap"
    with open_log(path, strict=True) as log:
        frames = list(log.frames())
        calibration = log.calibrations["camera"]
    assert len(frames) == FRAMES
    for i, frame in enumerate(frames):
        assert frame.reference.stamp_ns == START_NS + i * STEP_NS
        assert same_pose(frame.reference.odometry, pose(i))
        assert same_pose(frame.reference.truth, pose(i))
        check_scan(frame, i)
        assert frame.camera is not None
        assert frame.camera.pixels.shape == (16, 32, 3)
        assert frame.camera_offset is not None
        assert (frame.camera_offset.pixels == i).all()
        if encoding not in FOXGLOVE:
            check_ros_roles(frame, i)
    assert calibration.horizontal_fov_rad == pytest.approx(CALIBRATION.horizontal_fov_rad)
    assert calibration.horizon_row == pytest.approx(CALIBRATION.horizon_row)
    assert same_pose(calibration.mount, MOUNT)


def facts_of(type_name: str, definition: bytes, encoding: str = "cdr") -> ChannelFacts:
    return ChannelFacts(encoding, type_name, "ros2msg" if encoding == "cdr" else "ros1msg",
                        definition)  # fmt: skip


LASER = messages.definition(messages.LASER_SCAN)


@pytest.mark.parametrize(
    ("row", "facts", "problem"),
    [
        ("C1", ChannelFacts("cdr", ""), "E301 no schema"),
        ("C5", facts_of(messages.LASER_SCAN, LASER.replace(b"range_max", b"reach")), "E302"),
        ("C5", facts_of(messages.LASER_SCAN, LASER.replace(b"32 range_max", b"64 range_max")),
         "E302"),
        ("C5", facts_of(messages.LASER_SCAN, LASER.replace(b"int32 sec", b"int64 sec")), "E302"),
        ("C5", facts_of("sensor_msgs/LaserScan", b"float32[] ranges", "ros1"), "E302"),
        ("C6", facts_of(messages.LASER_SCAN, b"float32 a\n" * 10_001), "E303 .* 10000 fields"),
        ("C6", facts_of(messages.LASER_SCAN, b"#" * (2**20 + 1)), "E303 definition of 1048577"),
        ("C7", ChannelFacts("cdr", "std_msgs/msg/Empty", "ros2msg"), "not used: std_msgs"),
        ("C8", ChannelFacts("flatbuffer", "foxglove.LaserScan"), "not decodable: .*flatbuffer"),
        ("C8", ChannelFacts("protobuf", "acme.Thing"), "not used: acme.Thing"),
        ("C6", ChannelFacts("protobuf", "foxglove.LaserScan", "protobuf", b"\xff" * 9), "E301"),
        ("C3", ChannelFacts("protobuf", "foxglove.LaserScan", "protobuf", b""), "E301"),
        ("C6", ChannelFacts("protobuf", "foxglove.LaserScan", "protobuf", b"x" * (2**20 + 1)),
         "E303"),
        ("C1", ChannelFacts("json", "", sample=b'{"speed": 3}'), "E301 no schema, and no type"),
        ("C1", ChannelFacts("json", "", sample=b"[1, 2]"), "E301 no schema, and no type"),
        ("C8", ChannelFacts("json", "acme.Thing"), "not used: acme.Thing"),
    ],
)  # fmt: skip
def test_a_channel_that_cannot_be_decoded_says_why(
    row: str, facts: ChannelFacts, problem: str
) -> None:
    found = codec_for(facts)
    assert isinstance(found, str)
    assert re.search(problem, found), found


def codec(facts: ChannelFacts) -> Codec:
    found = codec_for(facts)
    assert not isinstance(found, str), found
    return found


@pytest.mark.parametrize(
    "facts",
    [
        ChannelFacts("cdr", messages.LASER_SCAN, "ros2msg", b""),
        ChannelFacts("cdr", "sensor_msgs::msg::dds_::LaserScan_", "omgidl", b"module x {}"),
        ChannelFacts("cdr", "sensor_msgs/LaserScan", "ros2idl", b"whatever"),
        ChannelFacts("ros1", "sensor_msgs/LaserScan", "ros1msg", b""),
    ],
)
def test_a_known_type_without_a_definition_is_taken_for_the_standard_one(
    facts: ChannelFacts,
) -> None:
    assert codec(facts).assumed
    assert codec(facts).type_name == messages.LASER_SCAN


def test_comments_constants_and_defaults_make_no_difference() -> None:
    text = b"# a scan\nuint8 KIND=3\nstring NAME = x # y\n" + LASER.replace(
        b"float32 range_max", b"float32   range_max 10.0   # metres"
    )
    assert not codec(facts_of(messages.LASER_SCAN, text)).assumed


def test_nested_definitions_may_be_left_out() -> None:
    alone = LASER.split(b"=====", 1)[0]
    assert codec(facts_of(messages.LASER_SCAN, alone)).type_name == messages.LASER_SCAN


def test_a_later_release_that_added_a_field_is_read_by_its_own_definition() -> None:
    text = messages.definition(messages.RANGE, messages.JAZZY)
    store = messages.typestore(messages.JAZZY)
    head = messages.header(START_NS, "sonar")
    made = store.types[messages.RANGE](
        header=store.types["std_msgs/msg/Header"](stamp=head.stamp, frame_id="sonar"),
        radiation_type=0, field_of_view=0.4, min_range=0.1, max_range=5.0, range=1.5, variance=0.0,
    )  # fmt: skip
    data = bytes(store.serialize_cdr(made, messages.RANGE))
    for facts in (facts_of(messages.RANGE, text), ChannelFacts("cdr", messages.RANGE, "ros2idl")):
        assert codec(facts).decode(data).range == pytest.approx(1.5)


def test_old_names_of_types_are_known() -> None:
    assert codec(ChannelFacts("ros1", "tf/tfMessage", "ros1msg")).type_name == messages.TRANSFORMS


def payload() -> bytes:
    message = messages.laser_scan(START_NS, "laser", scan(0))
    return messages.serialize(message, messages.LASER_SCAN)


@pytest.mark.parametrize("head", [b"\x00\x02", b"\x00\x03", b"\x00\x07", b"\xff\xff", b""])
def test_other_encapsulations_are_never_guessed(head: bytes) -> None:
    data = head + payload()[2:] if head else b"\x00\x01"
    with pytest.raises(Damaged) as caught:
        codec(facts_of(messages.LASER_SCAN, LASER)).decode(data)
    assert caught.value.code == "E304"
    with pytest.raises(Damaged):
        codec(facts_of(messages.LASER_SCAN, LASER)).stamp(data)


def test_a_payload_cut_anywhere_is_refused() -> None:
    data = payload()
    for cut in range(4, len(data) - 3):
        with pytest.raises(Damaged) as caught:
            codec(facts_of(messages.LASER_SCAN, LASER)).decode(data[:cut])
        assert caught.value.code == "E305", cut


def test_a_sequence_longer_than_its_payload_is_refused_before_it_is_made() -> None:
    data = bytearray(payload())
    at = data.index((5).to_bytes(4, "little"), 30)
    data[at : at + 4] = b"\xff\xff\xff\xff"
    with pytest.raises(Damaged, match="Invalid sequence length 4294967295"):
        codec(facts_of(messages.LASER_SCAN, LASER)).decode(bytes(data))


def test_a_frame_name_that_is_not_text_is_mended() -> None:
    data = payload().replace(b"laser", b"las\xff\xfe")
    found = codec(facts_of(messages.LASER_SCAN, LASER)).decode(data)
    assert found.header.frame_id == "las??"


def test_trailing_bytes_beyond_padding_are_another_type() -> None:
    found = codec(facts_of(messages.LASER_SCAN, LASER))
    assert found.decode(payload() + b"\0\0\0").header.frame_id == "laser"
    with pytest.raises(Damaged, match="size mismatch"):
        found.decode(payload() + b"\0" * 8)


def json_scan(**changes: Any) -> bytes:
    sent = Sent("/laser", messages.LASER_SCAN, START_NS, scan(0))
    return json.dumps({**foxglove_values(sent), **changes}).encode()


def test_json_without_a_schema_is_told_by_its_keys() -> None:
    found = codec(ChannelFacts("json", "", sample=json_scan()))
    assert found.type_name == messages.LASER_SCAN
    assert found.assumed


def test_json_numbers_may_be_null_or_spelled_out() -> None:
    found = codec(ChannelFacts("json", "foxglove.LaserScan", "jsonschema", b"{}"))
    ranges = found.decode(json_scan(ranges=[1, None, "Infinity", "-Infinity", "NaN"])).ranges
    assert np.array_equal(ranges, [1, np.nan, np.inf, -np.inf, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b'{"timestamp": {"sec": 1, "nsec": 2}}',
        b'{"timestamp": {"sec": 1, "sec": 2}}',
        b"[" * 100_000,
        json_scan(timestamp={"sec": float("inf"), "nsec": 0}),
        json_scan(timestamp=None),
        json_scan(ranges="none"),
        json_scan(start_angle={}),
    ],
)
def test_json_that_is_none_or_lacks_fields_is_refused(data: bytes) -> None:
    found = codec(ChannelFacts("json", "foxglove.LaserScan", "jsonschema", b"{}"))
    with pytest.raises(Damaged) as caught:
        found.decode(data)
    assert caught.value.code == "E306"


def test_ros_types_spelled_as_json_are_read() -> None:
    stamp = {"sec": 5, "nanosec": 7}
    image = base64.b64encode(jpeg()).decode()
    found = codec(ChannelFacts("json", "sensor_msgs/msg/CompressedImage", "jsonschema", b"{}"))
    data = {"header": {"stamp": stamp, "frame_id": "eye"}, "format": "jpeg", "data": image}
    assert found.stamp(json.dumps(data).encode()) == 5_000_000_007
    assert found.decode(json.dumps(data).encode()).data == jpeg()
    scan_codec = codec(ChannelFacts("json", "sensor_msgs/LaserScan", "jsonschema", b"{}"))
    old = {"header": {"stamp": {"secs": 5, "nsecs": 7}}, "ranges": [1.5, None]}
    assert scan_codec.stamp(json.dumps(old).encode()) == 5_000_000_007
    assert np.isnan(scan_codec.decode(json.dumps(old).encode()).ranges[1])


def test_a_foxglove_scan_stands_at_its_pose_within_its_frame() -> None:
    origin = {
        "position": {"x": 1.0, "y": 0.0, "z": 0.0},
        "orientation": {"x": 0, "y": 0, "z": 0.5**0.5, "w": 0.5**0.5},
    }
    found = codec(ChannelFacts("json", "foxglove.LaserScan", "jsonschema", b"{}"))
    mount = scan_of(found.decode(json_scan(pose=origin)), MOUNT).mount
    assert same_pose(mount, compose(MOUNT, Pose2(1.0, 0.0, np.pi / 2)))


def test_foxglove_odometry_carries_speeds() -> None:
    value = {
        "timestamp": {"sec": 5, "nsec": 7}, "frame_id": "odom", "body_frame_id": "base_link",
        "pose": foxglove_values(Sent("", messages.POSE, 0, pose(2)))["pose"],
        "linear_velocity": {"x": 0.4, "y": 0, "z": 0}, "angular_velocity": {"x": 0, "y": 0, "z": 1},
    }  # fmt: skip
    found = codec(ChannelFacts("json", "", sample=json.dumps(value).encode()))
    assert found.type_name == messages.ODOMETRY
    assert found.decode(json.dumps(value).encode()).twist.twist.linear.x == 0.4
    del value["linear_velocity"]
    assert found.decode(json.dumps(value).encode()).twist.twist.linear.x == 0.0


def test_damaged_protobuf_is_refused() -> None:
    definition = descriptors().SerializeToString()
    facts = ChannelFacts("protobuf", "foxglove.LaserScan", "protobuf", definition)
    for data in (b"\xff\xff\xff", b"\x0a\x7f\x01"):
        with pytest.raises(Damaged) as caught:
            codec(facts).decode(data)
        assert caught.value.code == "E305"


def test_two_encodings_of_one_type_share_a_topic(tmp_path: Path) -> None:
    laser = mcaps.schema(1, messages.LASER_SCAN, LASER)
    other = mcaps.schema(2, "foxglove.LaserScan", b"{}", "jsonschema")
    channels = mcaps.channel(1, "/scan", 1, "cdr") + mcaps.channel(2, "/scan", 2, "json")
    sent = [mcaps.message(1, START_NS, payload()), mcaps.message(2, START_NS + 1, json_scan(
        timestamp={"sec": START_NS // 10**9, "nsec": 1}))]  # fmt: skip
    (tmp_path / "a.mcap").write_bytes(mcaps.whole(laser, other, channels, *sent))
    with open_log(tmp_path / "a.mcap") as log:
        assert len(list(log.frames())) == 2
