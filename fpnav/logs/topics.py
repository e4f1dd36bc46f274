"""A topic of a log, and how it grows while the log is read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import messages
from fpnav.logs.codecs import Codec
from fpnav.logs.ledger import TopicCount
from fpnav.values import FloatArray

INDEX_DTYPE = np.dtype(
    [
        ("stamp_ns", "<i8"),
        ("log_ns", "<i8"),
        ("block", "<i4"),
        ("offset", "<u4"),
        ("length", "<u4"),
        ("channel", "<u2"),
        ("frame", "<u2"),
    ]
)
"""Where a message lies and when it was; ``frame`` numbers the frames of its topic."""

WIDTHS = {
    messages.ODOMETRY: 3,
    messages.POSE: 3,
    messages.POSE_COVARIANCE: 3,
    messages.IMU: 1,
    messages.JOINT_STATE: 1,
}
"""Columns that are decoded while the log is read: x, y, heading; or one angle."""

SPLIT_BY_FRAME = (messages.LASER_SCAN, messages.RANGE)
"""Types of which one topic may carry several sensors, told apart by their frames."""


@dataclass(slots=True)
class Topic:
    """One topic: ``rows`` (n,) INDEX_DTYPE in file order.

    ``columns`` (n, 3) for poses (x, y, heading) or (n, 1) for angles, else (n, 0). ``objects``
    are the decoded messages of labels, transforms and calibrations, None where they were too
    many. ``problem`` says why the topic cannot be used, empty where it can.
    """

    name: str
    type_name: str
    encoding: str
    rows: NDArray[Any]
    columns: FloatArray
    objects: list[Any]
    codecs: dict[int, Codec]
    frame_id: str = ""
    problem: str = ""
    count: TopicCount = field(default_factory=TopicCount)


class Growing:
    """A topic while the log is read."""

    def __init__(self, name: str, type_name: str, encoding: str) -> None:
        self.name = name
        self.type_name = type_name
        self.encoding = encoding
        self.problem = ""
        self.width = WIDTHS.get(type_name, 0)
        self.frames: dict[str, int] = {}
        self.rows: list[NDArray[Any]] = []
        self.columns: list[FloatArray] = []
        self.objects: list[Any] = []
        self.codecs: dict[int, Codec] = {}
        self.recent = Recent()
        self.failures = 0
        self.count = TopicCount(type_name)

    def frame(self, name: str) -> int:
        """Number of a frame within the topic."""
        return self.frames.setdefault(name, len(self.frames))

    def add(self, rows: NDArray[Any], columns: FloatArray) -> None:
        """Take the rows of a block."""
        self.rows.append(rows)
        self.columns.append(columns)

    def finish(self) -> Iterator[Topic]:
        """The topic; one for each frame where several sensors share it, named TOPIC#FRAME."""
        rows = np.concatenate(self.rows) if self.rows else np.empty(0, INDEX_DTYPE)
        columns = np.concatenate(self.columns) if self.columns else np.empty((0, self.width))
        if len(self.frames) < 2 or self.type_name not in SPLIT_BY_FRAME:
            yield self._topic(self.name, rows, columns, next(iter(self.frames), ""), self.count)
            return
        for frame, number in self.frames.items():
            mine = rows["frame"] == number
            count = TopicCount(self.type_name, used=int(mine.sum()))
            if number == 0:
                count.skipped, count.unread = self.count.skipped, self.count.unread
            count.first_ns, count.last_ns = self.count.first_ns, self.count.last_ns
            yield self._topic(f"{self.name}#{frame}", rows[mine], columns[mine], frame, count)

    def _topic(
        self, name: str, rows: NDArray[Any], columns: FloatArray, frame: str, count: TopicCount
    ) -> Topic:
        return Topic(
            name,
            self.type_name,
            self.encoding,
            rows,
            columns,
            self.objects,
            self.codecs,
            frame,
            self.problem,
            count,
        )


class Recent:
    """Recognises exact duplicates: the stamp and bytes of a message just before (B5)."""

    def __init__(self) -> None:
        self._stamp_ns: int | None = None
        self._seen: set[bytes] = set()

    def repeats(self, stamp_ns: int, data: memoryview) -> bool:
        """Whether this message came already with the messages of its stamp."""
        content = bytes(data)
        if stamp_ns != self._stamp_ns:
            self._stamp_ns, self._seen = stamp_ns, {content}
            return False
        repeated = content in self._seen
        self._seen.add(content)
        return repeated

    def starts_anew(self, stamps_ns: NDArray[np.int64]) -> bool:
        """Whether no stamp is that of the message before it, so that none can be a duplicate."""
        return int(stamps_ns[0]) != self._stamp_ns and bool(np.all(np.diff(stamps_ns) != 0))
