"""What one pass over a container finds, and what a container of messages is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from mcap import records
from numpy.typing import NDArray

from fpnav.logs.attachments import AttachmentFacts
from fpnav.logs.container import ChunkHead
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.summary import Summary


@dataclass(frozen=True, slots=True)
class Block:
    """Where the records of a chunk, or of a run of loose records, lie in the file."""

    offset: int
    head: ChunkHead
    cut: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Delivery:
    """Messages of one block: ``messages`` (n,) MESSAGE_DTYPE point into ``data``."""

    number: int
    data: bytes
    messages: NDArray[Any]

    def payload(self, message: Any) -> bytes:
        """Payload of one of the messages."""
        start = int(message["offset"])
        return self.data[start : start + int(message["length"])]


@dataclass(slots=True)
class Contents:
    """Findings of a pass over a file of some ``kind``.

    ``channels``, ``schemas`` : by id, as the data section defines them. ``ambiguous`` : ids of
    channels defined twice with different content. ``skipped`` : messages lost with damaged
    chunks, by channel id and code. ``compressions`` : chunks by compression. ``facts`` : the
    file's line in the ledger.
    """

    facts: InputFile
    kind: str = "MCAP log"
    summary: Summary | None = None
    profile: str = ""
    library: str = ""
    channels: dict[int, records.Channel] = field(default_factory=dict)
    schemas: dict[int, records.Schema] = field(default_factory=dict)
    ambiguous: set[int] = field(default_factory=set)
    skipped: dict[int, Counter[str]] = field(default_factory=dict)
    blocks: list[Block] = field(default_factory=list)
    compressions: Counter[str] = field(default_factory=Counter)
    attachments: list[AttachmentFacts] = field(default_factory=list)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)

    def channel(self, channel_id: int) -> records.Channel | None:
        """A channel by id, from the data section or else from a trusted summary."""
        found = self.channels.get(channel_id)
        if found is None and self.summary is not None and self.summary.trusted:
            return next((c for c in self.summary.channels if c.id == channel_id), None)
        return found

    def schema(self, schema_id: int) -> records.Schema | None:
        """A schema by id, from the data section or else from a trusted summary."""
        found = self.schemas.get(schema_id)
        if found is None and self.summary is not None and self.summary.trusted:
            return next((s for s in self.summary.schemas if s.id == schema_id), None)
        return found

    def skip(self, channel_id: int, code: str, count: int) -> None:
        """Count messages of a channel as lost."""
        self.skipped.setdefault(channel_id, Counter())[code] += count

    def define(self, record: records.Schema | records.Channel) -> None:
        """Take a schema or channel; a second one of the same id must be equal (E118)."""
        if isinstance(record, records.Channel):
            if self.channels.setdefault(record.id, record) != record:
                self.ambiguous.add(record.id)
        elif self.schemas.setdefault(record.id, record) != record:
            users = (c.id for c in self.channels.values() if c.schema_id == record.id)
            self.ambiguous.update(users)


class Container(Protocol):
    """An open file of messages: MCAP, ROS 1 bag or ROS 2 db3."""

    @property
    def path(self) -> Path:
        """Where the file is."""
        ...

    @property
    def contents(self) -> Contents:
        """What ``scan`` found."""
        ...

    def scan(self, ledger: Ledger, *, digest: bool = True) -> Iterator[Delivery]:
        """Every block with its messages, in file order; to be read to its end, once.

        Damage is put down in the ledger, never raised.
        """
        ...

    def load(self, number: int) -> bytes:
        """Bytes of a block that ``scan`` delivered, once more."""
        ...

    def attachment(self, name: str, ledger: Ledger) -> bytes | None:
        """Bytes of the attachment of this name, None where there is none that is whole."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...
