"""Messages of one block decoded in columns: no object is made of any of them.

Little-endian CDR of a fixed layout: the header, what stands at fixed places behind it, and the
ranges of scans of equal size. A layout is taken from the first message and checked against every
other; messages that differ form groups of their own. Nothing is assumed of what is not checked.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import messages
from fpnav.values import FloatArray

_HEAD = np.dtype([("cdr", "<u2"), ("options", "<u2"), ("sec", "<i4"), ("nanosec", "<u4"),
                  ("frame", "<u4")])  # fmt: skip
_BYTE, _COUNT, _FLOAT, _DOUBLE = (np.dtype(name) for name in ("u1", "<u4", "<f4", "<f8"))
_LITTLE_ENDIAN = 0x0100
_BODY = 4
_SCAN = np.dtype([(name, "<f4") for name in ("angle_min", "angle_max", "angle_increment",
                  "time_increment", "scan_time", "range_min", "range_max")]
                 + [("count", "<u4")])  # fmt: skip
_RANGE = np.dtype([("field_of_view", "<f4"), ("min_range", "<f4"), ("max_range", "<f4"),
                   ("range", "<f4")])  # fmt: skip
_UNIT = 1e-3

# Doubles behind the header (and child frame): position and quaternion, or quaternion alone.
_POSE_DOUBLES = 7
_TAIL_DOUBLES = {
    messages.ODOMETRY: 36 + 6 + 36,
    messages.POSE: 0,
    messages.POSE_COVARIANCE: 36,
}
_IMU_TAIL_DOUBLES = 9 + 3 + 9 + 3 + 9


@dataclass(frozen=True, slots=True, eq=False)
class Payloads:
    """Payloads of one block: ``offsets`` and ``lengths`` (n,) into ``data``."""

    data: bytes | memoryview
    offsets: NDArray[np.int64]
    lengths: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.offsets)

    def at(self, start: int, dtype: np.dtype[Any], count: int = 1) -> NDArray[Any]:
        """``count`` values of a dtype from a fixed place of every payload, (n, count)."""
        size = dtype.itemsize * count
        places = len(self.data) - size + 1
        every = np.ndarray((places,), np.dtype((np.void, size)), self.data, strides=(1,))
        return every[self.offsets + start].view(dtype).reshape(len(self), count)

    def one(self, start: int, dtype: np.dtype[Any]) -> NDArray[Any]:
        """One value of a dtype from a fixed place of every payload, (n,)."""
        return self.at(start, dtype)[:, 0]

    def chosen(self, mask: NDArray[Any]) -> Payloads:
        """The payloads of a mask or of indices."""
        return Payloads(self.data, self.offsets[mask], self.lengths[mask])


@dataclass(frozen=True, slots=True, eq=False)
class Heads:
    """Headers of payloads: ``stamps_ns`` (n,), and one frame for all."""

    stamps_ns: NDArray[np.int64]
    frame_id: str
    end: int


def heads(payloads: Payloads) -> Heads | None:
    """Headers, None where they are not plain little-endian CDR with one frame for all."""
    if len(payloads) == 0 or int(payloads.lengths.min()) < _HEAD.itemsize:
        return None
    head = payloads.one(0, _HEAD)
    frame = int(head["frame"][0])
    end = _HEAD.itemsize + frame
    fits = frame > 0 and end <= int(payloads.lengths.min())
    if not fits or np.any(head["cdr"] != _LITTLE_ENDIAN) or np.any(head["frame"] != frame):
        return None
    names = payloads.at(_HEAD.itemsize, _BYTE, frame)
    if np.any(names != names[0]):
        return None
    stamps = head["sec"].astype(np.int64) * 10**9 + head["nanosec"]
    return Heads(stamps, _text(names[0].tobytes()), end)


def poses(payloads: Payloads, type_name: str) -> tuple[Heads, FloatArray] | None:
    """Headers and planar poses (n, 3); rows of NaN where position or quaternion are none.

    None where the payloads are not of one layout.
    """
    head = heads(payloads)
    if head is None:
        return None
    start: int | None = head.end
    if type_name == messages.ODOMETRY:
        start = _behind_text(payloads, head.end)
    if start is None:
        return None
    start = _aligned(start, 8)
    doubles = _POSE_DOUBLES + _TAIL_DOUBLES[type_name]
    if np.any(payloads.lengths != start + 8 * doubles):
        return None
    values = payloads.at(start, _DOUBLE, _POSE_DOUBLES)
    yaw = _yaw(values[:, 3:7])
    found = np.column_stack([values[:, 0], values[:, 1], yaw])
    found[~np.isfinite(found).all(axis=1)] = np.nan
    return head, found


def yaws(payloads: Payloads) -> tuple[Heads, FloatArray] | None:
    """Headers and headings (n, 1) of Imu messages; NaN where one gives no orientation."""
    head = heads(payloads)
    if head is None:
        return None
    start = _aligned(head.end, 8)
    if np.any(payloads.lengths != start + 8 * (4 + _IMU_TAIL_DOUBLES)):
        return None
    values = payloads.at(start, _DOUBLE, 5)
    found = _yaw(values[:, :4])
    found[values[:, 4] == -1.0] = np.nan
    return head, found[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class ScanColumns:
    """Scans of one layout, as the messages have them.

    ``rows`` (n,) which of the payloads these are; ``stamps_ns`` (n,); ``ranges_m`` (n, beams)
    float32; ``angle_min_rad``, ``angle_increment_rad``, ``range_min_m``, ``range_max_m`` (n,).
    """

    rows: NDArray[np.int64]
    frame_id: str
    stamps_ns: NDArray[np.int64]
    ranges_m: NDArray[np.float32]
    angle_min_rad: NDArray[np.float32]
    angle_increment_rad: NDArray[np.float32]
    range_min_m: NDArray[np.float32]
    range_max_m: NDArray[np.float32]


def scans(payloads: Payloads) -> tuple[list[ScanColumns], NDArray[np.int64]]:
    """Scans in groups of one layout, and the rows that are of none."""
    found: list[ScanColumns] = []
    odd: list[NDArray[np.int64]] = []
    for rows in _groups(payloads):
        columns = _scans(payloads.chosen(rows), rows)
        if columns is None:
            odd.append(rows)
        else:
            found.append(columns)
    return found, np.concatenate(odd) if odd else np.empty(0, np.int64)


def _scans(payloads: Payloads, rows: NDArray[np.int64]) -> ScanColumns | None:
    head = heads(payloads)
    if head is None:
        return None
    start = _aligned(head.end, 4)
    length = int(payloads.lengths[0])
    if length < start + _SCAN.itemsize + 4:
        return None
    fixed = payloads.one(start, _SCAN)
    beams = int(fixed["count"][0])
    end = start + _SCAN.itemsize + 4 * beams
    if end + 4 > length or np.any(fixed["count"] != beams):
        return None
    intensities = payloads.one(end, _COUNT)
    if beams == 0 or np.any(intensities != (length - end - 4) // 4) or (length - end) % 4:
        return None
    ranges = payloads.at(start + _SCAN.itemsize, _FLOAT, beams)
    return ScanColumns(
        rows,
        head.frame_id,
        head.stamps_ns,
        ranges.astype(np.float32, copy=False),
        fixed["angle_min"],
        fixed["angle_increment"],
        fixed["range_min"],
        fixed["range_max"],
    )


@dataclass(frozen=True, slots=True, eq=False)
class RangeColumns:
    """Single range readings of one layout; all (n,)."""

    rows: NDArray[np.int64]
    frame_id: str
    stamps_ns: NDArray[np.int64]
    range_m: NDArray[np.float32]
    field_of_view_rad: NDArray[np.float32]
    range_min_m: NDArray[np.float32]
    range_max_m: NDArray[np.float32]


def ranges(payloads: Payloads) -> RangeColumns | None:
    """Range readings, None where the payloads are not of one layout."""
    head = heads(payloads)
    if head is None:
        return None
    start = _aligned(head.end + 1, 4)
    behind = payloads.lengths - (start + _RANGE.itemsize)
    if np.any((behind != 0) & (behind != 4)):
        return None
    fixed = payloads.one(start, _RANGE)
    return RangeColumns(
        np.arange(len(payloads)),
        head.frame_id,
        head.stamps_ns,
        fixed["range"],
        fixed["field_of_view"],
        fixed["min_range"],
        fixed["max_range"],
    )


def _groups(payloads: Payloads) -> Iterator[NDArray[np.int64]]:
    """Rows of equal length, in order."""
    if len(payloads) == 0:
        return
    if np.all(payloads.lengths == payloads.lengths[0]):
        yield np.arange(len(payloads))
        return
    for length in np.unique(payloads.lengths):
        yield np.flatnonzero(payloads.lengths == length)


def _aligned(position: int, size: int) -> int:
    """Next place of a value of a size; CDR aligns from behind the encapsulation."""
    return _BODY + (position - _BODY + size - 1) // size * size


def _behind_text(payloads: Payloads, position: int) -> int | None:
    """Where a string that stands at a place in all payloads ends; None where they differ."""
    start = _aligned(position, 4)
    if int(payloads.lengths.min()) < start + 4:
        return None
    sizes = payloads.one(start, _COUNT)
    end = start + 4 + int(sizes[0])
    return end if np.all(sizes == sizes[0]) and end <= int(payloads.lengths.min()) else None


def _yaw(quaternions: FloatArray) -> FloatArray:
    """Turn about z (n,) of quaternions x, y, z, w; NaN where the length is not nearly one."""
    x, y, z, w = quaternions.T
    with np.errstate(invalid="ignore", over="ignore"):
        unit = np.abs(np.sqrt((quaternions**2).sum(axis=1)) - 1.0) <= _UNIT
        yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return np.where(unit, yaw, np.nan)


def _text(name: bytes) -> str:
    return name.rstrip(b"\0").decode("utf-8", "replace")
