"""The same short drive in every message encoding: scan, image, odometry, calibration, mounts."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from helpers.logs import START_NS, STEP_NS, jpeg
from mcap.writer import Writer

from fpnav.logs import messages
from fpnav.logs.calibration import camera_info
from fpnav.values import Calibration, LaserScan, Pose2

FRAMES = 4
MOUNT = Pose2(0.25, 0.1, 0.5)
CALIBRATION = Calibration(32, 16, horizontal_fov_rad=1.2, vertical_fov_rad=0.7, horizon_row=7.0)


def scan(number: int) -> LaserScan:
    """A scan of five beams with every special value of REP 117."""
    ranges = np.array([1.0 + number, np.inf, -np.inf, np.nan, 2.5], dtype=np.float32)
    return LaserScan(ranges, -0.5, 0.25, 0.1, 10.0)


def pose(number: int) -> Pose2:
    return Pose2(0.5 * number, -0.25, 0.1 * number)


@dataclass(frozen=True)
class Sent:
    """One message of the drive: topic, its ROS type, and the values it carries."""

    topic: str
    type_name: str
    stamp_ns: int
    value: Any


def drive(*, ros: bool = True) -> Iterator[Sent]:
    """Everything the drive sends, in order; Foxglove has no schemas for some of it."""
    yield Sent("/tf_static", messages.TRANSFORMS, START_NS, {"laser": MOUNT, "eye": MOUNT})
    yield Sent("/eye/camera_info", messages.CAMERA_INFO, START_NS, CALIBRATION)
    for i in range(FRAMES):
        stamp = START_NS + i * STEP_NS
        yield Sent("/odom", messages.ODOMETRY, stamp, pose(i))
        yield Sent("/gt/pose", messages.POSE, stamp, pose(i))
        yield Sent("/laser", messages.LASER_SCAN, stamp, scan(i))
        yield Sent("/eye/image", messages.COMPRESSED_IMAGE, stamp, jpeg(shade=50 + i))
        yield Sent("/right/image", messages.IMAGE, stamp, np.full((4, 6, 3), i, np.uint8))
        if ros:
            yield Sent("/sonar/0", messages.RANGE, stamp, 0.5 + i)
            yield Sent("/compass", messages.IMU, stamp, 0.1 * i)
            yield Sent("/joints", messages.JOINT_STATE, stamp, 0.2 * i)
            yield Sent("/label", messages.STRING, stamp, f"room {i}")


def _ros(sent: Sent) -> Any:
    """The message as an object of the Humble store."""
    value, stamp = sent.value, sent.stamp_ns
    if sent.type_name == messages.TRANSFORMS:
        made = [
            messages.transform(
                stamp, "base_link", child, (m.x_m, m.y_m, 0.3), messages.quaternion(m.heading_rad)
            )
            for child, m in value.items()
        ]
        return messages.make(messages.TRANSFORMS, transforms=made)
    if sent.type_name == messages.CAMERA_INFO:
        return camera_info("camera", stamp, "eye", value)
    if sent.type_name == messages.ODOMETRY:
        return messages.odometry(stamp, value, 0.4, 0.1)
    if sent.type_name == messages.POSE:
        head = messages.header(stamp, "map")
        return messages.make(messages.POSE, header=head, pose=messages.pose(value))
    if sent.type_name == messages.LASER_SCAN:
        return messages.laser_scan(stamp, "laser", value)
    if sent.type_name == messages.RANGE:
        return messages.sonar_range(stamp, "laser", value, 0.4, 0.1, 5.0)
    if sent.type_name == messages.IMU:
        return messages.imu(stamp, value)
    if sent.type_name == messages.JOINT_STATE:
        return messages.joint(stamp, "camera_pan_joint", value)
    if sent.type_name == messages.STRING:
        return messages.make(messages.STRING, data=value)
    head = messages.header(stamp, "eye")
    if sent.type_name == messages.COMPRESSED_IMAGE:
        data = messages.byte_array(value)
        return messages.make(messages.COMPRESSED_IMAGE, header=head, format="jpeg", data=data)
    height, width, _ = value.shape
    return messages.make(
        messages.IMAGE, header=head, height=height, width=width, encoding="bgr8", is_bigendian=0,
        step=3 * width, data=value.ravel(),
    )  # fmt: skip


def _cdr(sent: Sent) -> tuple[str, str, bytes, bytes]:
    data = messages.serialize(_ros(sent), sent.type_name)
    return sent.type_name, "ros2msg", messages.definition(sent.type_name), data


def _cdr_by_name(sent: Sent) -> tuple[str, str, bytes, bytes]:
    """As rosbag2 stores what it has no definition of: the name alone, as IDL."""
    data = messages.serialize(_ros(sent), sent.type_name)
    return sent.type_name, "ros2idl", b"", data


def _cdr_big_endian(sent: Sent) -> tuple[str, str, bytes, bytes]:
    store = messages.typestore()
    data = bytes(store.serialize_cdr(_ros(sent), sent.type_name, little_endian=False))
    return sent.type_name, "ros2msg", messages.definition(sent.type_name), data


def _ros1(sent: Sent) -> tuple[str, str, bytes, bytes]:
    store = messages.typestore(messages.NOETIC)
    message = _as_ros1(_ros(sent), sent.type_name, store)
    name = sent.type_name.replace("/msg/", "/")
    text = messages.definition(sent.type_name, messages.NOETIC, 1)
    return name, "ros1msg", text, bytes(store.serialize_ros1(message, sent.type_name))


def _as_ros1(message: Any, type_name: str, store: Any) -> Any:
    """The same message as an object of the ROS 1 store."""
    fields = {}
    for name, (_, described) in store.fielddefs[type_name][1]:
        source = next((n for n in (name, name.lower()) if hasattr(message, n)), None)
        if name == "seq":
            fields[name] = 7
            continue
        assert source is not None, (type_name, name)
        value = getattr(message, source)
        nested = described if isinstance(described, str) else described[0]
        if isinstance(described, str):
            fields[name] = _as_ros1(value, described, store)
        elif isinstance(nested, tuple) and isinstance(nested[1], str):
            fields[name] = [_as_ros1(one, nested[1], store) for one in value]
        else:
            fields[name] = value
    return store.types[type_name](**fields)


_FOXGLOVE = {
    messages.TRANSFORMS: "FrameTransforms",
    messages.CAMERA_INFO: "CameraCalibration",
    messages.ODOMETRY: "PoseInFrame",
    messages.POSE: "PoseInFrame",
    messages.LASER_SCAN: "LaserScan",
    messages.COMPRESSED_IMAGE: "CompressedImage",
    messages.IMAGE: "RawImage",
}


def _json(sent: Sent) -> tuple[str, str, bytes, bytes]:
    values = foxglove_values(sent)
    for key, value in values.items():
        if isinstance(value, bytes):
            values[key] = base64.b64encode(value).decode()
    name = f"foxglove.{_FOXGLOVE[sent.type_name]}"
    return name, "jsonschema", b"{}", json.dumps(values).encode()


def _protobuf(sent: Sent) -> tuple[str, str, bytes, bytes]:
    name = f"foxglove.{_FOXGLOVE[sent.type_name]}"
    kind = GetMessageClass(pool().FindMessageTypeByName(name))
    values = foxglove_values(sent)
    _rename_times(values)
    return name, "protobuf", descriptors().SerializeToString(), kind(**values).SerializeToString()


def foxglove_values(sent: Sent) -> dict[str, Any]:
    """Fields of a message of the corresponding Foxglove schema, times as JSON spells them."""
    value = sent.value
    seconds, nanoseconds = divmod(sent.stamp_ns, 10**9)
    head = {"timestamp": {"sec": seconds, "nsec": nanoseconds}}
    if sent.type_name == messages.TRANSFORMS:
        return {"transforms": [{**head, **_link(child, m)} for child, m in value.items()]}
    if sent.type_name == messages.CAMERA_INFO:
        info = camera_info("camera", sent.stamp_ns, "eye", value)
        matrices = {n: list(map(float, getattr(info, n.lower()))) for n in "DKRP"}
        size = {"width": info.width, "height": info.height}
        return {**head, "frame_id": "eye", **size, "distortion_model": "plumb_bob", **matrices}
    if sent.type_name in (messages.ODOMETRY, messages.POSE):
        return {**head, "frame_id": "map", "pose": _pose(value)}
    if sent.type_name == messages.LASER_SCAN:
        last = value.angle_min_rad + value.angle_increment_rad * (len(value.ranges_m) - 1)
        angles = {"start_angle": value.angle_min_rad, "end_angle": last}
        ranges = [float(r) for r in value.ranges_m]
        origin = {"pose": _pose(Pose2(0.0, 0.0, 0.0))}
        return {**head, "frame_id": "laser", **origin, **angles, "ranges": ranges}
    if sent.type_name == messages.COMPRESSED_IMAGE:
        return {**head, "frame_id": "eye", "data": value, "format": "jpeg"}
    height, width, _ = value.shape
    size = {"width": width, "height": height, "step": 3 * width, "encoding": "bgr8"}
    return {**head, "frame_id": "eye", **size, "data": value.tobytes()}


def _link(child: str, mount: Pose2) -> dict[str, Any]:
    pose = _pose(mount)
    names = {"parent_frame_id": "base_link", "child_frame_id": child}
    return {**names, "translation": pose["position"], "rotation": pose["orientation"]}


def _pose(value: Pose2) -> dict[str, Any]:
    half = 0.5 * value.heading_rad
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
    return {"position": {"x": value.x_m, "y": value.y_m, "z": 0.0}, "orientation": turn}


def _rename_times(values: Any) -> None:
    if isinstance(values, dict):
        if set(values) == {"sec", "nsec"}:
            values["seconds"], values["nanos"] = values.pop("sec"), values.pop("nsec")
        for value in values.values():
            _rename_times(value)
    elif isinstance(values, list):
        for value in values:
            _rename_times(value)


_NUMBER, _TEXT, _BYTES, _WORD = 1, 9, 12, 7
_PROTO = {
    "Time": [("seconds", 3), ("nanos", 5)],
    "Vector3": [("x", _NUMBER), ("y", _NUMBER), ("z", _NUMBER)],
    "Quaternion": [("x", _NUMBER), ("y", _NUMBER), ("z", _NUMBER), ("w", _NUMBER)],
    "Pose": [("position", "Vector3"), ("orientation", "Quaternion")],
    "CompressedImage": [("timestamp", "Time"), ("data", _BYTES), ("format", _TEXT),
                        ("frame_id", _TEXT)],
    "RawImage": [("timestamp", "Time"), ("width", _WORD), ("height", _WORD), ("encoding", _TEXT),
                 ("step", _WORD), ("data", _BYTES), ("frame_id", _TEXT)],
    "LaserScan": [("timestamp", "Time"), ("frame_id", _TEXT), ("pose", "Pose"),
                  ("start_angle", _NUMBER), ("end_angle", _NUMBER), ("ranges", [_NUMBER]),
                  ("intensities", [_NUMBER])],
    "PoseInFrame": [("timestamp", "Time"), ("frame_id", _TEXT), ("pose", "Pose")],
    "Odometry": [("timestamp", "Time"), ("frame_id", _TEXT), ("body_frame_id", _TEXT),
                 ("pose", "Pose"), ("linear_velocity", "Vector3"),
                 ("angular_velocity", "Vector3")],
    "FrameTransform": [("timestamp", "Time"), ("parent_frame_id", _TEXT),
                       ("child_frame_id", _TEXT), ("translation", "Vector3"),
                       ("rotation", "Quaternion")],
    "FrameTransforms": [("transforms", ["FrameTransform"])],
    "CameraCalibration": [("timestamp", "Time"), ("width", _WORD), ("height", _WORD),
                          ("distortion_model", _TEXT), ("D", [_NUMBER]), ("K", [_NUMBER]),
                          ("R", [_NUMBER]), ("P", [_NUMBER]), ("frame_id", _TEXT)],
}  # fmt: skip


def descriptors() -> descriptor_pb2.FileDescriptorSet:
    """Descriptors of the schemas in one file."""
    file = descriptor_pb2.FileDescriptorProto(
        name="foxglove.proto", package="foxglove", syntax="proto3"
    )
    for name, fields in _PROTO.items():
        message = file.message_type.add(name=name)
        for number, (field_name, kind) in enumerate(fields, 1):
            repeated = isinstance(kind, list)
            kind = kind[0] if repeated else kind
            field = message.field.add(name=field_name, number=number, label=3 if repeated else 1)
            if isinstance(kind, str):
                field.type, field.type_name = 11, f".foxglove.{kind}"
            else:
                field.type = kind
    found = descriptor_pb2.FileDescriptorSet()
    found.file.append(file)
    return found


def pool() -> DescriptorPool:
    found = DescriptorPool()
    found.Add(descriptors().file[0])
    return found


ENCODERS: dict[str, tuple[str, Callable[[Sent], tuple[str, str, bytes, bytes]]]] = {
    "cdr": ("cdr", _cdr),
    "cdr, idl": ("cdr", _cdr_by_name),
    "cdr, big endian": ("cdr", _cdr_big_endian),
    "ros1": ("ros1", _ros1),
    "protobuf": ("protobuf", _protobuf),
    "json": ("json", _json),
}


FOXGLOVE = ("protobuf", "json")


def write_bag(path: Path, *, compression: str = "") -> Path:
    """The drive as a ROS 1 bag, by rosbags."""
    from rosbags.rosbag1 import Writer as BagWriter

    writer = BagWriter(path)
    if compression:
        writer.set_compression(BagWriter.CompressionFormat[compression])
    with writer:
        connections: dict[str, Any] = {}
        store = messages.typestore(messages.NOETIC)
        for sent in drive():
            _, _, _, data = _ros1(sent)
            if sent.topic not in connections:
                connections[sent.topic] = writer.add_connection(
                    sent.topic, sent.type_name, typestore=store
                )
            writer.write(connections[sent.topic], sent.stamp_ns, data)
    return path


def write_db3(folder: Path) -> Path:
    """The drive as a ROS 2 bag folder with SQLite storage, by rosbags."""
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Bag2Writer

    with Bag2Writer(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections: dict[str, Any] = {}
        for sent in drive():
            _, _, _, data = _cdr(sent)
            if sent.topic not in connections:
                connections[sent.topic] = writer.add_connection(
                    sent.topic, sent.type_name, typestore=messages.typestore()
                )
            writer.write(connections[sent.topic], sent.stamp_ns, data)
    return folder


def encoded_drive(name: str) -> bytes:
    """The drive as an MCAP in one of the encodings."""
    encoding, encode = ENCODERS[name]
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start("", "test")
    channels: dict[str, int] = {}
    for sent in drive(ros=name not in FOXGLOVE):
        schema_name, schema_encoding, definition, data = encode(sent)
        if sent.topic not in channels:
            schema = writer.register_schema(schema_name, schema_encoding, definition)
            channels[sent.topic] = writer.register_channel(sent.topic, encoding, schema)
        writer.add_message(channels[sent.topic], sent.stamp_ns, data, sent.stamp_ns)
    writer.finish()
    return stream.getvalue()
