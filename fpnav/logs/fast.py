"""All scans or ranges of a topic in columns, straight from the chunks by the index.

The summary's chunk index says which chunks hold the topic and when; the message index behind a
chunk says where in it the messages lie. Neither is believed: a chunk's CRC is checked, and an
index that does not account for every byte of its chunk is dropped and the chunk walked, as are
chunks of few messages, where that is quicker. Scans are decoded a few hundred at a time. Without
a summary that holds there is no short way: ``open_log`` reads such a file.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import RawIOBase
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np
from mcap import records
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.logs import columns, container, limits
from fpnav.logs.codecs import CdrCodec, ChannelFacts
from fpnav.logs.columns import Payloads, ScanColumns
from fpnav.logs.container import HEAD, Damaged
from fpnav.logs.encodings import codec_for
from fpnav.logs.messages import HUMBLE, LASER_SCAN
from fpnav.logs.summary import Summary, read_summary

_RECORD = np.dtype([("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"),
                    ("log_ns", "<u8"), ("publish_ns", "<u8")])  # fmt: skip
_ENTRY = np.dtype([("log_ns", "<u8"), ("offset", "<u8")])
_MESSAGE = struct.Struct("<HIQ")
_WALKED_BELOW = 1000
"""Messages in a chunk below which walking its records is quicker than checking its index."""

_BATCH_BYTES = 1 << 20


Rows = list[tuple[int, int, int]]
"""Log time, offset and length of payloads within a chunk's unpacked bytes."""


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """Messages of wanted channels in one chunk."""

    data: bytes | memoryview
    rows: Rows


def read_scans(
    path: Path, topics: Sequence[str], start_ns: int = 0, end_ns: int = 2**63 - 1
) -> Iterator[ScanColumns]:
    """All scans of some topics with log times in [start_ns, end_ns), in columns.

    Each yield holds scans of one layout, ``rows`` counting within a batch. Topics are told apart
    by the frame.

    Raises
    ------
    LogError
        The file has no summary that holds, a topic is absent or of another kind, a chunk is
        damaged, or a scan does not fit its payload.
    """
    with open(path, "rb", buffering=0) as handle:
        summary = _summary(cast(BinaryIO, handle), path)
        channels = {number for topic in topics for number in _channels(summary, topic, path)}
        reader = _ChunkReader(cast(RawIOBase, handle), channels)
        gathered = _Gathered()
        for index in _chunks(summary, channels, start_ns, end_ns):
            try:
                gathered.add(reader.located(index), start_ns, end_ns)
                if gathered.size >= _BATCH_BYTES:
                    yield from _in_columns(gathered.take())
            except Damaged as damage:
                raise LogError(
                    f"{path.name}: {damage.code} {damage.reason} in the chunk at byte "
                    f"{index.chunk_start_offset:,}; open_log reads what is whole"
                ) from None
        yield from _last(gathered, path)


def _last(gathered: _Gathered, path: Path) -> Iterator[ScanColumns]:
    try:
        yield from _in_columns(gathered.take())
    except Damaged as damage:
        raise LogError(f"{path.name}: {damage.code} {damage.reason}") from None


