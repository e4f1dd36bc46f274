"""Payloads of frames, loaded block by block with a bounded cache."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fpnav.logs import decode, limits, messages
from fpnav.logs.codecs import Codec
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Container
from fpnav.logs.streams import Stream
from fpnav.logs.transforms import NO_MOUNT, TransformTree
from fpnav.values import Calibration, Decoded, Payload, Pose2, SonarRing


class Loader:
    """Message bytes by index row; keeps the blocks used last, up to 64 MiB."""

    def __init__(self, file: Container) -> None:
        self._file = file
        self._blocks: OrderedDict[int, bytes] = OrderedDict()
        self._held = 0

    def payload(self, row: Any) -> memoryview:
        """Payload of the message at an index row."""
        number, offset = int(row["block"]), int(row["offset"])
        return memoryview(self._block(number))[offset : offset + int(row["length"])]

    def message(self, row: Any, codecs: Mapping[int, Codec]) -> Any:
        """Message object at an index row; raises Damaged."""
        return codecs[int(row["channel"])].decode(self.payload(row))

    def _block(self, number: int) -> bytes:
        if number not in self._blocks:
            self._blocks[number] = self._file.load(number)
            self._held += len(self._blocks[number])
            while self._held > limits.CACHE_BYTES and len(self._blocks) > 1:
                _, dropped = self._blocks.popitem(last=False)
                self._held -= len(dropped)
        self._blocks.move_to_end(number)
        return self._blocks[number]


@dataclass(frozen=True, slots=True)
class Fitting:
    """What a payload needs beside its message: where the sensor stands, how it is calibrated."""

    name: str
    tree: TransformTree
    calibrations: dict[str, Calibration]

    def mount(self, frame_id: str) -> tuple[Pose2, bool]:
        """Mount of a frame and whether it hangs upside down; the robot's origin if unknown."""
        return self.tree.mount(frame_id) or NO_MOUNT


def make_payload(
    role: str, streams: Sequence[Stream], rows: Sequence[int], loader: Loader, fitting: Fitting
) -> Payload:
    """Payload of one role at one frame, from the joined row of each of its streams.

    Raises
    ------
    Damaged
        The message cannot be decoded.
    """
    if role == "sonar":
        return Decoded(_ring(streams, rows, loader, fitting))
    stream, row = streams[0], rows[0]
    if role == "pan":
        return Decoded(float(stream.columns[row, 0]))
    if role == "label":
        return Decoded(str(stream.objects[row].data))
    message = loader.message(stream.rows[row], stream.codecs)
    if stream.type_name == messages.LASER_SCAN:
        mount, flipped = fitting.mount(str(message.header.frame_id))
        return Decoded(decode.scan_of(message, mount, flipped=flipped))
    source = f"{fitting.name} {stream.topic} message {int(stream.ordinals[row])}"
    return decode.image_of(stream.type_name, message, source, fitting.calibrations.get(role))


def _ring(
    streams: Sequence[Stream], rows: Sequence[int], loader: Loader, fitting: Fitting
) -> SonarRing:
    """Ring of the nearest reading of every transducer; NaN where one has none."""
    ranges = np.full(len(streams), np.nan, dtype=np.float32)
    mounts = np.zeros((len(streams), 3))
    views, lows, highs = [], [], []
    for number, (stream, row) in enumerate(zip(streams, rows, strict=True)):
        mount, _ = fitting.mount(stream.frame_id)
        mounts[number] = (mount.x_m, mount.y_m, mount.heading_rad)
        if row < 0:
            continue
        message = loader.message(stream.rows[row], stream.codecs)
        ranges[number] = message.range
        low, high = decode.range_limits(float(message.min_range), float(message.max_range))
        views.append(float(message.field_of_view))
        lows.append(low)
        highs.append(high)
    if not views:
        raise Damaged("E305", "no transducer of the ring has a reading")
    return SonarRing(ranges, mounts, max(views), min(lows), max(highs))
