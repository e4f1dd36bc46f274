"""Foxglove's schemas as the ROS types they correspond to, from protobuf or JSON objects.

Objects come in with attributes named as the schema's fields; ``stamp_of`` and ``bytes_of`` know
how each encoding spells a time and binary data. A Foxglove scan has no limits: nothing nearer
than 1 cm counts.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from types import SimpleNamespace as Shape
from typing import Any

import numpy as np

from fpnav.logs import messages
from fpnav.logs.container import Damaged

_NEAREST_M = 0.01


def stamp_of(message: Any) -> int:
    """Timestamp in ns: seconds and nanos (protobuf), sec and nsec (JSON)."""
    time = message.timestamp
    seconds = getattr(time, "seconds", None)
    if seconds is None:
        return int(time.sec) * 10**9 + int(time.nsec)
    return int(seconds) * 10**9 + int(time.nanos)


def bytes_of(value: Any) -> bytes:
    """Binary data: bytes (protobuf), base64 text or a list of numbers (JSON)."""
    if isinstance(value, str):
        return base64.b64decode(value, validate=True)
    return bytes(value)


def _header(message: Any) -> Shape:
    seconds, nanoseconds = divmod(stamp_of(message), 10**9)
    frame = str(getattr(message, "frame_id", ""))
    return Shape(stamp=Shape(sec=seconds, nanosec=nanoseconds), frame_id=frame)


def _numbers(values: Any) -> Any:
    """Array of numbers; null stands for unknown, texts for what JSON cannot spell."""
    return np.array([math.nan if value is None else float(value) for value in values])


def _compressed(message: Any) -> Shape:
    data = bytes_of(message.data)
    return Shape(header=_header(message), format=str(message.format), data=data)


def _raw(message: Any) -> Shape:
    return Shape(
        header=_header(message),
        width=int(message.width),
        height=int(message.height),
        encoding=str(message.encoding),
        step=int(message.step),
        is_bigendian=False,
        data=bytes_of(message.data),
    )


def _scan(message: Any) -> Shape:
    ranges = _numbers(message.ranges)
    start, end = float(message.start_angle), float(message.end_angle)
    increment = (end - start) / (len(ranges) - 1) if len(ranges) > 1 else math.radians(1.0)
    return Shape(
        header=_header(message),
        origin=message.pose,
        angle_min=start,
        angle_increment=increment,
        range_min=_NEAREST_M,
        range_max=math.inf,
        ranges=ranges,
    )


def _pose(message: Any) -> Shape:
    return Shape(header=_header(message), pose=message.pose)


def _odometry(message: Any) -> Shape:
    linear = getattr(message, "linear_velocity", None) or Shape(x=0.0)
    angular = getattr(message, "angular_velocity", None) or Shape(z=0.0)
    return Shape(
        header=_header(message),
        child_frame_id=str(getattr(message, "body_frame_id", "")),
        pose=Shape(pose=message.pose),
        twist=Shape(twist=Shape(linear=linear, angular=angular)),
    )


def _transforms(message: Any) -> Shape:
    return Shape(transforms=[_transform(one) for one in message.transforms])


def _one_transform(message: Any) -> Shape:
    return Shape(transforms=[_transform(message)])


def _transform(message: Any) -> Shape:
    stamp = stamp_of(message) if hasattr(message, "timestamp") else 0
    seconds, nanoseconds = divmod(stamp, 10**9)
    return Shape(
        header=Shape(
            stamp=Shape(sec=seconds, nanosec=nanoseconds), frame_id=str(message.parent_frame_id)
        ),
        child_frame_id=str(message.child_frame_id),
        transform=Shape(translation=message.translation, rotation=message.rotation),
    )


def _calibration(message: Any) -> Shape:
    return Shape(
        header=_header(message),
        width=int(message.width),
        height=int(message.height),
        distortion_model=str(message.distortion_model),
        D=_numbers(message.D),
        K=_padded(message.K, 9),
        R=_padded(message.R, 9),
        P=_padded(message.P, 12),
    )


def _padded(values: Any, size: int) -> Any:
    """A matrix that may be left empty, as zeros."""
    numbers = _numbers(values)
    if len(numbers) not in (0, size):
        raise Damaged("E306", f"matrix of {len(numbers)} numbers, expected {size}")
    return numbers if len(numbers) else np.zeros(size)


SHAPES: dict[str, tuple[str, Callable[[Any], Shape]]] = {
    "foxglove.CompressedImage": (messages.COMPRESSED_IMAGE, _compressed),
    "foxglove.RawImage": (messages.IMAGE, _raw),
    "foxglove.LaserScan": (messages.LASER_SCAN, _scan),
    "foxglove.PoseInFrame": (messages.POSE, _pose),
    "foxglove.Odometry": (messages.ODOMETRY, _odometry),
    "foxglove.FrameTransform": (messages.TRANSFORMS, _one_transform),
    "foxglove.FrameTransforms": (messages.TRANSFORMS, _transforms),
    "foxglove.CameraCalibration": (messages.CAMERA_INFO, _calibration),
}
"""Schema name -> the ROS type it corresponds to, and how it is brought into its shape."""


def bare_name(schema_name: str) -> str:
    """Schema name as in SHAPES, from the forms of ROS packages and IDL."""
    name = schema_name.replace("::", ".").replace("/msg/", ".").replace("/", ".")
    return name.replace("foxglove_msgs.", "foxglove.")