class _Gathered:
    """Payloads of several chunks, until there are enough to be decoded at once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self.size = 0

    def add(self, found: Located, start_ns: int, end_ns: int) -> None:
        """Take the messages of a chunk that lie in a window of time."""
        for log_ns, offset, length in found.rows:
            if start_ns <= log_ns < end_ns:
                self._parts.append(bytes(found.data[offset : offset + length]))
                self.size += length

    def take(self) -> Payloads:
        """What was gathered, which is forgotten."""
        lengths = np.array([len(part) for part in self._parts], dtype=np.int64)
        payloads = Payloads(b"".join(self._parts), np.cumsum(lengths) - lengths, lengths)
        self._parts, self.size = [], 0
        return payloads


class _ChunkReader:
    """Reads chunks into one buffer, which is used again and again."""

    def __init__(self, handle: RawIOBase, channels: set[int]) -> None:
        self._handle = handle
        self._channels = channels
        self._buffer = bytearray()

    def located(self, index: records.ChunkIndex) -> Located:
        """Wanted messages of a chunk, its CRC checked; they hold until the next is read."""
        length, behind = index.chunk_length, index.message_index_length
        if length > limits.RECORD_BYTES or behind > limits.CHUNK_BYTES:
            raise Damaged("E113", f"chunk of {length:,} bytes is over the limit")
        whole = self._read(index.chunk_start_offset, length + behind)
        if length < HEAD.size or len(whole) < length or whole[0] != container.CHUNK:
            raise Damaged("E102", "the index leads to no chunk")
        chunk = whole[HEAD.size : length]
        head = container.chunk_head(chunk)
        stored = chunk[head.length : head.length + head.stored]
        data = stored if not head.compression else container.unpack(head, stored)
        container.check_unpacked(head, data)
        rows: Rows | None = None
        if behind >= _WALKED_BELOW * _ENTRY.itemsize:
            entries = _entries(bytes(whole[length:]))
            rows = indexed(data, entries, self._channels) if entries is not None else None
        return Located(data, walked(data, self._channels) if rows is None else rows)

    def _read(self, offset: int, length: int) -> memoryview:
        """Bytes of the file in the buffer, fewer where it ends."""
        if len(self._buffer) < length:
            self._buffer = bytearray(length)
        view = memoryview(self._buffer)[:length]
        self._handle.seek(offset)
        done = 0
        while done < length and (count := self._handle.readinto(view[done:])):
            done += count
        return view[:done]


def _in_columns(payloads: Payloads) -> Iterator[ScanColumns]:
    """Groups of one layout; what is of none goes through the strict decoder, one by one."""
    groups, odd = columns.scans(payloads)
    yield from groups
    codec = CdrCodec(LASER_SCAN, (HUMBLE,))
    for row in odd.tolist():
        start = int(payloads.offsets[row])
        data = bytes(payloads.data[start : start + int(payloads.lengths[row])])
        message = codec.decode(data)
        fixed = (message.angle_min, message.angle_increment, message.range_min, message.range_max)
        yield ScanColumns(
            np.array([row]),
            str(message.header.frame_id),
            np.array([codec.stamp(data)], dtype=np.int64),
            np.array([message.ranges], dtype=np.float32),
            *(np.array([value], dtype=np.float32) for value in fixed),
        )


def _summary(handle: BinaryIO, path: Path) -> Summary:
    summary = read_summary(handle, path.stat().st_size)
    if summary is None or not summary.trusted or not summary.chunks:
        raise LogError(f"{path.name}: no chunk index that holds; open_log reads the file without")
    return summary


def _channels(summary: Summary, topic: str, path: Path) -> set[int]:
    """Channels of a topic, all of them scans in CDR."""
    schemas = {schema.id: schema for schema in summary.schemas}
    found = [channel for channel in summary.channels if channel.topic == topic]
    for channel in found:
        schema = schemas.get(channel.schema_id)
        name, kind, text = (schema.name, schema.encoding, schema.data) if schema else ("", "", b"")
        codec = codec_for(ChannelFacts(channel.message_encoding, name, kind, text))
        if not isinstance(codec, CdrCodec) or codec.type_name != LASER_SCAN:
            raise LogError(f"{path.name}: {topic} does not carry {LASER_SCAN} in CDR")
    if not found:
        raise LogError(f"{path.name}: no topic {topic}")
    return {channel.id for channel in found}


def _chunks(
    summary: Summary, channels: set[int], start_ns: int, end_ns: int
) -> Iterator[records.ChunkIndex]:
    """Chunks that may hold a wanted message; one without a message index may hold any."""
    for index in summary.chunks:
        offsets = index.message_index_offsets
        holds = not offsets or not channels.isdisjoint(offsets)
        if holds and index.message_start_time < end_ns and index.message_end_time >= start_ns:
            yield index


def _entries(data: bytes) -> dict[int, NDArray[Any]] | None:
    """Message index of a chunk by channel, None where it is not whole."""
    found: dict[int, NDArray[Any]] = {}
    others = container.split(data)
    if others.whole != len(data) or not others.others:
        return None
    for opcode, content in others.others:
        size = int.from_bytes(content[2:6], "little")
        if opcode != container.MESSAGE_INDEX or size % _ENTRY.itemsize or len(content) < 6 + size:
            return None
        channel = int.from_bytes(content[:2], "little")
        found[channel] = np.frombuffer(content, _ENTRY, size // _ENTRY.itemsize, 6)
    return found


def indexed(
    data: bytes | memoryview, entries: dict[int, NDArray[Any]], channels: set[int]
) -> Rows | None:
    """Wanted messages by the index; None where the index does not account for the whole chunk.

    Every entry must lead to a message of its channel and time, and the messages of all channels
    together must leave no gap but for schemas and channels.
    """
    every = np.concatenate(list(entries.values()))
    owners = np.repeat(np.array(list(entries), np.uint16), [len(e) for e in entries.values()])
    order = np.argsort(every["offset"], kind="stable")
    every, owners = every[order], owners[order]
    last = len(data) - _RECORD.itemsize
    if len(every) == 0 or last < 0 or int(every["offset"][-1]) > last:
        return None
    starts = every["offset"].astype(np.int64)
    places = Payloads(data, starts, np.full(len(starts), _RECORD.itemsize))
    found = places.one(0, _RECORD)
    honest = (found["opcode"] == container.MESSAGE) & (found["channel"] == owners)
    honest &= (found["log_ns"] == every["log_ns"]) & (found["length"] <= np.uint64(len(data)))
    if not honest.all():
        return None
    ends = starts + HEAD.size + found["length"].astype(np.int64)
    if not _gapless(data, starts, ends):
        return None
    mine = np.zeros(len(owners), dtype=np.bool_)
    for channel in channels:
        mine |= owners == channel
    offsets = starts[mine] + _RECORD.itemsize
    lengths = ends[mine] - offsets
    times = every["log_ns"][mine]
    return list(zip(times.tolist(), offsets.tolist(), lengths.tolist(), strict=True))


def _gapless(data: bytes | memoryview, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> bool:
    """Whether between, before and behind the messages stand schemas and channels alone."""
    edges = np.concatenate([[0], ends])
    nexts = np.concatenate([starts, [len(data)]])
    if np.any(edges > nexts):
        return False
    for place in np.flatnonzero(edges < nexts).tolist():
        between = container.split(data[int(edges[place]) : int(nexts[place])])
        size = int(nexts[place] - edges[place])
        if between.whole != size or len(between.messages):
            return False
    return True


def walked(data: bytes | memoryview, channels: set[int]) -> Rows:
    """Wanted messages of a chunk, record by record; raises Damaged where it is not whole."""
    rows: Rows = []
    at, size, head = 0, len(data), _RECORD.itemsize
    while size - at >= HEAD.size:
        opcode, length = HEAD.unpack_from(data, at)
        end = at + HEAD.size + length
        if opcode == 0 or end > size:
            break
        if opcode == container.MESSAGE:
            if end - at < head:
                break
            channel, _, log_ns = _MESSAGE.unpack_from(data, at + HEAD.size)
            if channel in channels:
                rows.append((log_ns, at + head, end - at - head))
        at = end
    if at != size:
        raise Damaged("E102", f"records end at {at:,} of {size:,}")
    return rows
