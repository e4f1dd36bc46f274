"""MCAP logs as robots record them: any topics, ROS 2 messages in CDR, ten a second."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from helpers.logs import START_NS, STEP_NS, jpeg
from mcap.writer import Writer

from fpnav.logs import messages
from fpnav.values import LaserScan, Pose2

Sent = tuple[str, str, Any]
"""Topic, type, message."""


def write(path: Path, sent: Iterable[tuple[int, Sent]]) -> Path:
    """Messages with their log times."""
    with open(path, "wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="robot")
        channels: dict[str, int] = {}
        for log_ns, (topic, kind, message) in sent:
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", messages.definition(kind))
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            data = messages.serialize(message, kind)
            writer.add_message(channels[topic], log_time=log_ns, publish_time=log_ns, data=data)
        writer.finish()
    return path


def at(step: int) -> int:
    """Time of a step in ns."""
    return START_NS + step * STEP_NS


def scan(stamp_ns: int, topic: str = "/scan", frame: str = "laser") -> Sent:
    value = LaserScan(np.full(8, 2.0, np.float32), -1.5, 0.4, 0.1, 10.0)
    return topic, messages.LASER_SCAN, messages.laser_scan(stamp_ns, frame, value)


def picture(stamp_ns: int, topic: str, data: bytes | None = None, format: str = "jpeg") -> Sent:
    message = messages.make(
        messages.COMPRESSED_IMAGE,
        header=messages.header(stamp_ns, "eye"),
        format=format,
        data=messages.byte_array(jpeg() if data is None else data),
    )
    return topic, messages.COMPRESSED_IMAGE, message


def transform(stamp_ns: int, parent: str, child: str, pose: Pose2, topic: str = "/tf") -> Sent:
    offset = (pose.x_m, pose.y_m, 0.0)
    turn = messages.quaternion(pose.heading_rad)
    made = messages.transform(stamp_ns, parent, child, offset, turn)
    return topic, messages.TRANSFORMS, messages.make(messages.TRANSFORMS, transforms=[made])


def odometry(stamp_ns: int, x_m: float, topic: str = "/odom", *, valid: bool = True) -> Sent:
    message = messages.odometry(stamp_ns, Pose2(x_m, 0.0, 0.0), 1.0, 0.0)
    if not valid:
        message.pose.pose.orientation.w = 0.0
    return topic, messages.ODOMETRY, message


def imu(stamp_ns: int, yaw_rad: float, *, valid: bool = True) -> Sent:
    message = messages.imu(stamp_ns, yaw_rad)
    if not valid:
        message.orientation_covariance[0] = -1.0
    return "/imu", messages.IMU, message


def wheels(stamp_ns: int) -> Sent:
    message = messages.joint(stamp_ns, "left_wheel", math.pi)
    message.name, message.position = ["left_wheel", "right_wheel"], np.zeros(2)
    return "/joint_states", messages.JOINT_STATE, message
