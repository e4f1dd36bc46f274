"""ROS-shaped messages of any recording turned into items of the standard topics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fpnav.logs import decode, messages
from fpnav.logs.container import Damaged
from fpnav.logs.images import encode_png, format_of
from fpnav.logs.raw_images import decode_raw
from fpnav.logs.roles import IMAGE_ROLES
from fpnav.logs.sources.base import Echo, Item, Motion, Picture, SourceOptions
from fpnav.logs.transforms import NO_MOUNT, TransformTree
from fpnav.values import Calibration, SonarRing


@dataclass(slots=True)
class Converter:
    """Turns messages into items, knowing which topic plays what and where sensors stand.

    ``places`` : topic -> (role, number within a ring). ``infos`` : role -> CameraInfo object.
    """

    places: Mapping[str, tuple[str, int]]
    tree: TransformTree
    infos: Mapping[str, Any]
    options: SourceOptions
    unplaced: set[str] = field(default_factory=set)
    _calibrated: set[str] = field(default_factory=set)

    def items(
        self, topic: str, type_name: str, message: Any, stamp_ns: int, log_ns: int
    ) -> Iterator[Item]:
        """Items of one message; raises Damaged where it cannot be used."""
        role, number = self.places[topic]
        if role in IMAGE_ROLES:
            yield from self._image(role, type_name, message, stamp_ns, log_ns)
            return
        yield Item(role, stamp_ns, self._value(role, number, type_name, message), log_ns)

    def _value(self, role: str, number: int, type_name: str, message: Any) -> Any:
        if role == "scan":
            mount, flipped = self._mount(message)
            return decode.scan_of(message, mount, flipped=flipped)
        if role == "sonar":
            return Echo(number, self._echo(message))
        if role == "odometry":
            return _motion(type_name, message)
        if role == "truth":
            return decode.pose_of(type_name, message)
        if role == "heading":
            return decode.yaw_of(message)
        return decode.pan_of(message) if role == "pan" else str(message.data)

    def _mount(self, message: Any) -> Any:
        frame = str(message.header.frame_id)
        found = self.tree.mount(frame)
        if found is None:
            self.unplaced.add(frame)
        return found or NO_MOUNT

    def _echo(self, message: Any) -> SonarRing:
        mount, _ = self._mount(message)
        low, high = decode.range_limits(float(message.min_range), float(message.max_range))
        return SonarRing(
            np.array([message.range], dtype=np.float32),
            np.array([[mount.x_m, mount.y_m, mount.heading_rad]]),
            float(message.field_of_view),
            low,
            high,
        )

    def _image(
        self, role: str, type_name: str, message: Any, stamp_ns: int, log_ns: int
    ) -> Iterator[Item]:
        """A picture, after the calibration of its role where it is the first of it."""
        payload = decode.image_of(type_name, message, role, None)
        width, height = payload.check()
        if role not in self._calibrated:
            self._calibrated.add(role)
            calibration = self._calibration(role, message, width, height)
            yield Item(f"calibration:{role}", stamp_ns, calibration, log_ns)
        yield Item(role, stamp_ns, _picture(payload), log_ns)

    def _calibration(self, role: str, message: Any, width: int, height: int) -> Calibration:
        mount, _ = self.tree.mount(str(message.header.frame_id)) or NO_MOUNT
        if self.options.calibrated and role == (self.options.role or role):
            return replace(self.options.calibration_for(width, height), mount=mount)
        if role in self.infos:
            return decode.calibration_from(self.infos[role], mount)
        return Calibration(width, height, mount=mount)


def _motion(type_name: str, message: Any) -> Motion:
    pose = decode.pose_of(type_name, message)
    if type_name != messages.ODOMETRY:
        return Motion(pose)
    twist = message.twist.twist
    return Motion(pose, float(twist.linear.x), float(twist.angular.z))


def _picture(payload: decode.EncodedImage | decode.UncompressedImage) -> Picture:
    """Compressed images as they are, others as PNG."""
    if isinstance(payload, decode.EncodedImage):
        return Picture(payload.data, format_of(payload.data))
    try:
        return Picture(encode_png(decode_raw(payload.shape, payload.data)), "png")
    except MemoryError:
        raise Damaged("E407", "image does not fit into memory") from None
