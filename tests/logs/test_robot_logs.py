"""What robots really record: poses on /tf alone, many cameras, sensors that say nothing."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path

import cv2
import numpy as np
import pytest
from helpers import encodings
from helpers import robot_logs as robot
from helpers.commands import run
from mcap.writer import Writer

from fpnav.errors import LogError
from fpnav.logs import messages
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.sources.base import SourceOptions
from fpnav.values import Pose2

STEPS = 25


def _close(found: Pose2 | None, expected: Pose2) -> bool:
    return found is not None and astuple(found) == pytest.approx(astuple(expected))


def _poses_on_tf(path: Path, parent: str, *, odometry: bool = False) -> Path:
    """Scans, mounts, and the robot's pose in a frame on /tf, each sent twice."""
    sent = [(robot.at(0), robot.transform(robot.at(0), "base_link", "laser", Pose2(0.2, 0, 0),
                                          "/tf_static"))]  # fmt: skip
    for step in range(STEPS):
        now = robot.at(step)
        sent.append((now, robot.scan(now)))
        pose = robot.transform(now, parent, "base_link", Pose2(0.1 * step, 0.5, 0.01 * step))
        sent += [(now, pose), (now + 1000, pose)]
        sent.append((now, robot.transform(now, "left_wheel", "left_tyre", Pose2(0, 0, 0))))
        if odometry:
            sent.append((now, robot.odometry(now, 0.2 * step)))
    return robot.write(path, sent)


def test_the_transform_from_odom_is_the_odometry_of_a_log_without(tmp_path: Path) -> None:
    with open_log(_poses_on_tf(tmp_path / "a.mcap", "odom"), strict=True) as log:
        references = log.references()
        assert log.roles["odometry"].topics == ("/tf#odom",)
        assert log.roles["odometry"].messages == STEPS
    assert _close(references[3].odometry, Pose2(0.3, 0.5, 0.03))
    assert references[-1].travelled_m == pytest.approx(2.4)
    done = ingest([tmp_path / "a.mcap"], tmp_path / "b.mcap")
    assert done.messages == {"odometry": STEPS, "scan": STEPS}
    with open_log(tmp_path / "b.mcap", strict=True) as log:
        assert _close(log.references()[3].odometry, Pose2(0.3, 0.5, 0.03))


def test_odometry_messages_come_before_transforms(tmp_path: Path) -> None:
    with open_log(_poses_on_tf(tmp_path / "a.mcap", "odom", odometry=True)) as log:
        assert log.roles["odometry"].topics == ("/odom",)
        assert "/tf#odom" not in log.topics


def test_a_pose_in_the_map_is_what_the_user_says_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = _poses_on_tf(tmp_path / "a.mcap", "map")
    told = run(capsys, "info", path).out
    assert "no truth; if one of these is:\n  --topic truth=/tf#map\n" in told
    done = ingest([path], tmp_path / "b.mcap", options=SourceOptions(topics={"truth": "/tf#map"}))
    assert done.messages == {"scan": STEPS, "truth": STEPS}


@pytest.mark.parametrize("encoding", encodings.FOXGLOVE)
def test_foxglove_transforms_give_poses_too(encoding: str, tmp_path: Path) -> None:
    kind, encode = encodings.ENCODERS[encoding]
    with open(tmp_path / "a.mcap", "wb") as stream:
        writer = Writer(stream)
        writer.start()
        channels: dict[str, int] = {}
        for sent in encodings.drive(ros=False):
            value = {"base_link": sent.value} if sent.topic == "/odom" else sent.value
            moved = encodings.Sent("/tf", messages.TRANSFORMS, sent.stamp_ns, value)
            sent = moved if sent.topic == "/odom" else sent
            name, schema_kind, schema, data = encode(sent)
            if sent.topic == "/tf":
                data = data.replace(b"base_link", b"odom_base", 1)
            if sent.topic not in channels:
                number = writer.register_schema(name, schema_kind, schema)
                channels[sent.topic] = writer.register_channel(sent.topic, kind, number)
            writer.add_message(channels[sent.topic], sent.stamp_ns, data, sent.stamp_ns)
        writer.finish()
    with open_log(tmp_path / "a.mcap") as log:
        assert log.roles["odometry"].topics == ("/tf#odom_base",)
        assert log.roles["odometry"].messages == encodings.FRAMES
        assert _close(log.references()[2].odometry, encodings.pose(2))


