"""ROS 2 messages: the closed list of types fpnav reads and writes, from rosbags' built-in stores.

A log's own definitions are never registered: no code is made from what a log says (faults.md C5,
C6). The store is Humble's; a type that a later release extended only at its end (Range) is read
with its own built-in store, chosen by the fields the log declares.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from fpnav.errors import LogError
from fpnav.values import LaserScan, Pose2

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
RANGE = "sensor_msgs/msg/Range"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
POSE_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"
IMU = "sensor_msgs/msg/Imu"
JOINT_STATE = "sensor_msgs/msg/JointState"
STRING = "std_msgs/msg/String"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
TWIST = "geometry_msgs/msg/Twist"

KNOWN = {
    IMAGE: True,
    COMPRESSED_IMAGE: True,
    CAMERA_INFO: True,
    LASER_SCAN: True,
    RANGE: True,
    ODOMETRY: True,
    POSE: True,
    POSE_COVARIANCE: True,
    IMU: True,
    JOINT_STATE: True,
    STRING: False,
    TRANSFORMS: False,
}
"""The closed list of types that are read, and whether they begin with a header."""

ULTRASOUND = 0
LATEST_STAMP_NS = 2**31 * 10**9


HUMBLE = Stores.ROS2_HUMBLE.value
JAZZY = Stores.ROS2_JAZZY.value
NOETIC = Stores.ROS1_NOETIC.value
_TF_ROS1 = "geometry_msgs/TransformStamped[] transforms\n"


@cache
def typestore(store: str = HUMBLE) -> Typestore:
    """A built-in store; everything is written with that of ROS 2 Humble.

    That of ROS 1 lacks tf2_msgs, which is added from the definition above.
    """
    found = get_typestore(Stores(store))
    if TRANSFORMS not in found.fielddefs:
        found.register(get_types_from_msg(_TF_ROS1, TRANSFORMS))
    return found


@cache
def definition(type_name: str, store: str = HUMBLE, ros_version: int = 2) -> bytes:
    """Definition of a type with all it nests, as ros2msg (or ros1msg) text."""
    version: Literal[1, 2] = 1 if ros_version == 1 else 2
    text, _ = typestore(store).generate_msgdef(type_name, ros_version=version)
    return text.encode()


def serialize(message: Any, type_name: str) -> bytes:
    """Message as CDR, little endian."""
    return bytes(typestore().serialize_cdr(message, type_name))


def make(type_name: str, **fields: Any) -> Any:
    """Message object of a type."""
    return typestore().types[type_name](**fields)


def header(stamp_ns: int, frame_id: str) -> Any:
    """std_msgs/Header; raises LogError where the stamp does not fit ROS 2's 32 bit seconds."""
    if not 0 <= stamp_ns < LATEST_STAMP_NS:
        raise LogError(f"stamp {stamp_ns} ns does not fit a ROS 2 header (1970 to 2038)")
    seconds, nanoseconds = divmod(int(stamp_ns), 10**9)
    stamp = make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)


def byte_array(data: bytes) -> Any:
    """Bytes as the array a uint8[] field takes, without a copy."""
    return np.frombuffer(data, dtype=np.uint8)


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    """geometry_msgs/Vector3."""
    return make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))


def quaternion(yaw_rad: float) -> Any:
    """geometry_msgs/Quaternion of a turn about z."""
    half = 0.5 * float(yaw_rad)
    return make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half))


def pose(value: Pose2) -> Any:
    """geometry_msgs/Pose on the ground plane."""
    point = make("geometry_msgs/msg/Point", x=float(value.x_m), y=float(value.y_m), z=0.0)
    return make("geometry_msgs/msg/Pose", position=point, orientation=quaternion(value.heading_rad))


def laser_scan(stamp_ns: int, frame_id: str, scan: LaserScan) -> Any:
    """sensor_msgs/LaserScan; times within the scan are unknown and stay zero."""
    ranges = np.ascontiguousarray(scan.ranges_m, dtype=np.float32)
    last = scan.angle_min_rad + scan.angle_increment_rad * (len(ranges) - 1)
    return make(
        LASER_SCAN,
        header=header(stamp_ns, frame_id),
        angle_min=float(scan.angle_min_rad),
        angle_max=float(last),
        angle_increment=float(scan.angle_increment_rad),
        time_increment=0.0,
        scan_time=0.0,
        range_min=float(scan.range_min_m),
        range_max=float(scan.range_max_m),
        ranges=ranges,
        intensities=np.zeros(0, np.float32),
    )


def sonar_range(
    stamp_ns: int, frame_id: str, value_m: float, view_rad: float, low_m: float, high_m: float
) -> Any:
    """sensor_msgs/Range of one ultrasonic transducer."""
    return make(
        RANGE,
        header=header(stamp_ns, frame_id),
        radiation_type=ULTRASOUND,
        field_of_view=float(view_rad),
        min_range=float(low_m),
        max_range=float(high_m),
        range=float(value_m),
    )


def odometry(stamp_ns: int, value: Pose2, linear_mps: float, angular_radps: float) -> Any:
    """nav_msgs/Odometry from ``odom`` to ``base_link``; covariances unknown (zero)."""
    unknown = np.zeros(36)
    return make(
        ODOMETRY,
        header=header(stamp_ns, "odom"),
        child_frame_id="base_link",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=pose(value), covariance=unknown),
        twist=make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=twist(linear_mps, angular_radps),
            covariance=unknown,
        ),
    )


def twist(linear_mps: float, angular_radps: float) -> Any:
    """geometry_msgs/Twist of a robot that turns on the plane."""
    return make(TWIST, linear=vector(x=linear_mps), angular=vector(z=angular_radps))


def imu(stamp_ns: int, yaw_rad: float) -> Any:
    """sensor_msgs/Imu with an orientation alone; -1 marks what is not measured."""
    absent = np.zeros(9)
    absent[0] = -1.0
    return make(
        IMU,
        header=header(stamp_ns, "base_link"),
        orientation=quaternion(yaw_rad),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(),
        angular_velocity_covariance=absent,
        linear_acceleration=vector(),
        linear_acceleration_covariance=absent,
    )


def joint(stamp_ns: int, name: str, angle_rad: float) -> Any:
    """sensor_msgs/JointState of one joint."""
    nothing = np.zeros(0)
    return make(
        JOINT_STATE,
        header=header(stamp_ns, "base_link"),
        name=[name],
        position=np.array([angle_rad], dtype=np.float64),
        velocity=nothing,
        effort=nothing,
    )


def transform(stamp_ns: int, parent: str, child: str, offset: tuple[float, ...], turn: Any) -> Any:
    """geometry_msgs/TransformStamped; ``offset`` x, y, z in metres, ``turn`` a Quaternion."""
    return make(
        "geometry_msgs/msg/TransformStamped",
        header=header(stamp_ns, parent),
        child_frame_id=child,
        transform=make("geometry_msgs/msg/Transform", translation=vector(*offset), rotation=turn),
    )


def optical_turn() -> Any:
    """Rotation from a body frame (x forward) to an optical one (z forward, x right): REP 103."""
    return make("geometry_msgs/msg/Quaternion", x=-0.5, y=0.5, z=-0.5, w=0.5)
