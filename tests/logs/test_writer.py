"""The standard log: readable by others, the same bytes for the same calls."""

from __future__ import annotations

import io
import math
import zlib
from pathlib import Path

import numpy as np
import pytest
from helpers.logs import START_NS, drive, jpeg, log_bytes, ring, scan, write_log
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from fpnav.errors import LogError
from fpnav.geometry import angular_distance
from fpnav.logs.frames import open_log
from fpnav.logs.ledger import Ledger
from fpnav.logs.reader import LogFile
from fpnav.logs.writer import COMPRESSIONS, LogWriter
from fpnav.values import Calibration, Pose2


def decoded(data: bytes) -> list[tuple[str, object]]:
    """(topic, message) as another reader and decoder sees them."""
    reader = make_reader(io.BytesIO(data), decoder_factories=[DecoderFactory()], validate_crcs=True)
    return [(c.topic, m) for _, c, _, m in reader.iter_decoded_messages()]


def test_another_reader_decodes_every_topic() -> None:
    def fill(writer: LogWriter) -> None:
        drive(writer, 3)
        writer.pan(START_NS, 0.5)
        writer.command(START_NS, 0.3, -0.2)
        writer.image("camera", START_NS, jpeg())

    found = dict(decoded(log_bytes(fill)))
    assert set(found) == {
        "/panorama", "/panorama/camera_info", "/camera", "/scan", "/odom", "/truth", "/compass",
        "/pan", "/label", "/cmd_vel", "/tf_static", *(f"/sonar/{i}" for i in range(4)),
    }  # fmt: skip
    assert found["/scan"].ranges == pytest.approx([1.2] * 8)
    assert found["/scan"].header.frame_id == "scan"
    assert found["/odom"].pose.pose.position.x == pytest.approx(0.2)
    assert found["/truth"].header.frame_id == "map"
    assert found["/compass"].orientation_covariance[0] == 0.0
    assert found["/pan"].position == [0.5]
    assert found["/cmd_vel"].angular.z == -0.2
    assert found["/camera"].header.frame_id == "camera_optical"
    assert found["/panorama"].format == "jpeg"


