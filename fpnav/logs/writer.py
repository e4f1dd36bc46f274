"""The standard log: ROS 2 MCAP with the topics of commands.md, written as a stream.

Same calls, same bytes: no clock is read, the library string is fixed, chunks are closed by size.
Every chunk, the data section and the summary carry a CRC.

Frames: ``/scan`` stands in frame ``scan``, ``/sonar/3`` in ``sonar_3``, ``/panorama`` and
``/omni`` in frames of their names (x forward), ``/camera`` in ``camera_optical`` (z forward, REP
103) below ``camera``. The parent of all is ``base_link``. The writer puts the mounts of scans,
rings and calibrations into /tf_static when it first sees them, unless ``static_transforms``
placed the frame before.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import Any, BinaryIO, Self

from mcap.writer import CompressionType, Writer

from fpnav.errors import LogError
from fpnav.logs import messages
from fpnav.logs.calibration import camera_info
from fpnav.values import ORIGIN, Calibration, LaserScan, Pose2, SonarRing

LIBRARY = "fpnav"
CHUNK_BYTES = 1024 * 1024
COMPRESSIONS = {
    "zstd": CompressionType.ZSTD,
    "lz4": CompressionType.LZ4,
    "none": CompressionType.NONE,
}
OPTICAL_ROLES = ("camera", "camera_offset")


def frame_of(topic: str) -> str:
    """Name of the frame a standard topic's sensor stands in."""
    return topic.strip("/").replace("/", "_")


def image_frame(role: str) -> str:
    """Name of the frame of a camera's images."""
    return f"{role}_optical" if role in OPTICAL_ROLES else role


def echo_of(ring: SonarRing, number: int) -> SonarRing:
    """One transducer of a ring."""
    one = slice(number, number + 1)
    limits = (ring.field_of_view_rad, ring.range_min_m, ring.range_max_m)
    return SonarRing(ring.ranges_m[one], ring.mounts[one], *limits)


