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

MAGIC = b"SQLite format 3\x00"
_ZSTD = b"\x28\xb5\x2f\xfd"
_BATCH_BYTES = 1 << 20
_BATCH_ROWS = 4096
_ROWS = "SELECT id, topic_id, timestamp, data FROM messages"

Row = tuple[int, int, int, bytes]


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
            return b"".join(_payload(row[3]) for row in found)
        except (sqlite3.Error, Damaged) as error:
            raise LogError(f"{self.path.name}: E120 changed while it was read: {error}") from None

    def attachment(self, name: str, ledger: Ledger) -> bytes | None:
        """A db3 has no attachments."""
        return None

    def _size(self) -> int:
        return self.path.stat().st_size

    def _rows(self, ledger: Ledger) -> Iterator[Row]:
        """Rows that are whole; damage of the database ends them."""
        count = 0
        try:
            for row in self._base.execute(f"{_ROWS} ORDER BY id"):
                count += 1
                try:
                    yield row[0], row[1], row[2], _payload(row[3])
                except Damaged as damage:
                    self.contents.skip(row[1], damage.code, 1)
                    ledger.note(damage.code, damage.reason)
        except sqlite3.Error as error:
            facts = self.contents.facts
            facts.damage = f"E102 database is damaged after message {count}: {error}"
            facts.integrity = "damaged"

    def _deliver(self, batch: list[Row]) -> Delivery:
        rows = []
        at = 0
        for _, topic, log_ns, data in batch:
            rows.append((topic, max(log_ns, 0), at, len(data)))
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
        except sqlite3.Error as error:
            self.close()
            raise LogError(
                f"{self.path}: E100 a SQLite file, but no ROS 2 bag that can be read: {error}"
            ) from None
        definitions = self._definitions()
        for number, name, type_name, encoding in topics:
            kind, text = definitions.get(type_name, ("", b""))
            self.contents.define(records.Schema(number, text, kind, type_name))
            self.contents.define(records.Channel(number, name, encoding, {}, number))

    def _definitions(self) -> dict[str, tuple[str, bytes]]:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        with contextlib.suppress(sqlite3.Error):
            return {row[0]: (row[1], _as_bytes(row[2])) for row in self._base.execute(query)}
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
    failure: sqlite3.Error | None = None
    for mode in ("mode=ro", "mode=ro&immutable=1"):
        try:
            base = sqlite3.connect(f"file:{quote(str(path.resolve()))}?{mode}", uri=True)
            base.text_factory = lambda data: data.decode("utf-8", "replace")
            base.execute("SELECT name FROM sqlite_master").fetchall()
            return base
        except sqlite3.Error as error:
            failure = error
    raise LogError(f"{path}: E100 SQLite file cannot be read: {failure}")


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
    return value.encode() if isinstance(value, str) else bytes(value or b"")
