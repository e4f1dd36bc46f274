"""MCAP files read from front to back, hardened against damage (faults.md R3-R5, A1-A33).

One pass goes over every record, with or without chunks, index or summary. A block is a chunk or,
in a file without chunks, a run of records; it can be loaded again later by number.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from fpnav.errors import LogError
from fpnav.logs import container, limits
from fpnav.logs.attachments import read_attachment
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Contents, Delivery
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.scan import Pass
from fpnav.logs.sniff import looks_like
from fpnav.logs.summary import read_summary
from fpnav.logs.tape import Tape


class LogFile:
    """One open MCAP file; ``contents`` is what ``scan`` found in it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._handle, self._identity = _open(path)
        self.contents = Contents(InputFile(path.name, self._identity.st_size))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._handle.close()

    def scan(self, ledger: Ledger, *, digest: bool = True) -> Iterator[Delivery]:
        """Every block with its messages, in file order; to be read to its end, once.

        Damage is put down in the ledger, never raised; reading stops where it makes the rest
        unreadable.

        Raises
        ------
        LogError
            The file changed while it was read (E120), or the disk fails.
        """
        facts = self.contents.facts
        ledger.inputs.append(facts)
        summary = self.contents.summary = read_summary(self._handle, facts.size)
        self._handle.seek(0)
        expected = summary.data_crc if summary else 0
        tape = Tape(self._handle, self.path.name, digest=digest, checksum=expected != 0)
        yield from Pass(tape, self.contents, ledger).run()
        self._check_unchanged()

    def load(self, number: int) -> bytes:
        """Unpacked bytes of a block that ``scan`` delivered; raises LogError E120."""
        block = self.contents.blocks[number]
        try:
            self._handle.seek(block.offset)
            stored = self._handle.read(block.head.stored)
            if block.cut:
                return container.unpack_prefix(block.head, stored)
            return container.unpack(block.head, stored)
        except Damaged as damage:
            raise LogError(
                f"{self.path.name}: E120 changed while it was read ({damage.reason})"
            ) from None
        except OSError as error:
            raise LogError(
                f"{self.path.name}: cannot be read at byte {block.offset:,}: {error.strerror}"
            ) from error

    def attachment(self, name: str, ledger: Ledger) -> bytes | None:
        """Bytes of the attachment of this name, None where there is none that is whole."""
        for facts in self.contents.attachments:
            if facts.name == name and facts.size <= limits.ATTACHMENT_BYTES:
                try:
                    return read_attachment(self._handle, facts)
                except Damaged as damage:
                    ledger.note(damage.code, damage.reason)
        return None

    def _check_unchanged(self) -> None:
        now, before = self.path.stat(), self._identity
        same = (now.st_size, now.st_mtime_ns, now.st_ino)
        if same != (before.st_size, before.st_mtime_ns, before.st_ino):
            raise LogError(f"{self.path.name}: E120 changed while it was read; try again")


def _open(path: Path) -> tuple[BinaryIO, os.stat_result]:
    """Open a file that starts as MCAP files do."""
    try:
        handle = open(path, "rb")  # noqa: SIM115 - lives as long as the LogFile
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror}") from error
    identity = os.fstat(handle.fileno())
    head = handle.read(512)
    if head.startswith(container.MAGIC):
        return handle, identity
    handle.close()
    if not head:
        raise LogError(f"{path}: E101 empty file, expected an MCAP log")
    raise LogError(
        f"{path}: E100 not an MCAP log, looks like {looks_like(head)}; fpnav ingest reads other "
        "formats"
    )
