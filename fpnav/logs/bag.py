"""ROS 1 bags of version 2.0, read from front to back: the index at the end is not needed.

A bag whose recorder was killed has no index, and its last chunk may have been left open; its
messages are read all the same, and the loss is told. Bags carry no CRC.
"""

from __future__ import annotations

import bz2
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap import records

from fpnav.errors import LogError
from fpnav.logs import container, limits
from fpnav.logs.container import MESSAGE_DTYPE, ChunkHead, Damaged
from fpnav.logs.contents import Block, Contents, Delivery
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.sniff import looks_like
from fpnav.logs.summary import Summary
from fpnav.logs.tape import Tape

MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = range(2, 8)
_LONGEST_HEADER = 1 << 16
_LOOSE = (_MESSAGE, _CONNECTION)

Fields = dict[bytes, bytes]
Rows = list[tuple[int, int, int, int]]


class BagFile:
    """One open bag; ``contents`` is what ``scan`` found in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle, size = _open(path)
        self.contents = Contents(
            InputFile(path.name, size), kind="ROS 1 bag", profile="ros1", library="rosbag"
        )

    def close(self) -> None:
        """Close the file."""
        self._handle.close()

    def scan(self, ledger: Ledger, *, digest: bool = True) -> Iterator[Delivery]:
        """Every chunk with its messages, in file order; damage is put down, never raised."""
        ledger.inputs.append(self.contents.facts)
        self._handle.seek(0)
        tape = Tape(self._handle, self.path.name, digest=digest, checksum=False)
        yield from _Pass(tape, self.contents, ledger).run()

    def load(self, number: int) -> bytes:
        """Unpacked bytes of a chunk that ``scan`` delivered; raises LogError E120."""
        block = self.contents.blocks[number]
        self._handle.seek(block.offset)
        try:
            stored = self._handle.read(block.head.stored)
            return stored if block.cut else unpack(block.head, stored)
        except Damaged as damage:
            raise LogError(
                f"{self.path.name}: E120 changed while it was read ({damage.reason})"
            ) from None

    def attachment(self, name: str, ledger: Ledger) -> bytes | None:
        """Bags have no attachments."""
        return None


def _open(path: Path) -> tuple[BinaryIO, int]:
    try:
        handle = open(path, "rb")  # noqa: SIM115 - lives as long as the BagFile
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror}") from error
    head = handle.read(512)
    if head.startswith(MAGIC):
        return handle, os.fstat(handle.fileno()).st_size
    handle.close()
    if head.startswith(MAGIC[:8]):
        version = head.split(b"\n", 1)[0].decode("latin1")
        raise LogError(f"{path}: E100 {version} is not read, only version 2.0; rosbag fix it first")
    raise LogError(f"{path}: E100 not a ROS 1 bag, looks like {looks_like(head)}")


def unpack(head: ChunkHead, stored: bytes) -> bytes:
    """Unpacked bytes of a chunk, never more than it declares; raises Damaged."""
    if head.compression != "bz2":
        return container.unpack(head, stored)
    if head.size > limits.CHUNK_BYTES:
        raise Damaged("E114", f"chunk declares {head.size} bytes, limit {limits.CHUNK_BYTES}")
    try:
        data = bz2.BZ2Decompressor().decompress(stored, max_length=head.size + 1)
    except (OSError, ValueError, EOFError) as error:
        raise Damaged("E110", f"bz2 stream is damaged: {error}") from None
    if len(data) > head.size:
        raise Damaged("E114", f"chunk expands beyond the {head.size} bytes it declares")
    if len(data) < head.size:
        raise Damaged("E115", f"chunk holds {len(data)} of the {head.size} bytes it declares")
    return data


def parse_fields(data: bytes) -> Fields:
    """Fields ``name=value`` of a record's header; raises Damaged where they do not fit."""
    fields: Fields = {}
    at = 0
    while at < len(data):
        if len(data) - at < 4:
            raise Damaged("E102", "record header ends within a field")
        (length,) = struct.unpack_from("<I", data, at)
        name, equals, value = data[at + 4 : at + 4 + length].partition(b"=")
        if not equals or at + 4 + length > len(data):
            raise Damaged("E102", "record header with a field that is none")
        fields[name] = value
        at += 4 + length
    return fields


