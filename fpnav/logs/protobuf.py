"""Foxglove messages in protobuf, decoded with the descriptors the log carries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory

from fpnav.logs import foxglove, limits, messages
from fpnav.logs.codecs import ChannelFacts, Codec, Payload
from fpnav.logs.container import Damaged

_BAD_FIELDS = (AttributeError, TypeError, ValueError, OverflowError)


@dataclass(frozen=True, slots=True)
class ProtobufCodec:
    """One of the Foxglove schemas in protobuf."""

    type_name: str
    parse: Callable[[bytes], Any]
    shape: Callable[[Any], Any]
    assumed: bool = False

    def decode(self, data: Payload) -> Any:
        """Message object; E305 where the payload is no message of the schema."""
        message = self._parsed(data)
        try:
            return self.shape(message)
        except _BAD_FIELDS as error:
            raise Damaged("E305", f"{self.type_name}: {error}") from None

    def stamp(self, data: Payload) -> int | None:
        """Timestamp in ns, None for transforms, which may have several."""
        if not messages.KNOWN[self.type_name]:
            return None
        try:
            return foxglove.stamp_of(self._parsed(data))
        except _BAD_FIELDS as error:
            raise Damaged("E305", f"{self.type_name}: {error}") from None

    def frame(self, data: Payload) -> str:
        """Frame the message names."""
        if not messages.KNOWN[self.type_name]:
            return ""
        return str(self.decode(data).header.frame_id)

    def _parsed(self, data: Payload) -> Any:
        try:
            return self.parse(bytes(data))
        except (DecodeError, *_BAD_FIELDS) as error:
            raise Damaged("E305", f"{self.type_name}: {error}") from None


def make_protobuf(channel: ChannelFacts) -> Codec | str:
    """Codec of a protobuf channel whose schema is one of Foxglove's."""
    name = channel.schema_name
    if name not in foxglove.SHAPES:
        return f"not used: {name}"
    if len(channel.definition) > limits.SCHEMA_BYTES:
        return f"E303 definition of {len(channel.definition)} bytes"
    type_name, shape = foxglove.SHAPES[name]
    schema = Schema(id=1, data=channel.definition, encoding="protobuf", name=name)
    try:
        parse = DecoderFactory().decoder_for("protobuf", schema)
    except (McapError, DecodeError, KeyError, RecursionError, *_BAD_FIELDS) as error:
        return f"E301 descriptors of {name} cannot be used: {error}"
    return ProtobufCodec(type_name, parse, shape) if parse else "E301 no protobuf schema"
