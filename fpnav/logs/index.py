"""One pass over a log: where every message lies and when it was, without its payload.

State messages (poses, headings, pan angles) are small and are decoded to columns on the way, as
are the stamps of all others: in columns where a block's messages are of one layout, one by one
where they are not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import columns as layouts
from fpnav.logs import decode, messages
from fpnav.logs.codecs import CdrCodec, ChannelFacts, Codec, ros_type
from fpnav.logs.columns import Heads, Payloads
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Container, Delivery
from fpnav.logs.encodings import codec_for
from fpnav.logs.ledger import Ledger
from fpnav.logs.moving import pose_topics
from fpnav.logs.topics import INDEX_DTYPE, SPLIT_BY_FRAME, Growing, Topic
from fpnav.values import FloatArray

LATEST_LOG_NS = 2**63
_OBJECTS = {messages.STRING: 2**31, messages.TRANSFORMS: 1000, messages.CAMERA_INFO: 10}
"""How many messages of a type are kept as objects; the rest is counted only."""

_GIVE_UP = 20
"""Messages of a topic that may fail from its start before the topic is given up."""

Values = tuple[float, ...]


def index_log(file: Container, ledger: Ledger, *, digest: bool = True) -> dict[str, Topic]:
    """Topics of a file by name, from one pass over it."""
    growing: dict[str, Growing] = {}
    channels: dict[int, Growing | None] = {}
    for delivery in file.scan(ledger, digest=digest):
        for channel_id in np.unique(delivery.messages["channel"]).tolist():
            chosen = delivery.messages[delivery.messages["channel"] == channel_id]
            if channel_id not in channels:
                sample = delivery.payload(chosen[0])
                channels[channel_id] = _topic_of(file, channel_id, sample, growing, ledger)
            target = channels[channel_id]
            if target is None:
                file.contents.skip(channel_id, "E117", len(chosen))
                ledger.note("E117", f"messages for unknown channel {channel_id}")
            else:
                _take(target, delivery, chosen)
    _account(file, ledger, growing)
    found = {topic.name: topic for grown in growing.values() for topic in grown.finish()}
    return {**found, **pose_topics(file, found)}


def _topic_of(
    file: Container, channel_id: int, sample: bytes, growing: dict[str, Growing], ledger: Ledger
) -> Growing | None:
    """The topic a channel belongs to; None where the channel is unknown."""
    channel = file.contents.channel(channel_id)
    if channel is None:
        return None
    schema = file.contents.schema(channel.schema_id)
    facts = ChannelFacts(
        channel.message_encoding,
        schema.name if schema else "",
        schema.encoding if schema else "",
        schema.data if schema else b"",
        sample,
    )
    codec = codec_for(facts)
    type_name = ros_type(facts.schema_name) if isinstance(codec, str) else codec.type_name
    topic = growing.setdefault(channel.topic, Growing(channel.topic, type_name, facts.encoding))
    if not channel.topic:
        topic.problem = "E121 topic without a name"
    elif type_name != topic.type_name:
        topic.problem = f"E119 carries both {topic.type_name} and {type_name}"
    elif isinstance(codec, str):
        topic.problem = codec
    else:
        topic.codecs[channel_id] = codec
        if codec.assumed:
            ledger.note("C2", f"{topic.name}: not defined in the log, taken for {type_name}")
    return topic


def _take(topic: Growing, delivery: Delivery, chosen: NDArray[Any]) -> None:
    """Add one block's messages of one channel to its topic."""
    topic.count.used += len(chosen)
    topic.count.see(chosen["log_ns"])
    if topic.problem:
        return
    codec = topic.codecs[int(chosen["channel"][0])]
    if isinstance(codec, CdrCodec) and _take_columns(topic, delivery, chosen):
        return
    _take_singly(topic, codec, delivery, chosen)


def _take_columns(topic: Growing, delivery: Delivery, chosen: NDArray[Any]) -> bool:
    """Take the messages in columns; False where they are not of one layout, or odd in time."""
    payloads = Payloads(
        delivery.data, chosen["offset"].astype(np.int64), chosen["length"].astype(np.int64)
    )
    found = _columns(topic, payloads)
    if found is None or int(chosen["log_ns"].max()) >= LATEST_LOG_NS:
        return False
    head, values = found
    if not topic.recent.starts_anew(head.stamps_ns):
        return False
    rows = np.empty(len(chosen), INDEX_DTYPE)
    rows["stamp_ns"] = head.stamps_ns
    rows["block"] = delivery.number
    rows["frame"] = topic.frame(head.frame_id)
    for name in ("log_ns", "offset", "length", "channel"):
        rows[name] = chosen[name]
    known = ~np.isnan(values).any(axis=1)
    topic.count.drop("E504", int(np.count_nonzero(~known)))
    topic.add(rows[known], values[known])
    last = delivery.payload(chosen[-1])
    topic.recent.repeats(int(head.stamps_ns[-1]), memoryview(last))
    return True


