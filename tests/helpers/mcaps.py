"""MCAP files with the plain ``mcap`` writer, and bytes of single records."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from fpnav.logs.container import MAGIC
from fpnav.logs.ledger import Ledger
from fpnav.logs.reader import LogFile

KINDS = {
    "zstd": {"compression": CompressionType.ZSTD},
    "lz4": {"compression": CompressionType.LZ4},
    "none": {"compression": CompressionType.NONE},
    "unchunked": {"use_chunking": False},
    "unchunked-crc": {"use_chunking": False, "enable_data_crcs": True},
    "no-crc": {"compression": CompressionType.NONE, "enable_crcs": False},
}


def plain_log(kind: str = "zstd", messages: int = 12, size: int = 40, **options: Any) -> bytes:
    """Messages on two topics without a schema, several chunks."""
    stream = io.BytesIO()
    writer = Writer(stream, **{"chunk_size": 200, **KINDS[kind], **options})
    writer.start(profile="", library="test")
    channels = [writer.register_channel(name, "text", 0) for name in ("/a", "/b")]
    for i in range(messages):
        data = bytes([65 + i]) * size
        writer.add_message(channels[i % 2], log_time=i, data=data, publish_time=i, sequence=i)
    writer.finish()
    return stream.getvalue()


def read_all(path: Path) -> tuple[list[tuple[int, int, bytes]], Ledger]:
    """(channel, log time, payload) of every message, and the ledger of the reading."""
    ledger = Ledger()
    found = []
    with LogFile(path) as file:
        for delivery in file.scan(ledger):
            for channel, log_ns, offset, length in delivery.messages.tolist():
                found.append((channel, log_ns, delivery.data[offset : offset + length]))
        for skipped in file.contents.skipped.values():
            ledger.topic("(lost)").skipped.update(skipped)
        stated = file.contents.summary
        if stated and stated.trusted and stated.statistics:
            lost = sum(sum(s.values()) for s in file.contents.skipped.values())
            missing = stated.statistics.message_count - len(found) - lost
            ledger.topic("(lost)").unread = max(missing, 0)
    return found, ledger


def record(opcode: int, content: bytes) -> bytes:
    """One record."""
    return struct.pack("<BQ", opcode, len(content)) + content


def text(value: str | bytes) -> bytes:
    """A prefixed string."""
    data = value if isinstance(value, bytes) else value.encode()
    return struct.pack("<I", len(data)) + data


def header() -> bytes:
    """Header record."""
    return record(1, text("") + text("test"))


def channel(number: int, topic: str | bytes, schema: int = 0, encoding: str = "text") -> bytes:
    """Channel record."""
    return record(
        4, struct.pack("<HH", number, schema) + text(topic) + text(encoding) + struct.pack("<I", 0)
    )


def schema(number: int, name: str, data: bytes = b"", encoding: str = "ros2msg") -> bytes:
    """Schema record."""
    return record(3, struct.pack("<H", number) + text(name) + text(encoding) + text(data))


def message(number: int, log_ns: int, data: bytes) -> bytes:
    """Message record."""
    return record(5, struct.pack("<HIQQ", number, 0, log_ns, log_ns) + data)


def chunk(stored: bytes, size: int, crc: int = 0, compression: str = "") -> bytes:
    """Chunk record."""
    head = struct.pack("<QQQI", 0, 0, size, crc) + text(compression)
    return record(6, head + struct.pack("<Q", len(stored)) + stored)


def ending(summary: bytes = b"", start: int = 0, data_crc: int = 0) -> bytes:
    """DataEnd, footer and magic."""
    footer = record(2, struct.pack("<QQI", start, 0, 0))
    return record(15, struct.pack("<I", data_crc)) + summary + footer + MAGIC


def whole(*parts: bytes) -> bytes:
    """A valid file of these records, without a summary."""
    return MAGIC + header() + b"".join(parts) + ending()