class LogWriter:
    """Writes one standard log to a stream; ``with`` finishes it on success.

    ``log_ns`` of every method is the log time, by default the stamp.
    """

    def __init__(self, stream: BinaryIO, *, compression: str = "zstd") -> None:
        self._writer = Writer(
            stream,
            chunk_size=CHUNK_BYTES,
            compression=COMPRESSIONS[compression],
            enable_data_crcs=True,
        )
        self._writer.start(profile="ros2", library=LIBRARY)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, tuple[int, str]] = {}
        self._sequences: dict[int, int] = {}
        self._placed: dict[str, tuple[Pose2, float]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is None:
            self.finish()

    def finish(self) -> None:
        """Write the last chunk, the indexes and the footer."""
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap annotates in part

    def image(
        self,
        role: str,
        stamp_ns: int,
        encoded: bytes,
        format: str = "jpeg",
        *,
        log_ns: int | None = None,
    ) -> None:
        """One compressed image (jpeg, png or webp bytes) of a camera role."""
        head = messages.header(stamp_ns, image_frame(role))
        data = messages.byte_array(encoded)
        message = messages.make(messages.COMPRESSED_IMAGE, header=head, format=format, data=data)
        self.message(f"/{role}", messages.COMPRESSED_IMAGE, message, stamp_ns, log_ns)

    def camera_info(
        self, role: str, stamp_ns: int, calibration: Calibration, *, log_ns: int | None = None
    ) -> None:
        """Calibration of a camera role, in the form of fpnav.logs.calibration."""
        self._place(stamp_ns, role, calibration.mount)
        message = camera_info(role, stamp_ns, image_frame(role), calibration)
        self.message(f"/{role}/camera_info", messages.CAMERA_INFO, message, stamp_ns, log_ns)

    def scan(
        self, stamp_ns: int, scan: LaserScan, topic: str = "/scan", *, log_ns: int | None = None
    ) -> None:
        """One laser scan; its mount goes to /tf_static once."""
        self._place(stamp_ns, frame_of(topic), scan.mount)
        message = messages.laser_scan(stamp_ns, frame_of(topic), scan)
        self.message(topic, messages.LASER_SCAN, message, stamp_ns, log_ns)

    def sonar(self, stamp_ns: int, ring: SonarRing, *, log_ns: int | None = None) -> None:
        """One reading of every transducer, on /sonar/0, /sonar/1, ..."""
        new = {
            f"sonar_{number}": (Pose2(*(float(part) for part in mount)), 0.0)
            for number, mount in enumerate(ring.mounts)
            if f"sonar_{number}" not in self._placed
        }
        if new:
            self.static_transforms(stamp_ns, new)
        for number in range(len(ring.ranges_m)):
            self.echo(stamp_ns, number, echo_of(ring, number), log_ns=log_ns)

    def echo(
        self, stamp_ns: int, number: int, echo: SonarRing, *, log_ns: int | None = None
    ) -> None:
        """One reading of one transducer: a ring of one."""
        topic = f"/sonar/{number}"
        self._place(stamp_ns, frame_of(topic), Pose2(*(float(part) for part in echo.mounts[0])))
        message = messages.sonar_range(
            stamp_ns,
            frame_of(topic),
            float(echo.ranges_m[0]),
            echo.field_of_view_rad,
            echo.range_min_m,
            echo.range_max_m,
        )
        self.message(topic, messages.RANGE, message, stamp_ns, log_ns)

    def odometry(
        self,
        stamp_ns: int,
        pose: Pose2,
        linear_mps: float = 0.0,
        angular_radps: float = 0.0,
        *,
        log_ns: int | None = None,
    ) -> None:
        """Dead-reckoned pose and speeds."""
        message = messages.odometry(stamp_ns, pose, linear_mps, angular_radps)
        self.message("/odom", messages.ODOMETRY, message, stamp_ns, log_ns)

    def heading(self, stamp_ns: int, yaw_rad: float, *, log_ns: int | None = None) -> None:
        """Absolute heading of a compass, counter-clockwise from the world's x axis."""
        self.message("/compass", messages.IMU, messages.imu(stamp_ns, yaw_rad), stamp_ns, log_ns)

    def pan(self, stamp_ns: int, angle_rad: float, *, log_ns: int | None = None) -> None:
        """Pan angle of the camera on the robot."""
        message = messages.joint(stamp_ns, "pan", angle_rad)
        self.message("/pan", messages.JOINT_STATE, message, stamp_ns, log_ns)

    def truth(self, stamp_ns: int, pose: Pose2, *, log_ns: int | None = None) -> None:
        """True pose of the robot in the map."""
        head = messages.header(stamp_ns, "map")
        message = messages.make(messages.POSE, header=head, pose=messages.pose(pose))
        self.message("/truth", messages.POSE, message, stamp_ns, log_ns)

    def label(self, stamp_ns: int, text: str) -> None:
        """Name of the place the robot is in from this log time on."""
        self.message(
            "/label", messages.STRING, messages.make(messages.STRING, data=text), stamp_ns, None
        )

    def command(
        self, stamp_ns: int, linear_mps: float, angular_radps: float, *, log_ns: int | None = None
    ) -> None:
        """Speed command sent to the robot, on /cmd_vel."""
        message = messages.twist(linear_mps, angular_radps)
        self.message("/cmd_vel", messages.TWIST, message, stamp_ns, log_ns)

    def static_transforms(self, stamp_ns: int, frames: Mapping[str, tuple[Pose2, float]]) -> None:
        """Mounts on the robot, ``child frame -> (pose, height in metres)``, on /tf_static."""
        transforms: list[Any] = []
        for child, (mount, height_m) in frames.items():
            self._placed[child] = (mount, height_m)
            offset = (mount.x_m, mount.y_m, height_m)
            turn = messages.quaternion(mount.heading_rad)
            transforms.append(messages.transform(stamp_ns, "base_link", child, offset, turn))
            if child in OPTICAL_ROLES:
                turn = messages.optical_turn()
                optical = image_frame(child)
                transforms.append(messages.transform(stamp_ns, child, optical, (0, 0, 0), turn))
        message = messages.make(messages.TRANSFORMS, transforms=transforms)
        self.message("/tf_static", messages.TRANSFORMS, message, stamp_ns, None)

    def attach(self, name: str, media_type: str, data: bytes, *, log_ns: int = 0) -> None:
        """Attach a file, such as world.json."""
        self._writer.add_attachment(
            create_time=0, log_time=log_ns, name=name, media_type=media_type, data=data
        )

    def metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Add a named table of strings."""
        self._writer.add_metadata(name, dict(values))

    def message(
        self, topic: str, type_name: str, message: Any, stamp_ns: int, log_ns: int | None
    ) -> None:
        """Write a message object of any type of the closed list."""
        self.raw(topic, type_name, messages.serialize(message, type_name), stamp_ns, log_ns)

    def raw(
        self, topic: str, type_name: str, data: bytes, stamp_ns: int, log_ns: int | None
    ) -> None:
        """Write a message that is CDR already.

        Raises
        ------
        LogError
            The topic carries another type already, or the time is negative.
        """
        when = int(stamp_ns if log_ns is None else log_ns)
        if when < 0:
            raise LogError(f"{topic}: time {when} ns is before 1970 and cannot be logged")
        channel = self._channel(topic, type_name)
        sequence = self._sequences[channel] = self._sequences.get(channel, -1) + 1
        self._writer.add_message(
            channel, log_time=when, data=data, publish_time=when, sequence=sequence
        )

    def _place(self, stamp_ns: int, frame: str, mount: Pose2) -> None:
        """Publish a mount once; a frame that was given no place stands at the origin."""
        known = self._placed.get(frame)
        if known is None:
            self.static_transforms(stamp_ns, {frame: (mount, 0.0)})
        elif known[0] != mount and mount != ORIGIN:
            raise LogError(f"frame {frame} moved from {known[0]} to {mount} within one log")

    def _channel(self, topic: str, type_name: str) -> int:
        if topic not in self._channels:
            schema = self._schema(type_name)
            channel = self._writer.register_channel(topic, "cdr", schema)
            self._channels[topic] = (channel, type_name)
        channel, present = self._channels[topic]
        if present != type_name:
            raise LogError(f"{topic}: carries {present} already, cannot take {type_name}")
        return channel

    def _schema(self, type_name: str) -> int:
        if type_name not in self._schemas:
            self._schemas[type_name] = self._writer.register_schema(
                type_name, "ros2msg", messages.definition(type_name)
            )
        return self._schemas[type_name]
