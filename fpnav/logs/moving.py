"""Poses of the robot in /tf as topics of their own, where a log has no odometry messages.

Many recordings hold scans and /tf alone. A transform from another frame to the robot's base, such
as ``odom`` to ``base_link`` on /tf, becomes the topic ``/tf#odom`` of poses: odometry by its
name. One from ``map`` may be an estimate or the truth: only the user can say which.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace as Shape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import decode, messages
from fpnav.logs.codecs import Codec, Payload
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Container
from fpnav.logs.ledger import TopicCount
from fpnav.logs.payloads import Loader
from fpnav.logs.timing import JUMP_NS, by_log_time
from fpnav.logs.topics import INDEX_DTYPE, Topic
from fpnav.logs.transforms import clean_frame, is_robot


@dataclass(frozen=True, slots=True)
class LinkCodec:
    """One transform out of transform messages, as a PoseStamped of the child in the parent."""

    inner: Codec
    parent: str
    child: str
    type_name: str = messages.POSE

    @property
    def assumed(self) -> bool:
        """Whether the log does not define its transforms."""
        return self.inner.assumed

    def decode(self, data: Payload) -> Any:
        """The pose; E305 where the message has no such transform."""
        for stamped in self.inner.decode(data).transforms:
            if _link(stamped) == (self.parent, self.child):
                moved = stamped.transform
                pose = Shape(position=moved.translation, orientation=moved.rotation)
                return Shape(header=stamped.header, pose=pose)
        raise Damaged("E305", f"no transform from {self.parent} to {self.child}")

    def stamp(self, data: Payload) -> int:
        """Stamp of the transform in ns."""
        return _stamp(self.decode(data))

    def frame(self, data: Payload) -> str:
        """The parent frame."""
        return self.parent


def pose_topics(file: Container, topics: Mapping[str, Topic]) -> dict[str, Topic]:
    """Topics ``TOPIC#PARENT`` of the robot's poses; none where there are Odometry messages."""
    if any(t.type_name == messages.ODOMETRY and len(t.rows) for t in topics.values()):
        return {}
    found: dict[str, Topic] = {}
    loader = Loader(file)
    for topic in topics.values():
        if topic.type_name != messages.TRANSFORMS or topic.name.endswith("static"):
            continue
        for parent, child in _links(topic.objects):
            name = f"{topic.name}#{parent}"
            if name not in topics and name not in found:
                found[name] = _pose_topic(loader, topic, name, parent, child)
    return found


def _links(objects: Iterable[Any]) -> list[tuple[str, str]]:
    """(parent, child) of every transform from a frame outside the robot to its base."""
    every = (_link(stamped) for one in objects if one is not None for stamped in one.transforms)
    return sorted({link for link in every if is_robot(link[1]) and not is_robot(link[0])})


def _link(stamped: Any) -> tuple[str, str]:
    return clean_frame(str(stamped.header.frame_id)), clean_frame(str(stamped.child_frame_id))


def _stamp(stamped: Any) -> int:
    """Stamp in ns, however the encoding spells it; 0 where there is none."""
    stamp = getattr(stamped.header, "stamp", None)
    seconds = getattr(stamp, "sec", getattr(stamp, "secs", 0))
    return int(seconds) * 10**9 + int(getattr(stamp, "nanosec", getattr(stamp, "nsecs", 0)))


def _pose_topic(loader: Loader, topic: Topic, name: str, parent: str, child: str) -> Topic:
    codecs: dict[int, Codec] = {
        number: LinkCodec(codec, parent, child) for number, codec in topic.codecs.items()
    }
    count = TopicCount(messages.POSE)
    rows, poses = [], []
    for row in topic.rows[by_log_time(topic.rows)]:
        try:
            message = loader.message(row, codecs)
            pose = decode.pose_of(messages.POSE, message)
        except Damaged as damage:
            if damage.code != "E305":  # the message is about other frames
                count.skipped[damage.code] += 1
            continue
        row["stamp_ns"] = _stamp(message)
        rows.append(row)
        poses.append((pose.x_m, pose.y_m, pose.heading_rad))
    taken = np.array(rows, dtype=INDEX_DTYPE)
    fresh = _fresh(taken["stamp_ns"])
    count.used = int(fresh.sum())
    if count.used:
        count.see(taken["log_ns"][fresh].astype(np.uint64))
    columns = np.array(poses, dtype=np.float64).reshape(-1, 3)[fresh]
    return Topic(
        name, messages.POSE, topic.encoding, taken[fresh], columns, [], codecs, parent, "", count
    )


def _fresh(stamps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which transforms are new: publishers send the same one again, and a little late."""
    if len(stamps) == 0:
        return np.zeros(0, dtype=np.bool_)
    latest = np.concatenate([[stamps[0] - 1], np.maximum.accumulate(stamps)[:-1]])
    return np.asarray((stamps > latest) | (stamps < latest - JUMP_NS), dtype=np.bool_)
