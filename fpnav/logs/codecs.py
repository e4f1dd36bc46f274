"""Ways messages are encoded: each gives objects with the fields of the ROS 2 type.

A codec is chosen by what a channel and its schema say. What a log defines itself is compared with
the types known here, never compiled.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from rosbags.serde import SerdeError

from fpnav.logs import messages
from fpnav.logs.container import Damaged
from fpnav.logs.definitions import known_layout, parse_definition, same_layout

_CDR_HEADS = (b"\x00\x00", b"\x00\x01")
_TF_NAMES = ("tf/msg/tfMessage", "tf/msg/TFMessage")
Payload = bytes | memoryview


@dataclass(frozen=True, slots=True)
class ChannelFacts:
    """What a channel says of its messages; ``definition`` is the schema's text or bytes.

    ``sample`` is the first message, by which JSON without a schema is told.
    """

    encoding: str
    schema_name: str
    schema_encoding: str = ""
    definition: bytes = b""
    sample: bytes = b""


class Codec(Protocol):
    """Decodes the messages of one channel."""

    @property
    def type_name(self) -> str:
        """ROS 2 type whose fields the objects have."""
        ...

    @property
    def assumed(self) -> bool:
        """Whether the log does not define the type and the standard definition is assumed."""
        ...

    def decode(self, data: Payload) -> Any:
        """Message object; raises Damaged."""
        ...

    def stamp(self, data: Payload) -> int | None:
        """Header stamp in ns, None where the type has no header; raises Damaged."""
        ...

    def frame(self, data: Payload) -> str:
        """Frame the header names, empty where the type has no header; raises Damaged."""
        ...


Maker = Callable[[ChannelFacts], "Codec | str"]
"""Makes the codec of a channel, or says why there is none."""


@dataclass(frozen=True, slots=True)
class CdrCodec:
    """Plain CDR of ROS 2 by built-in definitions, tried in turn where the log leaves it open."""

    type_name: str
    stores: tuple[str, ...]
    assumed: bool = False

    def decode(self, data: Payload) -> Any:
        """Message object; E304 another encapsulation, E305 fields do not fit the payload."""
        _check_encapsulation(data)
        failure: Exception | None = None
        for store in self.stores:
            try:
                return messages.typestore(store).deserialize_cdr(memoryview(data), self.type_name)
            except (SerdeError, struct.error, IndexError, MemoryError, OverflowError) as error:
                failure = failure or error
        if (mended := _with_plain_frame(data)) is not None:
            return self.decode(mended)
        raise Damaged("E305", f"{self.type_name}: {failure}") from None

    def stamp(self, data: Payload) -> int | None:
        """Header stamp in ns without decoding the rest."""
        if not messages.KNOWN[self.type_name]:
            return None
        _check_encapsulation(data)
        try:
            seconds, nanoseconds = struct.unpack_from("<iI" if data[1] == 1 else ">iI", data, 4)
        except struct.error:
            raise Damaged("E305", "payload ends within its header") from None
        return int(seconds) * 10**9 + int(nanoseconds)

    def frame(self, data: Payload) -> str:
        """Frame of the header, without decoding the rest."""
        if not messages.KNOWN[self.type_name]:
            return ""
        _check_encapsulation(data)
        return _frame(data, "<I" if data[1] == 1 else ">I")


@dataclass(frozen=True, slots=True)
class Ros1Codec:
    """ROS 1 serialization, by the built-in definitions of Noetic."""

    type_name: str
    assumed: bool = False

    def decode(self, data: Payload) -> Any:
        """Message object; E305 where the fields do not fit the payload."""
        try:
            store = messages.typestore(messages.NOETIC)
            return store.deserialize_ros1(memoryview(data), self.type_name)
        except (SerdeError, struct.error, IndexError, MemoryError, OverflowError) as error:
            raise Damaged("E305", f"{self.type_name}: {error}") from None

    def stamp(self, data: Payload) -> int | None:
        """Header stamp in ns without decoding the rest."""
        if not messages.KNOWN[self.type_name]:
            return None
        try:
            seconds, nanoseconds = struct.unpack_from("<II", data, 4)
        except struct.error:
            raise Damaged("E305", "payload ends within its header") from None
        return int(seconds) * 10**9 + int(nanoseconds)

    def frame(self, data: Payload) -> str:
        """Frame of the header, without decoding the rest."""
        return _frame(data, "<I") if messages.KNOWN[self.type_name] else ""


def ros_type(name: str) -> str:
    """Type name in the form ``package/msg/Name``, from any of the forms recorders write."""
    words = [word for word in name.replace("::", "/").split("/") if word not in ("dds_", "")]
    if len(words) == 2:
        words.insert(1, "msg")
    found = "/".join(words).removesuffix("_")
    return messages.TRANSFORMS if found in _TF_NAMES else found


def make_cdr(channel: ChannelFacts) -> Codec | str:
    """Codec of a CDR channel: known by name, its definition equal to a standard one."""
    name = ros_type(channel.schema_name)
    if name not in messages.KNOWN:
        return f"not used: {name}"
    stores = (messages.HUMBLE, messages.JAZZY)
    if channel.schema_encoding != "ros2msg" or not channel.definition.strip():
        return CdrCodec(name, stores, assumed=True)
    return _by_definition(channel, name, stores, 2, lambda store: CdrCodec(name, (store,)))


def make_ros1(channel: ChannelFacts) -> Codec | str:
    """Codec of a ROS 1 channel, chosen as for CDR."""
    name = ros_type(channel.schema_name)
    if name not in messages.KNOWN:
        return f"not used: {name}"
    if not channel.definition.strip():
        return Ros1Codec(name, assumed=True)
    return _by_definition(channel, name, (messages.NOETIC,), 1, lambda store: Ros1Codec(name))


def _by_definition(
    channel: ChannelFacts,
    name: str,
    stores: tuple[str, ...],
    ros_version: int,
    make: Callable[[str], Codec],
) -> Codec | str:
    """Codec of the store whose definition the log's own has the fields of."""
    try:
        stated = parse_definition(channel.definition, name)
    except Damaged as damage:
        return f"{damage.code} {damage.reason}"
    for store in stores:
        if same_layout(stated, known_layout(store, name, ros_version), name):
            return make(store)
    return f"E302 {name} is not the standard type: its fields differ"


def _check_encapsulation(data: Payload) -> None:
    if len(data) < 4 or bytes(data[:2]) not in _CDR_HEADS:
        raise Damaged("E304", f"encapsulation {bytes(data[:4]).hex(' ')} is not plain CDR")


def _frame(data: Payload, form: str) -> str:
    """Text that stands behind stamp and, in ROS 1, sequence number: both take 12 bytes."""
    try:
        (length,) = struct.unpack_from(form, data, 12)
    except struct.error:
        raise Damaged("E305", "payload ends within its header") from None
    if length > len(data) - 16:
        raise Damaged("E305", f"frame of {length} bytes in a payload of {len(data)}")
    return bytes(data[16 : 16 + length]).rstrip(b"\0").decode("utf-8", "replace")


def _with_plain_frame(data: Payload) -> bytes | None:
    """The payload with the odd bytes of its frame_id replaced, None where that is text already."""
    content = bytes(data)
    order = "little" if content[1] == 1 else "big"
    length = int.from_bytes(content[12:16], order)  # type: ignore[arg-type]  # both are allowed
    frame = content[16 : 16 + length]
    try:
        frame.decode()
    except UnicodeDecodeError:
        plain = bytes(byte if byte < 0x80 else ord("?") for byte in frame)
        return content[:16] + plain + content[16 + length :]
    return None