def _columns(topic: Growing, payloads: Payloads) -> tuple[Heads, FloatArray] | None:
    """Headers and columns of a block's messages; None where they are not of one layout."""
    if topic.type_name in (messages.ODOMETRY, messages.POSE, messages.POSE_COVARIANCE):
        return layouts.poses(payloads, topic.type_name)
    if topic.type_name == messages.IMU:
        return layouts.yaws(payloads)
    if topic.width or topic.type_name in _OBJECTS:
        return None
    head = layouts.heads(payloads)
    return None if head is None else (head, np.empty((len(payloads), 0)))


def _take_singly(topic: Growing, codec: Codec, delivery: Delivery, chosen: NDArray[Any]) -> None:
    """Take the messages one by one; what cannot be used is counted under its code."""
    rows: list[tuple[int, ...]] = []
    columns: list[Values] = []
    taker = _TAKERS.get(topic.type_name, _nothing)
    for channel, log_ns, offset, length in chosen.tolist():
        payload = memoryview(delivery.data)[offset : offset + length]
        try:
            if log_ns >= LATEST_LOG_NS:
                raise Damaged("E204", f"log time {log_ns}")
            stamp_ns = codec.stamp(payload)
            stamp_ns = log_ns if stamp_ns is None else stamp_ns
            if topic.recent.repeats(stamp_ns, payload):
                raise Damaged("duplicate", "a message like the one before")
            values = taker(topic, codec, payload)
            frame = _frame(topic, codec, payload)
        except Damaged as damage:
            topic.count.drop(damage.code)
            topic.failures += 1
            if topic.failures == _GIVE_UP and not rows and not topic.rows:
                topic.problem = f"{damage.code} {damage.reason}"
                return
            continue
        rows.append((stamp_ns, log_ns, delivery.number, offset, length, channel, frame))
        columns.append(values)
    made = np.array(columns, dtype=np.float64).reshape(len(rows), topic.width)
    topic.add(np.array(rows, dtype=INDEX_DTYPE), made)


def _frame(topic: Growing, codec: Codec, payload: memoryview) -> int:
    """Number of a message's frame; only topics that may be split by it need it of every one."""
    if topic.frames and topic.type_name not in SPLIT_BY_FRAME:
        return 0
    return topic.frame(codec.frame(payload))


Taker = Callable[[Growing, Codec, memoryview], Values]


def _nothing(topic: Growing, codec: Codec, payload: memoryview) -> Values:
    """Sensor messages are decoded when they are asked for."""
    return ()


def _pose(topic: Growing, codec: Codec, payload: memoryview) -> Values:
    pose = decode.pose_of(topic.type_name, codec.decode(payload))
    return pose.x_m, pose.y_m, pose.heading_rad


def _yaw(topic: Growing, codec: Codec, payload: memoryview) -> Values:
    return (decode.yaw_of(codec.decode(payload)),)


def _pan(topic: Growing, codec: Codec, payload: memoryview) -> Values:
    return (decode.pan_of(codec.decode(payload)),)


def _object(topic: Growing, codec: Codec, payload: memoryview) -> Values:
    """Labels, calibrations and transforms: the first are kept as objects."""
    keep = len(topic.objects) < _OBJECTS[topic.type_name]
    topic.objects.append(codec.decode(payload) if keep else None)
    return ()


_TAKERS: dict[str, Taker] = {
    messages.ODOMETRY: _pose,
    messages.POSE: _pose,
    messages.POSE_COVARIANCE: _pose,
    messages.IMU: _yaw,
    messages.JOINT_STATE: _pan,
    **dict.fromkeys(_OBJECTS, _object),
}


def _account(file: Container, ledger: Ledger, growing: dict[str, Growing]) -> None:
    """Put what the container lost to the topics that lost it."""
    for channel_id, skipped in file.contents.skipped.items():
        channel = file.contents.channel(channel_id)
        name = channel.topic if channel else f"(channel {channel_id})"
        topic = growing.setdefault(name, Growing(name, "", ""))
        topic.count.skipped.update(skipped)
    for channel_id in file.contents.ambiguous:
        channel = file.contents.channel(channel_id)
        if channel and channel.topic in growing:
            topic = growing[channel.topic]
            topic.problem = "E118 defined twice with different content"
    _compare_statistics(file, ledger, growing)


def _compare_statistics(file: Container, ledger: Ledger, growing: dict[str, Growing]) -> None:
    """What the log's own count has beyond ours is unread, where that count can be trusted."""
    summary = file.contents.summary
    if summary is None or summary.statistics is None:
        return
    stated: dict[str, int] = {}
    for channel_id, count in summary.statistics.channel_message_counts.items():
        channel = file.contents.channel(channel_id)
        if channel is not None:
            stated[channel.topic] = stated.get(channel.topic, 0) + count
    for name, count in stated.items():
        topic = growing.get(name)
        found = topic.count.in_file if topic else 0
        if count > found and summary.trusted:
            growing.setdefault(name, Growing(name, "", "")).count.unread += count - found
        elif count != found:
            ledger.note("A24", f"{name}: statistics say {count} messages, found {found}")
