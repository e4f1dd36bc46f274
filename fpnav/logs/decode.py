"""Message objects of the closed list of types turned into values, strictly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fpnav.errors import LogError
from fpnav.geometry import compose
from fpnav.logs import images, limits, raw_images
from fpnav.logs.calibration import calibration_of
from fpnav.logs.container import Damaged
from fpnav.logs.messages import COMPRESSED_IMAGE, ODOMETRY, POSE_COVARIANCE
from fpnav.logs.raw_images import RawShape
from fpnav.values import ORIGIN, Calibration, Image, LaserScan, Pose2

_UNIT = 1e-3


def heading_of(quaternion: Any) -> float:
    """Turn about z of a quaternion that is nearly of unit length, else E504."""
    x, y, z, w = (float(getattr(quaternion, name)) for name in "xyzw")
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= _UNIT:
        raise Damaged("E504", f"quaternion of length {length:g}")
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)


def pose_of(type_name: str, message: Any) -> Pose2:
    """Planar pose of an Odometry, PoseStamped or PoseWithCovarianceStamped."""
    nested = type_name in (ODOMETRY, POSE_COVARIANCE)
    pose = message.pose.pose if nested else message.pose
    x, y = float(pose.position.x), float(pose.position.y)
    if not (math.isfinite(x) and math.isfinite(y)):
        raise Damaged("E504", f"position ({x}, {y})")
    return Pose2(x, y, heading_of(pose.orientation))


def yaw_of(message: Any) -> float:
    """Heading of an Imu; E504 where it says it has none (covariance -1)."""
    if float(message.orientation_covariance[0]) == -1.0:
        raise Damaged("E504", "the Imu gives no orientation")
    return heading_of(message.orientation)


def pan_of(message: Any) -> float:
    """Angle of the joint named like a pan, or of the only joint."""
    names = [str(name) for name in message.name]
    chosen = [i for i, name in enumerate(names) if "pan" in name.lower()] or [0]
    if len(message.position) <= chosen[0] or (len(names) > 1 and "pan" not in names[chosen[0]]):
        raise Damaged("E508", f"no pan joint among {names}")
    return float(message.position[chosen[0]])


def scan_of(message: Any, mount: Pose2 = ORIGIN, *, flipped: bool = False) -> LaserScan:
    """LaserScan; a clockwise one is reversed, ``flipped`` = the sensor hangs upside down.

    Raises
    ------
    Damaged
        E501 increment zero or not finite, E502 no beams or too many.
    """
    ranges = np.array(message.ranges, dtype=np.float32)
    first, increment = float(message.angle_min), float(message.angle_increment)
    if not 0 < len(ranges) <= limits.BEAMS:
        raise Damaged("E502", f"{len(ranges)} beams")
    if increment == 0.0 or not (math.isfinite(increment) and math.isfinite(first)):
        raise Damaged("E501", f"beams start at {first} rad and are {increment} rad apart")
    if flipped:
        first, increment = -first, -increment
    if increment < 0.0:
        first += increment * (len(ranges) - 1)
        ranges, increment = ranges[::-1].copy(), -increment
    low, high = range_limits(float(message.range_min), float(message.range_max))
    return LaserScan(ranges, first, increment, low, high, _placed(mount, message))


def _placed(mount: Pose2, message: Any) -> Pose2:
    """Mount of a scan; Foxglove's has an origin of its own within its frame."""
    origin = getattr(message, "origin", None)
    if origin is None:
        return mount
    position = origin.position
    offset = Pose2(float(position.x), float(position.y), heading_of(origin.orientation))
    return compose(mount, offset)


def range_limits(low: float, high: float) -> tuple[float, float]:
    """Limits of a range sensor; none (0, inf) where they contradict (faults.md E5)."""
    if not low < high or high <= 0.0:
        return 0.0, math.inf
    return max(low, 0.0), high


def calibration_from(message: Any, mount: Pose2 = ORIGIN) -> Calibration:
    """Calibration that a CameraInfo of ROS 1 or 2 describes."""
    upper = hasattr(message, "K")
    distortion, intrinsic, projection = (
        getattr(message, name.upper() if upper else name) for name in "dkp"
    )
    return calibration_of(
        int(message.width),
        int(message.height),
        str(message.distortion_model),
        np.asarray(distortion, np.float64),
        np.asarray(intrinsic, np.float64),
        np.asarray(projection, np.float64),
        mount,
    )


@dataclass(frozen=True, slots=True, eq=False)
class EncodedImage:
    """Payload: a JPEG, PNG or WebP image."""

    data: bytes
    source: str = ""
    calibration: Calibration | None = None

    def check(self) -> tuple[int, int]:
        """(width, height) from the image's header, without decoding; raises Damaged."""
        return images.encoded_size(self.data)

    def decode(self) -> Image:
        """The image; raises LogError where it is damaged."""
        try:
            return Image(images.decode_encoded(self.data), self.calibration)
        except Damaged as damage:
            raise LogError(f"{self.source}: {damage.code} {damage.reason}") from None


@dataclass(frozen=True, slots=True, eq=False)
class UncompressedImage:
    """Payload: an image in one of the encodings of sensor_msgs/Image."""

    data: bytes
    shape: RawShape
    source: str = ""
    calibration: Calibration | None = None

    def check(self) -> tuple[int, int]:
        """(width, height); raises Damaged where the fields do not fit the data."""
        raw_images.check_raw(self.shape, len(self.data))
        return self.shape.width, self.shape.height

    def decode(self) -> Image:
        """The image; raises LogError where it is damaged."""
        try:
            return Image(raw_images.decode_raw(self.shape, self.data), self.calibration)
        except Damaged as damage:
            raise LogError(f"{self.source}: {damage.code} {damage.reason}") from None


def image_of(
    type_name: str, message: Any, source: str, calibration: Calibration | None
) -> EncodedImage | UncompressedImage:
    """Payload of an Image or CompressedImage, checked but not decoded; raises Damaged."""
    payload: EncodedImage | UncompressedImage
    if type_name == COMPRESSED_IMAGE:
        if "compressedDepth" in str(message.format):
            raise Damaged("E404", "compressed depth is no picture; name a topic of a camera")
        payload = EncodedImage(bytes(message.data), source, calibration)
    else:
        shape = RawShape(
            int(message.width),
            int(message.height),
            str(message.encoding),
            int(message.step),
            bool(message.is_bigendian),
        )
        payload = UncompressedImage(bytes(message.data), shape, source, calibration)
    payload.check()
    return payload