def _cameras(path: Path, *names: str) -> Path:
    sent = [(robot.at(i), robot.picture(robot.at(i), n)) for i in range(3) for n in names]
    return robot.write(path, sent)


@pytest.mark.parametrize(
    ("names", "camera", "offset"),
    [
        (("/CAM_BACK/image", "/CAM_FRONT/image", "/CAM_FRONT_LEFT/image", "/CAM_FRONT_RIGHT/image",
          "/CAM_BACK_RIGHT/image"), "/CAM_FRONT/image", None),
        (("/stereo/right/image", "/stereo/left/image"), "/stereo/left/image",
         "/stereo/right/image"),
        (("/a/left/image", "/a/right/image", "/b/right/image"), "/a/left/image", "/a/right/image"),
        (("/right/image",), "/right/image", None),
        (("/camera", "/camera_offset", "/right/image"), "/camera", "/camera_offset"),
    ],
)  # fmt: skip
def test_the_front_camera_is_chosen_and_only_its_own_offset(
    names: tuple[str, ...], camera: str, offset: str | None, tmp_path: Path
) -> None:
    with open_log(_cameras(tmp_path / "a.mcap", *names)) as log:
        assert log.roles["camera"].topics == (camera,)
        found = log.roles.get("camera_offset")
        assert (found.topics[0] if found else None) == offset


def test_what_a_depth_camera_sends_is_offered_not_assumed(tmp_path: Path) -> None:
    depth = cv2.imencode(".png", np.full((8, 8), 900, np.uint16))[1].tobytes()
    sent = robot.picture(robot.at(0), "/kinect/compressedDepth", bytes(12) + depth, "16UC1")
    path = robot.write(tmp_path / "a.mcap", [(robot.at(0), sent)])
    with pytest.raises(LogError, match=r"E206 .*name it: --topic camera=/kinect/compressedDepth"):
        ingest([path], tmp_path / "b.mcap")


def test_poses_alone_are_no_recording(tmp_path: Path) -> None:
    sent = [(robot.at(i), robot.odometry(robot.at(i), 0.1 * i)) for i in range(3)]
    path = robot.write(tmp_path / "a.mcap", sent)
    with pytest.raises(LogError, match=r"E206 no topic a frame can stand on .*nav_msgs"):
        ingest([path], tmp_path / "b.mcap")


def test_sensors_that_say_nothing_do_not_spoil_a_log_and_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = []
    for step in range(STEPS):
        now = robot.at(step)
        every = (robot.scan(now), robot.imu(now, 0.1, valid=False), robot.wheels(now),
                 robot.odometry(now, 0.1, valid=False))  # fmt: skip
        sent += [(now, one) for one in every]
    path = robot.write(tmp_path / "a.mcap", sent)
    done = run(capsys, "ingest", path, "-o", tmp_path / "b.mcap")
    assert done.code == 0
    assert "note E508: /joint_states: no pan joint among" in done.err
    assert "no message can be used (2 times)" in done.err
    assert "scan 25" in done.err.splitlines()[-1]
    checked = run(capsys, "check", path)
    assert f"E504  /odom: none of {STEPS} messages can be used" in checked.out
    assert "WARN  decodable    E504  /odom" in checked.out
    assert "note  decodable    E504  /imu" in checked.out
    told = run(capsys, "info", path)
    assert f"E504 none of {STEPS} messages can be used" in told.out