def test_the_same_calls_give_the_same_bytes() -> None:
    assert log_bytes(drive) == log_bytes(drive)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_every_compression_is_covered_by_crcs(compression: str, tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", drive, compression)
    ledger = Ledger()
    with LogFile(path) as file:
        list(file.scan(ledger))
        assert set(file.contents.compressions) == {compression}
        assert file.contents.profile == "ros2"
        assert file.contents.library == "fpnav"
        assert file.contents.summary is not None
        assert file.contents.summary.data_crc == zlib.crc32(
            path.read_bytes()[: file.contents.summary.end - 13]
        )
    assert ledger.inputs[0].integrity == "verified"


def test_attachments_and_metadata_come_back(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.scan(START_NS, scan())
        writer.attach("world.json", "application/json", b'{"rooms": ["hall"]}')
        writer.metadata("fpnav.simulate", {"seed": "3"})

    with open_log(write_log(tmp_path / "a.mcap", fill)) as log:
        assert log.world == {"rooms": ["hall"]}
        assert log.attachment("other") is None
        assert log.metadata == {"fpnav.simulate": {"seed": "3"}}


def test_a_world_that_is_not_json_is_refused(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.attach("world.json", "application/json", b"{not json")

    refused = pytest.raises(LogError, match=r"a\.mcap: world\.json cannot be read")
    with open_log(write_log(tmp_path / "a.mcap", fill)) as log, refused:
        _ = log.world


@pytest.mark.parametrize(
    ("role", "calibration"),
    [
        (
            "panorama",
            Calibration(
                32, 16, horizontal_fov_rad=2 * math.pi, vertical_fov_rad=0.8, horizon_row=7.25,
                mount=Pose2(0.1, -0.05, 0.3),
            ),
        ),
        (
            "omni",
            Calibration(
                32, 16, horizontal_fov_rad=2 * math.pi, vertical_fov_rad=0.9, horizon_row=5.0,
                centre_x_px=15.5, centre_y_px=8.0, radius_in_px=2.0, radius_out_px=7.5,
            ),
        ),
        (
            "camera",
            Calibration(
                32, 16, horizontal_fov_rad=1.0, vertical_fov_rad=0.6, horizon_row=8.5,
                centre_x_px=15.5, centre_y_px=8.5, mount=Pose2(0.2, 0.0, 0.5),
            ),
        ),
        (
            "camera_offset",
            Calibration(
                32, 16, horizontal_fov_rad=1.0, vertical_fov_rad=0.6, horizon_row=7.5,
                centre_x_px=15.5, centre_y_px=7.5, baseline_m=0.3,
            ),
        ),
    ],
)  # fmt: skip
def test_a_calibration_comes_back_as_it_went(
    role: str, calibration: Calibration, tmp_path: Path
) -> None:
    def fill(writer: LogWriter) -> None:
        writer.camera_info(role, START_NS, calibration)
        writer.image(role, START_NS, jpeg())
        writer.scan(START_NS, scan())

    with open_log(write_log(tmp_path / "a.mcap", fill)) as log:
        found = log.calibrations[role]
        image = next(iter(log.frames())).get(role)
    for name in Calibration.__dataclass_fields__:
        expected, actual = getattr(calibration, name), getattr(found, name)
        if name == "mount":
            assert actual == Pose2(*(pytest.approx(part) for part in vars_of(expected)))
        else:
            assert actual == pytest.approx(expected, nan_ok=True), name
    assert image.calibration == found


def vars_of(pose: Pose2) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.heading_rad


def test_an_unknown_calibration_stays_unknown(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.camera_info("camera", START_NS, Calibration(32, 16))
        writer.image("camera", START_NS, jpeg())

    with open_log(write_log(tmp_path / "a.mcap", fill)) as log:
        found = log.calibrations["camera"]
    assert (found.width_px, found.height_px) == (32, 16)
    assert math.isnan(found.horizontal_fov_rad)


def test_mounts_given_first_are_those_that_count(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.static_transforms(START_NS, {"scan": (Pose2(0.5, 0.1, math.pi), 0.3)})
        writer.scan(START_NS, scan(mount=Pose2(0.5, 0.1, math.pi)))

    data = log_bytes(fill)
    assert [topic for topic, _ in decoded(data)].count("/tf_static") == 1
    (tmp_path / "a.mcap").write_bytes(data)
    with open_log(tmp_path / "a.mcap") as log:
        mount = next(iter(log.frames())).scan.mount
    assert (mount.x_m, mount.y_m) == pytest.approx((0.5, 0.1))
    assert abs(mount.heading_rad) == pytest.approx(math.pi)


def test_a_sensor_that_moves_on_the_robot_is_refused() -> None:
    with LogWriter(io.BytesIO()) as writer:
        writer.scan(START_NS, scan(mount=Pose2(0.2, 0.0, 0.0)))
        with pytest.raises(LogError, match="frame scan moved"):
            writer.scan(START_NS, scan(mount=Pose2(0.3, 0.0, 0.0)))


def test_a_ring_has_one_topic_and_one_frame_a_transducer(tmp_path: Path) -> None:
    with open_log(write_log(tmp_path / "a.mcap", lambda w: w.sonar(START_NS, ring(12)))) as log:
        assert log.roles["sonar"].topics == tuple(f"/sonar/{i}" for i in range(12))
        found = next(iter(log.frames())).sonar
    assert np.allclose(found.mounts[:, :2], ring(12).mounts[:, :2])
    assert np.allclose(angular_distance(found.mounts[:, 2], ring(12).mounts[:, 2]), 0, atol=1e-9)
    assert found.field_of_view_rad == pytest.approx(0.4)
    assert (found.range_min_m, found.range_max_m) == pytest.approx((0.1, 5.0))


@pytest.mark.parametrize("stamp_ns", [-1, 2**31 * 10**9])
def test_a_stamp_that_ros_cannot_hold_is_refused(stamp_ns: int) -> None:
    with LogWriter(io.BytesIO()) as writer:
        with pytest.raises(LogError, match="1970 to 2038"):
            writer.scan(stamp_ns, scan())
        with pytest.raises(LogError, match="before 1970"):
            writer.label(-5, "hall")


def test_one_topic_carries_one_type() -> None:
    with LogWriter(io.BytesIO()) as writer:
        writer.scan(START_NS, scan(), topic="/thing")
        with pytest.raises(LogError, match="/thing: carries sensor_msgs/msg/LaserScan already"):
            writer.raw("/thing", "std_msgs/msg/String", b"", START_NS, None)


def test_a_failed_block_leaves_the_log_unfinished() -> None:
    stream = io.BytesIO()

    def fail() -> None:
        with LogWriter(stream) as writer:
            writer.scan(START_NS, scan())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert not stream.getvalue().endswith(b"\x89MCAP0\r\n")
