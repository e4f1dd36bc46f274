"""MCAP records and chunks as bytes: parsed strictly, unpacked within bounds.

Record classes are those of the ``mcap`` package; what it lets through (short fields, unchecked
CRCs, unbounded decompression, unknown compressions read as none: faults.md 1.2) is refused here.
"""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from numpy.typing import NDArray

from fpnav.logs import limits
from fpnav.logs.checksums import crc32

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = range(1, 8)
CHUNK_INDEX, ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA = range(8, 13)
METADATA_INDEX, SUMMARY_OFFSET, DATA_END = range(13, 16)
LOOSE = (SCHEMA, CHANNEL, MESSAGE)
"""Records that may stand in a chunk or, in a file without chunks, on their own."""

MESSAGE_DTYPE = np.dtype(
    [("channel", "<u2"), ("log_ns", "<u8"), ("offset", "<u4"), ("length", "<u4")]
)
"""One message of a block: where its payload lies in the block's unpacked bytes."""


class Damaged(Exception):
    """Bytes that are not what they claim to be; never leaves fpnav.logs."""

    def __init__(self, code: str, reason: str) -> None:
        super().__init__(reason)
        self.code = code
        self.reason = reason


class _Fields(ReadDataStream):
    """Fields of one record; a field that ends early is damage, not a shorter value."""

    def read(self, length: int) -> bytes:
        data = self._stream.read(length)
        self._count += len(data)
        if len(data) != length:
            raise Damaged("E102", f"a field of {length} bytes has {len(data)}")
        return data


RecordT = TypeVar("RecordT", covariant=True)


class RecordClass(Protocol[RecordT]):
    """A record class of the mcap package."""

    @staticmethod
    def read(stream: ReadDataStream) -> RecordT:
        """The record that stands at the stream."""
        ...


def parse(record_class: RecordClass[RecordT], content: bytes) -> RecordT:
    """Record with this content.

    Raises
    ------
    Damaged
        E121 where text is not UTF-8, else E102.
    """
    try:
        return record_class.read(_Fields(io.BytesIO(content)))
    except UnicodeDecodeError:
        raise Damaged("E121", "text is not UTF-8") from None
    except (McapError, struct.error, OverflowError, MemoryError, ValueError) as error:
        raise Damaged("E102", f"unreadable {record_class!r}: {error}") from None


@dataclass(frozen=True, slots=True)
class ChunkHead:
    """Fields of a chunk before its data."""

    size: int
    crc: int
    compression: str
    stored: int
    length: int


def chunk_head(content: bytes | memoryview) -> ChunkHead:
    """Head of a chunk from its first bytes; ``length`` is how many the head itself takes."""
    try:
        _, _, size, crc, name_length = struct.unpack_from("<QQQII", content)
        if name_length > 64:
            raise Damaged("E102", f"compression name of {name_length} bytes")
        name = bytes(content[32 : 32 + name_length]).decode("utf-8", "backslashreplace")
        (stored,) = struct.unpack_from("<Q", content, 32 + name_length)
    except struct.error:
        raise Damaged("E102", "chunk ends within its head") from None
    return ChunkHead(size, crc, name, stored, 40 + name_length)


def unpack(head: ChunkHead, stored: bytes | memoryview) -> bytes:
    """Unpacked bytes of a chunk, never more than it declares, its CRC checked where it has one.

    Raises
    ------
    Damaged
        E110 CRC or stream wrong, E114 over the limit or expands beyond its size, E115 expands to
        less, E116 unknown compression.
    """
    if head.size > limits.CHUNK_BYTES:
        raise Damaged("E114", f"chunk declares {head.size} bytes, limit {limits.CHUNK_BYTES}")
    if head.compression not in _UNPACKERS:
        raise Damaged("E116", f"unknown compression {head.compression!r}")
    data = _UNPACKERS[head.compression](stored, head.size)
    check_unpacked(head, data)
    return data