def _number(fields: Fields, name: bytes, form: str) -> int:
    try:
        (value,) = struct.unpack(form, fields[name])
    except (KeyError, struct.error):
        raise Damaged("E102", f"record without a valid {name.decode()}") from None
    return int(value)


def _time(fields: Fields) -> int:
    stamp = _number(fields, b"time", "<Q")
    return (stamp & 0xFFFFFFFF) * 10**9 + (stamp >> 32)


def _text(fields: Fields, name: bytes) -> str:
    return fields.get(name, b"").decode("utf-8", "replace")


class _Pass:
    """One pass over a bag."""

    def __init__(self, tape: Tape, contents: Contents, ledger: Ledger) -> None:
        self.tape = tape
        self.contents = contents
        self.ledger = ledger
        self.numbers: dict[int, int] = {}
        self.stated: dict[int, int] = {}
        self.indexed = False
        self.lost = ""
        self.open_offset = 0
        self.open_rows: Rows = []

    def run(self) -> Iterator[Delivery]:
        self.tape.skip(len(MAGIC))
        while self.tape.left:
            position = self.tape.position
            try:
                yield from self._record()
            except Damaged as damage:
                facts = self.contents.facts
                facts.truncated_at = position
                facts.damage = f"{damage.code} {damage.reason} at byte {position:,}"
                break
        yield from self._flush()
        self._close()

    def _record(self) -> Iterator[Delivery]:
        """One record of the file; raises Damaged where it cannot be told where the next begins."""
        start = self.tape.position
        head = self._sized(_LONGEST_HEADER)
        fields = parse_fields(head)
        op = _number(fields, b"op", "<B")
        (length,) = struct.unpack("<I", self._exactly(4))
        offset = self.tape.position
        if op not in _LOOSE:
            yield from self._flush()
        if op == _CHUNK:
            yield from self._chunk(fields, offset, length)
        elif length > self.tape.left:
            raise Damaged("E102", f"truncated ({length:,} bytes, {self.tape.left:,} left)")
        elif op in _LOOSE:
            yield from self._loose(op, fields, start, length)
        elif op == _CHUNK_INFO:
            self._chunk_info(fields, self._exactly(length))
        elif op == _BAG:
            self.indexed = _number(fields, b"index_pos", "<Q") != 0
        self.tape.skip(offset + length - self.tape.position)

    def _chunk(self, fields: Fields, offset: int, length: int) -> Iterator[Delivery]:
        compression = _text(fields, b"compression")
        size = _number(fields, b"size", "<I")
        cut = length > self.tape.left
        stored = self.tape.read(min(length, self.tape.left))
        if length == 0:
            return
        head = ChunkHead(size, 0, "" if compression == "none" else compression, len(stored), 0)
        self.contents.compressions[compression] += 1
        try:
            data = container.unpack_prefix(head, stored) if cut else unpack(head, stored)
        except Damaged as damage:
            self.ledger.note(damage.code, f"{damage.reason} at byte {offset:,}")
            self.lost = f"{damage.code} a chunk is damaged and no index says what it held"
            return
        plain = ChunkHead(len(data), 0, "", len(data), 0) if cut and not head.compression else head
        if not cut or not head.compression:
            rows = self._walk(data, whole=not cut)
            self.contents.blocks.append(Block(offset, plain, cut=cut))
            yield self._delivery(data, rows)
        if cut:
            raise Damaged("E102", f"truncated in a chunk ({length:,} bytes, {len(stored):,} left)")

    def _walk(self, data: bytes, *, whole: bool) -> Rows:
        """Messages of a chunk; connections are taken down on the way."""
        rows: Rows = []
        at = 0
        try:
            while at < len(data):
                head, at = _sized(data, at)
                body, after = _bounds(data, at)
                fields = parse_fields(head)
                row = self._take(fields, data[body:after], body)
                if row is not None:
                    rows.append(row)
                at = after
        except Damaged as damage:
            if whole:
                facts = self.contents.facts
                facts.damage = facts.damage or f"{damage.code} {damage.reason} within a chunk"
        return rows

    def _take(self, fields: Fields, data: bytes, offset: int) -> tuple[int, int, int, int] | None:
        op = _number(fields, b"op", "<B")
        if op == _CONNECTION:
            self._define(fields, data)
        if op != _MESSAGE:
            return None
        channel = self._channel(_number(fields, b"conn", "<I"))
        return channel, _time(fields), offset, len(data)

    def _channel(self, connection: int) -> int:
        """Small number of a connection, which a channel id must be."""
        return self.numbers.setdefault(connection, len(self.numbers) + 1)

    def _define(self, fields: Fields, data: bytes) -> None:
        number = self._channel(_number(fields, b"conn", "<I"))
        about = parse_fields(data)
        definition = about.get(b"message_definition", b"")
        schema = records.Schema(number, definition, "ros1msg", _text(about, b"type"))
        topic = _text(fields, b"topic")
        self.contents.define(schema)
        self.contents.define(records.Channel(number, topic, "ros1", {}, number))

    def _loose(self, op: int, fields: Fields, start: int, length: int) -> Iterator[Delivery]:
        """A record outside of chunks: of a chunk that was left open, or of the index."""
        data = self._exactly(length)
        if op == _CONNECTION:
            self._define(fields, data)
            return
        offset = self.tape.position - length
        if not self.open_rows:
            self.open_offset = offset
        channel = self._channel(_number(fields, b"conn", "<I"))
        self.open_rows.append((channel, _time(fields), offset - self.open_offset, length))
        if self.tape.position - self.open_offset > limits.CACHE_BYTES // 16:
            yield from self._flush()

    def _flush(self) -> Iterator[Delivery]:
        """Deliver the messages of a chunk that was left open."""
        if not self.open_rows:
            return
        _, _, last, length = self.open_rows[-1]
        size = last + length
        data = self.tape.again(self.open_offset, size)
        self.contents.blocks.append(Block(self.open_offset, ChunkHead(size, 0, "", size, 0)))
        rows, self.open_rows = self.open_rows, []
        yield self._delivery(data, rows)

    def _delivery(self, data: bytes, rows: Rows) -> Delivery:
        number = len(self.contents.blocks) - 1
        return Delivery(number, data, np.array(rows, dtype=MESSAGE_DTYPE))

    def _chunk_info(self, fields: Fields, data: bytes) -> None:
        """What the index says a chunk holds: connection and count, in turn."""
        for at in range(0, len(data) - 7, 8):
            connection, count = struct.unpack_from("<II", data, at)
            number = self._channel(connection)
            self.stated[number] = self.stated.get(number, 0) + count

    def _sized(self, longest: int) -> bytes:
        (length,) = struct.unpack("<I", self._exactly(4))
        if length > min(longest, self.tape.left):
            raise Damaged("E102", f"truncated or no record header ({length:,} bytes)")
        return self._exactly(length)

    def _exactly(self, length: int) -> bytes:
        data = self.tape.read(length)
        if len(data) != length:
            raise Damaged("E102", "truncated in a record header")
        return data

    def _close(self) -> None:
        facts = self.contents.facts
        if not self.indexed:
            facts.damage = facts.damage or "E102 the bag was not closed, its recorder was killed"
        if not self.stated:
            facts.damage = facts.damage or self.lost
        elif not facts.damage:
            statistics = records.Statistics(0, 0, self.stated, 0, 0, 0, 0, 0, 0)
            self.contents.summary = Summary(trusted=True, statistics=statistics)
        facts.sha256 = self.tape.finish()
        if facts.damage or self.lost:
            facts.integrity = "damaged"
        self.ledger.note("A11", "unverified (no CRC in file)")


def _sized(data: bytes, at: int) -> tuple[bytes, int]:
    """Bytes of a prefixed piece and where it ends."""
    start, end = _bounds(data, at)
    return data[start:end], end


def _bounds(data: bytes, at: int) -> tuple[int, int]:
    if len(data) - at < 4:
        raise Damaged("E102", "record ends early")
    (length,) = struct.unpack_from("<I", data, at)
    if length > len(data) - at - 4:
        raise Damaged("E102", f"record of {length:,} bytes, {len(data) - at - 4:,} left")
    return at + 4, at + 4 + length
