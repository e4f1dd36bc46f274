"""Messages in JSON: Foxglove's schemas, and ROS types spelled as JSON.

NaN and Infinity are read where numbers stand; base64 is binary data. A message without a schema
is told by its keys.
"""

from __future__ import annotations

import binascii
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace as Shape
from typing import Any

import numpy as np

from fpnav.logs import foxglove, messages
from fpnav.logs.codecs import ChannelFacts, Codec, Payload, ros_type
from fpnav.logs.container import Damaged

_BAD = (AttributeError, TypeError, ValueError, KeyError, OverflowError, binascii.Error)

_KEYS = {
    "foxglove.CompressedImage": {"timestamp", "data", "format"},
    "foxglove.RawImage": {"timestamp", "width", "height", "encoding", "step", "data"},
    "foxglove.LaserScan": {"timestamp", "pose", "start_angle", "end_angle", "ranges"},
    "foxglove.Odometry": {"timestamp", "frame_id", "body_frame_id", "pose"},
    "foxglove.PoseInFrame": {"timestamp", "frame_id", "pose"},
    "foxglove.FrameTransform": {"timestamp", "parent_frame_id", "child_frame_id"},
    "foxglove.FrameTransforms": {"transforms"},
    "foxglove.CameraCalibration": {"timestamp", "width", "height", "K", "P"},
}
"""Keys by which a message without a schema is told, the most particular first."""


@dataclass(frozen=True, slots=True)
class JsonCodec:
    """JSON of one type."""

    type_name: str
    shape: Callable[[Any], Any]
    stamp_in: Callable[[Any], int]
    assumed: bool = False

    def decode(self, data: Payload) -> Any:
        """Message object; E306 where it is not JSON or lacks fields."""
        message = parse_json(data)
        try:
            return self.shape(message)
        except _BAD as error:
            raise Damaged("E306", f"{self.type_name}: {error}") from None

    def stamp(self, data: Payload) -> int | None:
        """Stamp in ns, None for types without one."""
        if not messages.KNOWN[self.type_name]:
            return None
        try:
            return self.stamp_in(parse_json(data))
        except _BAD as error:
            raise Damaged("E306", f"{self.type_name}: {error}") from None

    def frame(self, data: Payload) -> str:
        """Frame the message names."""
        if not messages.KNOWN[self.type_name]:
            return ""
        return str(self.decode(data).header.frame_id)


def parse_json(data: Payload) -> Any:
    """JSON text as objects with attributes; E306 where it is none or has a key twice."""
    try:
        return json.loads(bytes(data), object_pairs_hook=_record)
    except (ValueError, RecursionError) as error:
        raise Damaged("E306", f"not JSON: {error}") from None


def _record(pairs: Sequence[tuple[str, Any]]) -> Shape:
    record = dict(pairs)
    if len(record) != len(pairs):
        raise ValueError("a key appears twice")
    return Shape(**record)


def make_json(channel: ChannelFacts) -> Codec | str:
    """Codec of a JSON channel: by its schema's name, or by the keys of its first message."""
    name = foxglove.bare_name(channel.schema_name)
    if not channel.schema_name:
        name = _by_keys(channel.sample)
        if not name:
            return "E301 no schema, and no type that is known by its keys"
    if name in foxglove.SHAPES:
        type_name, shape = foxglove.SHAPES[name]
        return JsonCodec(type_name, shape, foxglove.stamp_of, assumed=not channel.schema_name)
    type_name = ros_type(channel.schema_name)
    if type_name in messages.KNOWN:
        return JsonCodec(type_name, _ros_shape, _ros_stamp)
    return f"not used: {channel.schema_name}"


def _by_keys(sample: bytes) -> str:
    try:
        keys = set(vars(parse_json(sample)))
    except (Damaged, TypeError):
        return ""
    return next((name for name, needed in _KEYS.items() if needed <= keys), "")


def _ros_stamp(message: Any) -> int:
    stamp = message.header.stamp
    seconds = stamp.sec if hasattr(stamp, "sec") else stamp.secs
    nanoseconds = stamp.nanosec if hasattr(stamp, "nanosec") else stamp.nsecs
    return int(seconds) * 10**9 + int(nanoseconds)


def _ros_shape(message: Any) -> Any:
    """A ROS message spelled in JSON: binary data is base64, null in arrays is unknown."""
    if hasattr(message, "encoding") or hasattr(message, "format"):
        message.data = foxglove.bytes_of(message.data)
    if hasattr(message, "ranges"):
        message.ranges = np.array([np.nan if r is None else float(r) for r in message.ranges])
    return message