def check_unpacked(head: ChunkHead, data: bytes | memoryview) -> None:
    """Refuse unpacked bytes that have not the chunk's size and CRC; raises as unpack."""
    if len(data) > head.size:
        raise Damaged("E114", f"chunk expands beyond the {head.size} bytes it declares")
    if len(data) < head.size:
        raise Damaged("E115", f"chunk holds {len(data)} of the {head.size} bytes it declares")
    if head.crc and crc32(data, 0) != head.crc:
        raise Damaged("E110", "chunk CRC is wrong")


def unpack_prefix(head: ChunkHead, stored: bytes) -> bytes:
    """What can be unpacked of a chunk that was cut off; empty where nothing can."""
    try:
        return _PREFIX_UNPACKERS[head.compression](stored, min(head.size, limits.CHUNK_BYTES))
    except (Damaged, KeyError):
        return b""


def _plain(stored: bytes | memoryview, size: int) -> bytes:
    return stored if isinstance(stored, bytes) else bytes(stored)


def _zstd(stored: bytes | memoryview, size: int) -> bytes:
    import zstandard

    try:
        if zstandard.frame_content_size(stored) == size:
            whole: bytes = zstandard.ZstdDecompressor().decompress(stored)
            return whole
        reader = zstandard.ZstdDecompressor().stream_reader(stored, read_across_frames=True)
        return _read_upto(reader, size + 1)
    except zstandard.ZstdError as error:
        raise Damaged("E110", f"zstd stream is damaged: {error}") from None


def _read_upto(reader: Any, size: int) -> bytes:
    parts = []
    while size > 0 and (part := reader.read(min(size, 1 << 20))):
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def _lz4(stored: bytes | memoryview, size: int) -> bytes:
    import lz4.frame

    try:
        data: bytes = lz4.frame.LZ4FrameDecompressor().decompress(stored, max_length=size + 1)
    except (RuntimeError, EOFError, MemoryError, ValueError) as error:
        raise Damaged("E110", f"lz4 stream is damaged: {error}") from None
    return data


def _zstd_prefix(stored: bytes, size: int) -> bytes:
    import zstandard

    parts: list[bytes] = []
    reader = zstandard.ZstdDecompressor().stream_reader(stored)
    try:
        while size > 0 and (part := reader.read(min(size, 1 << 16))):
            parts.append(part)
            size -= len(part)
    except zstandard.ZstdError:
        pass
    return b"".join(parts)


_UNPACKERS = {"": _plain, "zstd": _zstd, "lz4": _lz4}
_PREFIX_UNPACKERS = {"": _plain, "zstd": _zstd_prefix, "lz4": _lz4}


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """Records of one block.

    ``messages`` : (n,) MESSAGE_DTYPE; ``others`` : (opcode, content) in order; ``whole`` : bytes
    that whole records take, less than the block's where it ends in damage.
    """

    messages: NDArray[Any]
    others: list[tuple[int, bytes]]
    whole: int


def split(data: bytes | memoryview) -> Records:
    """Walk the records of a block's unpacked bytes; stops at the first that is not whole."""
    rows: list[tuple[int, int, int, int]] = []
    others: list[tuple[int, bytes]] = []
    at, size = 0, len(data)
    while size - at >= HEAD.size:
        opcode, length = HEAD.unpack_from(data, at)
        body = at + HEAD.size
        if opcode == 0 or length > size - body:
            break
        if opcode == MESSAGE and length >= _MESSAGE.size:
            channel, _, log_ns, _ = _MESSAGE.unpack_from(data, body)
            rows.append((channel, log_ns, body + _MESSAGE.size, length - _MESSAGE.size))
        elif opcode == MESSAGE:
            break
        else:
            others.append((opcode, bytes(data[body : body + length])))
        at = body + length
    return Records(np.array(rows, dtype=MESSAGE_DTYPE), others, at)
