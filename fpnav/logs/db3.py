"""ROS 2 bags in SQLite (.db3), row by row; metadata.yaml is not needed.

A block is a batch of rows. Rows compressed one by one are unpacked within bounds. SQLite carries
no CRC.
"""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from mcap import records

from fpnav.errors import LogError
from fpnav.logs import limits
from fpnav.logs.container import MESSAGE_DTYPE, ChunkHead, Damaged, unpack
from fpnav.logs.contents import Block, Contents, Delivery
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.text import text_facts
from fpnav.publish import scratch_copy

MAGIC = b"SQLite format 3\x00"
_ZSTD = b"\x28\xb5\x2f\xfd"
_BATCH_BYTES = 1 << 20
_BATCH_ROWS = 4096
_MOST_TOPICS = 2**16
_HEADER_BYTES = 100
_ROWS = "SELECT id, topic_id, timestamp, data FROM messages"

Row = tuple[int, int, int, bytes]

_ERRORS = (sqlite3.Error, UnicodeError, OverflowError)
"""What sqlite3 raises on a damaged file: its own messages may hold bytes that are no text."""


class Db3File:
    """One open db3; ``contents`` is what ``scan`` found in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._base = _open(path)
        self.contents = Contents(
            InputFile(path.name, 0), kind="ROS 2 db3", profile="ros2", library="rosbag2 sqlite3"
        )
        self._spans: list[tuple[int, int]] = []
        self._define()

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def scan(self, ledger: Ledger, *, digest: bool = True) -> Iterator[Delivery]:
        """Every batch of messages, in the order they were recorded; damage is put down."""
        facts = text_facts(self.path) if digest else InputFile(self.path.name, self._size())
        facts.integrity = "unverified"
        self.contents.facts = facts
        ledger.inputs.append(facts)
        ledger.note("A11", "unverified (no CRC in file)")
        if missing := _missing(self.path):
            self._damage(f"truncated, {missing:,} bytes are missing")
        batch: list[Row] = []
        held = 0
        for row in self._rows(ledger):
            batch.append(row)
            held += len(row[3])
            if held > _BATCH_BYTES or len(batch) >= _BATCH_ROWS:
                yield self._deliver(batch)
                batch, held = [], 0
        if batch:
            yield self._deliver(batch)

    def load(self, number: int) -> bytes:
        """Bytes of a batch that ``scan`` delivered; raises LogError E120."""
        first, last = self._spans[number]
        try:
            found = self._base.execute(
                f"{_ROWS} WHERE id BETWEEN ? AND ? ORDER BY id", (first, last)
            )
            return b"".join(row[3] for row in self._whole(found, None))
        except _ERRORS as error:
            raise LogError(f"{self.path.name}: E120 changed while it was read: {error}") from None

    def attachment(self, name: str, ledger: Ledger) -> bytes | None:
        """A db3 has no attachments."""
        return None

    def _size(self) -> int:
        return self.path.stat().st_size

    def _rows(self, ledger: Ledger) -> Iterator[Row]:
        """Rows that are whole; damage of the database ends them."""
        last = 0
        try:
            for row in self._whole(self._base.execute(f"{_ROWS} ORDER BY id"), ledger):
                last = row[0]
                yield row
        except _ERRORS as error:
            self._damage(f"cannot be read after message {last}: {error}")

    def _damage(self, reason: str) -> None:
        """Put down a loss that cannot be counted; the first is the one to tell."""
        facts = self.contents.facts
        facts.damage = facts.damage or f"E102 the database {reason}"
        facts.integrity = "damaged"

    def _whole(self, found: Iterator[Any], ledger: Ledger | None) -> Iterator[Row]:
        """Rows that can be used; the others are counted where there is a ledger."""
        for row in found:
            try:
                yield _row(*row)
            except Damaged as damage:
                if ledger is not None:
                    if _fits(row[1], _MOST_TOPICS):
                        self.contents.skip(row[1], damage.code, 1)
                    else:
                        self._damage(f"has a {damage.reason}")
                    ledger.note(damage.code, damage.reason)

    def _deliver(self, batch: list[Row]) -> Delivery:
        rows = []
        at = 0
        for _, topic, log_ns, data in batch:
            rows.append((topic, log_ns, at, len(data)))
            at += len(data)
        self._spans.append((batch[0][0], batch[-1][0]))
        self.contents.blocks.append(Block(batch[0][0], ChunkHead(at, 0, "", at, 0)))
        data = b"".join(row[3] for row in batch)
        return Delivery(len(self._spans) - 1, data, np.array(rows, dtype=MESSAGE_DTYPE))

    def _define(self) -> None:
        """Topics as channels; their definitions where the recorder stored them (Iron and later)."""
        try:
            topics = self._base.execute(
                "SELECT id, name, type, serialization_format FROM topics"
            ).fetchall()
        except _ERRORS as error:
            self.close()
            raise LogError(
                f"{self.path}: E100 a SQLite file, but no ROS 2 bag that can be read: {error}"
            ) from None
        definitions = self._definitions()
        for number, name, type_name, encoding in topics:
            words = all(isinstance(word, str) for word in (name, type_name, encoding))
            if not words or not _fits(number, _MOST_TOPICS):
                continue  # its messages are of an unknown topic: counted as such
            kind, text = definitions.get(type_name, ("", b""))
            self.contents.define(records.Schema(number, text, kind, type_name))
            self.contents.define(records.Channel(number, name, encoding, {}, number))

    def _definitions(self) -> dict[str, tuple[str, bytes]]:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        with contextlib.suppress(*_ERRORS):
            return {row[0]: (str(row[1]), _as_bytes(row[2])) for row in self._base.execute(query)}
        return {}


def _open(path: Path) -> sqlite3.Connection:
    """Open read-only; a write-ahead log beside the file is taken in where it can be."""
    try:
        with open(path, "rb") as handle:
            head = handle.read(len(MAGIC))
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror}") from error
    if head != MAGIC:
        raise LogError(f"{path}: E100 not a SQLite file")
    failure: Exception | None = None
    for mode in ("mode=ro", "mode=ro&immutable=1"):
        try:
            return _connect(path, mode)
        except _ERRORS as error:
            failure = error
    try:
        return _open_cut(path)
    except (*_ERRORS, OSError):
        raise LogError(f"{path}: E100 SQLite file cannot be read: {failure}") from None


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    base = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)
    base.text_factory = lambda data: data.decode("utf-8", "replace")
    base.execute("SELECT name FROM sqlite_master").fetchall()
    return base


def _open_cut(path: Path) -> sqlite3.Connection:
    """Open a copy of a file that was cut off, its header set to the pages there are.

    SQLite refuses a file that is shorter than its header says; rows in whole pages are whole.
    The copy has no name any more once it is open.
    """
    with scratch_copy(path) as copy:
        head = copy.read(_HEADER_BYTES)
        page = _page_bytes(head)
        copy.truncate(copy.seek(0, 2) // page * page)
        copy.seek(28)
        copy.write((path.stat().st_size // page).to_bytes(4, "big"))
        copy.flush()
        return _connect(Path(copy.name), "mode=ro&immutable=1")


def _page_bytes(head: bytes) -> int:
    """Size of a page by the header of a database."""
    size = int.from_bytes(head[16:18], "big")
    return 65536 if size == 1 else max(size, 512)


def _missing(path: Path) -> int:
    """Bytes by which a file is shorter than its header says, where that can be relied on."""
    with open(path, "rb") as handle:
        head = handle.read(_HEADER_BYTES)
    if len(head) < _HEADER_BYTES or head[24:28] != head[92:96]:
        return 0
    pages = int.from_bytes(head[28:32], "big")
    return max(0, pages * _page_bytes(head) - path.stat().st_size)


def _fits(value: Any, limit: int) -> bool:
    """Whether a cell, which may be of any type in SQLite, is a number below a limit."""
    return isinstance(value, int) and 0 <= value < limit


def _row(number: Any, topic: Any, log_ns: Any, data: Any) -> Row:
    """A row of the table of messages; raises Damaged where a cell cannot be what it should be."""
    if not _fits(topic, _MOST_TOPICS):
        raise Damaged("E117", f"message {number} of topic {topic!r}")
    if not _fits(log_ns, 2**63):
        raise Damaged("E204", f"message {number} of time {log_ns!r}")
    return number, topic, log_ns, _payload(data)


def _payload(data: Any) -> bytes:
    """A row's payload, unpacked where rows were compressed one by one."""
    payload = _as_bytes(data)
    if len(payload) > limits.MESSAGE_BYTES:
        raise Damaged("E113", f"message of {len(payload):,} bytes is over the limit")
    if not payload.startswith(_ZSTD):
        return payload
    import zstandard

    try:
        size = zstandard.frame_content_size(payload)
    except zstandard.ZstdError as error:
        raise Damaged("E110", f"zstd stream is damaged: {error}") from None
    if not 0 <= size <= limits.MESSAGE_BYTES:
        raise Damaged("E114", f"message expands to {size:,} bytes")
    return unpack(ChunkHead(size, 0, "zstd", len(payload), 0), payload)


def _as_bytes(value: Any) -> bytes:
    if isinstance(value, str):
        return value.encode("utf-8", "replace")
    return value if isinstance(value, bytes) else b""
