"""Every message encoding that is read: one maker of codecs, one line."""

from __future__ import annotations

from fpnav.logs.codecs import ChannelFacts, Codec, Maker, make_cdr, make_ros1
from fpnav.logs.jsons import make_json


def _protobuf(channel: ChannelFacts) -> Codec | str:
    """The protobuf library is imported by logs that need it alone."""
    from fpnav.logs.protobuf import make_protobuf

    return make_protobuf(channel)


MAKERS: dict[str, Maker] = {
    "cdr": make_cdr,
    "ros1": make_ros1,
    "protobuf": _protobuf,
    "json": make_json,
}


def codec_for(channel: ChannelFacts) -> Codec | str:
    """Codec of a channel, or in words why it has none."""
    if channel.encoding not in MAKERS:
        return f"not decodable: message encoding {channel.encoding!r}"
    if not channel.schema_name and channel.encoding != "json":
        return "E301 no schema"
    return MAKERS[channel.encoding](channel)
