"""Where sensors stand on the robot, from /tf_static (and what never moves in /tf)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from fpnav.logs.messages import TRANSFORMS
from fpnav.logs.topics import Topic
from fpnav.values import ORIGIN, FloatArray, Pose2

ROBOT_FRAMES = ("base_link", "base_footprint", "base", "robot", "base_frame")
_DEPTH = 32


def rotation_matrix(x: float, y: float, z: float, w: float) -> FloatArray:
    """(3, 3) rotation of a quaternion; identity where it has no length."""
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not length > 1e-9:
        return np.eye(3)
    x, y, z, w = x / length, y / length, z / length, w / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def clean_frame(name: str) -> str:
    """Frame name without the leading slash of old logs (faults.md E9)."""
    return name.lstrip("/")


def is_robot(frame: str) -> bool:
    """Whether a frame is the robot's base, of whatever namespace."""
    return frame.rsplit("/", 1)[-1] in ROBOT_FRAMES


class TransformTree:
    """Fixed transforms by child frame; the first of a child counts."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, FloatArray]] = {}

    def add(self, transforms: Iterable[Any]) -> None:
        """Take geometry_msgs/TransformStamped objects."""
        for stamped in transforms:
            child = clean_frame(str(stamped.child_frame_id))
            parent = clean_frame(str(stamped.header.frame_id))
            if child != parent:
                self._parents.setdefault(child, (parent, _matrix(stamped.transform)))

    def mount(self, frame: str) -> tuple[Pose2, bool] | None:
        """Pose of a sensor frame on the robot and whether it hangs upside down.

        None where no chain leads from it to a frame of the robot's base. An optical frame (z
        forward) points along its z axis.
        """
        frame = clean_frame(frame)
        found = self._to_robot(frame)
        if found is None:
            return None
        optical = "optical" in frame
        axis = found[:3, 2] if optical else found[:3, 0]
        upside_down = not optical and bool(found[2, 2] < -0.5)
        heading = math.atan2(float(axis[1]), float(axis[0]))
        return Pose2(float(found[0, 3]), float(found[1, 3]), heading), upside_down

    def _to_robot(self, frame: str) -> FloatArray | None:
        """(4, 4) transform from a frame to the robot's base."""
        found: FloatArray = np.eye(4)
        for _ in range(_DEPTH):
            if is_robot(frame):
                return found
            if frame not in self._parents:
                return None
            frame, step = self._parents[frame]
            found = step @ found
        return None


def _matrix(transform: Any) -> FloatArray:
    q, t = transform.rotation, transform.translation
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(float(q.x), float(q.y), float(q.z), float(q.w))
    matrix[:3, 3] = (float(t.x), float(t.y), float(t.z))
    return matrix


NO_MOUNT = (ORIGIN, False)


def transform_tree(files: Iterable[Mapping[str, Topic]]) -> TransformTree:
    """Mounts from /tf_static of all files of a recording, and from /tf where that has them alone.

    A recording that was split keeps its static transforms in the first file only.
    """
    tree = TransformTree()
    found = [topic for topics in files for topic in topics.values()]
    carriers = (topic for topic in found if topic.type_name == TRANSFORMS)
    for topic in sorted(carriers, key=lambda t: (not t.name.endswith("tf_static"), t.name)):
        for message in topic.objects:
            if message is not None:
                tree.add(message.transforms)
    return tree
