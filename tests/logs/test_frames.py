"""A log that was written comes back as the frames it was made of."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from helpers.logs import START_NS, STEP_NS, drive, jpeg, scan, write_log

from fpnav.errors import LogError, UsageError
from fpnav.logs.frames import open_log
from fpnav.logs.writer import LogWriter
from fpnav.values import Pose2


def test_every_role_comes_back_at_every_frame(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap")) as log:
        frames = list(log.frames())
        assert log.primary == "panorama"
        assert set(log.roles) == {
            "panorama", "scan", "sonar", "odometry", "heading", "truth", "label",
        }  # fmt: skip
        assert log.integrity == "verified"
        assert log.ledger.worst() == ("", 0.0)
    assert len(frames) == 12
    last = frames[-1]
    assert last.reference.stamp_ns == START_NS + 11 * STEP_NS
    assert last.reference.odometry == Pose2(pytest.approx(1.1), 0.0, 0.0)
    assert last.reference.truth == Pose2(
        pytest.approx(1.1), pytest.approx(0.5), pytest.approx(0.11)
    )
    assert last.reference.heading_rad == pytest.approx(0.11)
    assert last.reference.travelled_m == pytest.approx(1.1)
    assert last.scan is not None
    assert last.scan.mount == Pose2(pytest.approx(0.2), 0.0, 0.0)
    assert np.allclose(last.scan.ranges_m, 2.1)
    assert last.sonar is not None
    assert np.allclose(last.sonar.ranges_m, 1.11)
    assert np.allclose(last.sonar.mounts[1], [0.0, 0.2, math.pi / 2], atol=1e-9)


def test_labels_hold_from_their_log_time_on(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap")) as log:
        labels = [frame.reference.label for frame in log.frames()]
    assert labels == ["hall"] * 6 + ["office"] * 6


def test_images_decode_when_asked_for_and_after_pickling(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap")) as log:
        frame = next(iter(log.frames()))
    again = pickle.loads(pickle.dumps(frame))
    image = again.panorama
    assert image.pixels.shape == (16, 32, 3)
    assert image.calibration.vertical_fov_rad == pytest.approx(0.8)
    assert image.calibration.horizon_row == pytest.approx(7.5)
    assert again.camera is None


def test_thinning_keeps_frames_a_step_apart(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap")) as log:
        indices = [frame.reference.index for frame in log.frames(step_m=0.25)]
        assert log.ledger.topic("/panorama").skipped["thinned"] == 8
        assert log.ledger.topic("/panorama").in_file == 12
    assert indices == [0, 3, 6, 9]


def test_thinning_by_heading_goes_by_the_pose_of_travel(tmp_path: Path) -> None:
    def turn(writer: LogWriter) -> None:
        for i in range(10):
            stamp = START_NS + i * STEP_NS
            writer.odometry(stamp, Pose2(0.0, 0.0, 0.1 * i))
            writer.scan(stamp, scan())

    with open_log(write_log(tmp_path / "a.mcap", turn)) as log:
        kept = [frame.reference.index for frame in log.frames(1.0, 0.29)]
    assert kept == [0, 3, 6, 9]


def test_session_goes_into_the_references(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap"), session=3) as log:
        assert {reference.session for reference in log.references()} == {3}


def test_path_length_goes_by_truth_where_there_is_no_odometry(tmp_path: Path) -> None:
    def walk(writer: LogWriter) -> None:
        for i in range(5):
            writer.truth(START_NS + i * STEP_NS, Pose2(0.0, 2.0 * i, 0.0))
            writer.image("camera", START_NS + i * STEP_NS, jpeg())

    with open_log(write_log(tmp_path / "a.mcap", walk)) as log:
        assert log.travelled_from == "truth"
        assert log.references()[-1].travelled_m == pytest.approx(8.0)


def test_a_topic_can_be_left_out_and_the_next_role_leads(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap"), {"panorama": ""}) as log:
        assert log.primary == "scan"
        assert next(iter(log.frames())).panorama is None


def test_frames_can_stand_on_a_sensor_that_speaks_more_often(tmp_path: Path) -> None:
    def stop_and_look(writer: LogWriter) -> None:
        for i in range(9):
            stamp = START_NS + i * STEP_NS
            writer.scan(stamp, scan())
            if i in (4, 5):
                writer.image("camera", stamp, jpeg())

    path = write_log(tmp_path / "a.mcap", stop_and_look)
    with open_log(path) as log:
        assert len(list(log.frames())) == 2
    with open_log(path, frames_on=("scan", "camera")) as log:
        frames = list(log.frames())
        assert log.primary == "scan"
        assert [frame.camera is not None for frame in frames].count(True) == 2
        assert frames[4].camera is not None
        assert len(frames) == 9


def test_a_wanted_topic_that_is_absent_is_refused_with_those_there_are(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap")
    with pytest.raises(LogError, match=r"scan=/laser: no such topic; the log has .*/odom"):
        open_log(path, {"scan": "/laser"})
    with pytest.raises(LogError, match=r"scan=/odom: carries nav_msgs/msg/Odometry"):
        open_log(path, {"scan": "/odom"})
    with pytest.raises(UsageError, match="no such role"):
        open_log(path, {"lidar": "/scan"})


def test_a_log_without_a_sensor_says_what_it_holds(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", lambda w: w.odometry(START_NS, Pose2(0, 0, 0)))
    with open_log(path) as log, pytest.raises(LogError, match=r"E206 .*nav_msgs/msg/Odometry"):
        next(log.frames())


def test_reading_twice_gives_the_same_ledger(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap", drive)) as log:
        list(log.frames(step_m=0.25))
        first = log.ledger.as_dict()
        list(log.frames(step_m=0.25))
        assert log.ledger.as_dict() == first
