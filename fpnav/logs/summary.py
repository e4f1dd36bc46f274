"""The summary at the end of an MCAP file: a hint, believed where its CRC holds."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import BinaryIO

from mcap import records

from fpnav.logs import container, limits
from fpnav.logs.checksums import crc32
from fpnav.logs.container import HEAD, Damaged, parse

_FOOTER = struct.Struct("<QQI")
_TAIL = HEAD.size + _FOOTER.size + len(container.MAGIC)
_DATA_END_BYTES = HEAD.size + 4


@dataclass(slots=True)
class Summary:
    """What the end of a file says of the rest.

    ``trusted`` : the summary's CRC covered it. ``data_crc`` : CRC of the data section, 0 = none.
    ``end`` : byte where the data section ends.
    """

    trusted: bool = False
    damaged: bool = False
    data_crc: int = 0
    end: int = 0
    schemas: list[records.Schema] = field(default_factory=list)
    channels: list[records.Channel] = field(default_factory=list)
    statistics: records.Statistics | None = None
    chunks: list[records.ChunkIndex] = field(default_factory=list)

    @property
    def chunk_offsets(self) -> list[int]:
        """Where the chunks begin."""
        return [index.chunk_start_offset for index in self.chunks]


def read_summary(handle: BinaryIO, size: int) -> Summary | None:
    """Summary of an open file, None where the file does not end as MCAP files do."""
    if size < len(container.MAGIC) + _TAIL:
        return None
    handle.seek(size - _TAIL)
    tail = handle.read(_TAIL)
    opcode, length = HEAD.unpack_from(tail)
    whole = opcode == container.FOOTER and length == _FOOTER.size
    if not whole or not tail.endswith(container.MAGIC):
        return None
    start, _, crc = _FOOTER.unpack_from(tail, HEAD.size)
    end = start or size - _TAIL
    if not len(container.MAGIC) <= end <= size - _TAIL:
        return Summary(damaged=True, end=size - _TAIL)
    summary = Summary(end=end, data_crc=_data_crc(handle, end))
    if start:
        _fill(summary, handle, size - _TAIL - start, tail, crc)
    return summary


def _data_crc(handle: BinaryIO, end: int) -> int:
    handle.seek(max(0, end - _DATA_END_BYTES))
    data = handle.read(_DATA_END_BYTES)
    if len(data) < _DATA_END_BYTES or HEAD.unpack_from(data) != (container.DATA_END, 4):
        return 0
    return int.from_bytes(data[HEAD.size :], "little")


def _fill(summary: Summary, handle: BinaryIO, length: int, tail: bytes, crc: int) -> None:
    if length > limits.CHUNK_BYTES:
        summary.damaged = True
        return
    handle.seek(summary.end)
    data = handle.read(length)
    covered = data + tail[: HEAD.size + _FOOTER.size - 4]
    summary.damaged = bool(crc) and crc32(covered, 0) != crc
    if summary.damaged:
        return
    try:
        _collect(summary, container.split(data).others)
        summary.trusted = bool(crc)
    except Damaged:
        summary.damaged = True


def _collect(summary: Summary, others: list[tuple[int, bytes]]) -> None:
    for opcode, content in others:
        if opcode == container.SCHEMA:
            summary.schemas.append(parse(records.Schema, content))
        elif opcode == container.CHANNEL:
            summary.channels.append(parse(records.Channel, content))
        elif opcode == container.STATISTICS:
            summary.statistics = parse(records.Statistics, content)
        elif opcode == container.CHUNK_INDEX:
            summary.chunks.append(parse(records.ChunkIndex, content))
