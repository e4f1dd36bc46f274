"""One pass over an MCAP file, record by record; damage is put down, never raised."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcap import records

from fpnav.logs import container, limits
from fpnav.logs.attachments import HEAD_BYTES, attachment_facts
from fpnav.logs.container import HEAD, ChunkHead, Damaged, parse
from fpnav.logs.contents import Block, Contents, Delivery
from fpnav.logs.ledger import Integrity, Ledger
from fpnav.logs.tape import Tape

RUN_BYTES = 1 << 20
"""Loose records are delivered in runs of about this size."""

_NAMES = {
    container.SCHEMA: "Schema",
    container.CHANNEL: "Channel",
    container.MESSAGE: "Message",
    container.CHUNK: "Chunk",
    container.MESSAGE_INDEX: "MessageIndex",
    container.ATTACHMENT: "Attachment",
    container.METADATA: "Metadata",
    container.DATA_END: "DataEnd",
    container.FOOTER: "Footer",
}


class Pass:
    """What is known on the way over a file, and what to do with each kind of record.

    Messages are ``covered`` where a CRC protects them: the chunk's, or the data section's.
    """

    def __init__(self, tape: Tape, contents: Contents, ledger: Ledger) -> None:
        self.tape = tape
        self.contents = contents
        self.facts = contents.facts
        self.ledger = ledger
        self.uncovered = False
        self.data_crc_held = False
        self.lost: str = ""
        self.lost_counted = False
        self.uncounted: str = ""
        self.in_summary = False
        self.ended = False

    def run(self) -> Iterator[Delivery]:
        """Blocks with messages, in file order."""
        self.tape.skip(len(container.MAGIC))
        while not self.ended:
            head = self.tape.peek(HEAD.size)
            if len(head) < HEAD.size:
                self._stop("no footer", self.tape.left, HEAD.size)
                continue
            opcode, length = HEAD.unpack(head)
            if opcode != container.MESSAGE_INDEX:
                self._settle_lost()
            if opcode == 0:
                self._stop("opcode 0 is not valid", self.tape.left, length)
            elif length > self.tape.left - HEAD.size:
                yield from self._cut(opcode, length)
            elif self.in_summary and opcode != container.FOOTER:
                self.tape.skip(HEAD.size + length)
            elif opcode in container.LOOSE:
                yield from self._loose()
            elif opcode == container.CHUNK:
                yield from self._chunk(length)
            else:
                self._other(opcode, length)
        self._close()

    def _cut(self, opcode: int, length: int) -> Iterator[Delivery]:
        """A record longer than the file: what is whole in a cut chunk is still used."""
        left = self.tape.left - HEAD.size
        reason = f"truncated in {_NAMES.get(opcode, 'a record')}"
        if opcode == container.CHUNK and left <= limits.RECORD_BYTES:
            content = self.tape.peek(HEAD.size + left)[HEAD.size :]
            try:
                yield from self._chunk_content(content, self.tape.position + HEAD.size, cut=True)
            except Damaged as damage:
                reason += f", {damage.reason}"
        self._stop(reason, left, length)

    def _stop(self, reason: str, left: int, length: int) -> None:
        """Reading cannot go on here; a trusted index may say where it can."""
        position = self.tape.position
        if self.facts.truncated_at is None:
            self.facts.truncated_at = position
            self._damage(
                f"E102 {reason} at byte {position:,} (record says {length:,} bytes, {left:,} left)"
            )
        summary = self.contents.summary
        later = summary.chunk_offsets if summary and summary.trusted else []
        following = min((offset for offset in later if offset > position), default=None)
        if following is None or following >= self.tape.size:
            self.ended = True
        else:
            self.tape.jump(following)

    def _loose(self) -> Iterator[Delivery]:
        """A run of records that stand on their own, at least one."""
        offset = self.tape.position
        data = self.tape.peek(RUN_BYTES)
        whole = whole_loose(data)
        if whole == 0:
            opcode, length = HEAD.unpack_from(data)
            if length > limits.MESSAGE_BYTES:
                self._skip_huge(opcode, length)
                return
            whole = HEAD.size + length
        data = self.tape.read(whole)
        self.uncovered = True
        yield from self._deliver(data, Block(offset, ChunkHead(whole, 0, "", whole, 0)))

    def _skip_huge(self, opcode: int, length: int) -> None:
        """Go over a record that is over the limit; a message is counted with its channel."""
        self.ledger.note("E113", f"record of {length:,} bytes skipped")
        if opcode == container.MESSAGE:
            channel = self.tape.peek(HEAD.size + 2)[HEAD.size :]
            self.contents.skip(int.from_bytes(channel, "little"), "E113", 1)
        self.tape.skip(HEAD.size + length)

    def _chunk(self, length: int) -> Iterator[Delivery]:
        self.tape.skip(HEAD.size)
        offset = self.tape.position
        try:
            if length > limits.RECORD_BYTES:
                raise Damaged("E113", f"chunk of {length:,} bytes is over the limit")
            yield from self._chunk_content(self.tape.read(length), offset, cut=False)
        except Damaged as damage:
            self.lost, self.lost_counted = damage.code, False
            self.ledger.note(damage.code, f"{damage.reason} at byte {offset:,}")
        self.tape.skip(offset + length - self.tape.position)

    def _chunk_content(self, content: bytes, offset: int, *, cut: bool) -> Iterator[Delivery]:
        head = container.chunk_head(content)
        stored = content[head.length : head.length + head.stored]
        short = len(stored) < head.stored
        if short and not cut:
            raise Damaged("E110", f"chunk declares {head.stored} stored bytes, has {len(stored)}")
        data = container.unpack_prefix(head, stored) if short else container.unpack(head, stored)
        if short:
            head = replace(head, crc=0, stored=len(stored))
        self.contents.compressions[head.compression or "none"] += 1
        self.uncovered = self.uncovered or head.crc == 0
        yield from self._deliver(data, Block(offset + head.length, head, cut=short))

    def _deliver(self, data: bytes, block: Block) -> Iterator[Delivery]:
        found = container.split(data)
        for opcode, content in found.others:
            self._define(opcode, content)
        if found.whole < len(data) and not block.cut:
            self.facts.truncated_at = self.facts.truncated_at or block.offset
            self._damage(
                f"E102 records of the chunk at byte {block.offset:,} end at {found.whole:,} of "
                f"{len(data):,}"
            )
        self.contents.blocks.append(block)
        yield Delivery(len(self.contents.blocks) - 1, data, found.messages)

    def _define(self, opcode: int, content: bytes) -> None:
        try:
            if opcode == container.SCHEMA:
                self.contents.define(parse(records.Schema, content))
            elif opcode == container.CHANNEL:
                self.contents.define(parse(records.Channel, content))
        except Damaged as damage:
            self.ledger.note(damage.code, damage.reason)

    def _other(self, opcode: int, length: int) -> None:
        if opcode == container.MESSAGE_INDEX:
            self._message_index(length)
        elif opcode == container.DATA_END:
            self._data_end(length)
        elif opcode == container.FOOTER:
            self._footer(length)
        elif opcode == container.ATTACHMENT:
            self._attachment(length)
        elif opcode in (container.HEADER, container.METADATA) and length <= limits.SCHEMA_BYTES:
            self._words(opcode, self.tape.read(HEAD.size + length)[HEAD.size :])
        else:
            self.tape.skip(HEAD.size + length)

    def _message_index(self, length: int) -> None:
        """The index behind a damaged chunk says how much was lost with it."""
        if self.lost and length >= 6:
            channel_id = int.from_bytes(self.tape.peek(HEAD.size + 2)[HEAD.size :], "little")
            self.contents.skip(channel_id, self.lost, (length - 6) // 16)
            self.lost_counted = True
        self.tape.skip(HEAD.size + length)

    def _settle_lost(self) -> None:
        """The records of a damaged chunk end here; without an index nobody knows what it held."""
        if self.lost and not self.lost_counted:
            self.uncounted = f"{self.lost} a chunk is damaged and no index says what it held"
        self.lost = ""

    def _words(self, opcode: int, content: bytes) -> None:
        try:
            if opcode == container.HEADER:
                header = parse(records.Header, content)
                self.contents.profile, self.contents.library = header.profile, header.library
            else:
                metadata = parse(records.Metadata, content)
                self.contents.metadata[metadata.name] = metadata.metadata
        except Damaged as damage:
            self.ledger.note(damage.code, damage.reason)

    def _attachment(self, length: int) -> None:
        start = self.tape.position + HEAD.size
        content = self.tape.peek(min(HEAD.size + length, HEAD_BYTES))[HEAD.size :]
        try:
            facts = attachment_facts(content, start, length)
        except Damaged as damage:
            self.ledger.note(damage.code, damage.reason)
        else:
            self.tape.skip(facts.offset + facts.size - self.tape.position)
            crc = int.from_bytes(self.tape.read(4), "little")
            self.contents.attachments.append(replace(facts, crc=crc))
        self.tape.skip(start + length - self.tape.position)

    def _data_end(self, length: int) -> None:
        actual = self.tape.checksum
        content = self.tape.read(HEAD.size + length)[HEAD.size :]
        expected = int.from_bytes(content[:4], "little")
        self.tape.checksum = None
        self.in_summary = True
        if not expected or actual is None:
            return
        self.data_crc_held = actual == expected
        if not self.data_crc_held:
            self.ledger.note("E112", "CRC of the data section is wrong")
            if self.uncovered:
                self._damage("E112 CRC of the data section is wrong")

    def _footer(self, length: int) -> None:
        self.tape.skip(HEAD.size + length)
        if self.tape.read(len(container.MAGIC)) != container.MAGIC:
            self._stop("no magic after the footer", self.tape.left, len(container.MAGIC))
        elif self.tape.left:
            self.ledger.note("A20", f"{self.tape.left:,} bytes after the end")
        self.ended = True

    def _damage(self, reason: str) -> None:
        """Put down a loss that cannot be counted; the first is the one to tell."""
        self.facts.damage = self.facts.damage or reason

    def _close(self) -> None:
        self._settle_lost()
        summary = self.contents.summary
        counted = summary is not None and summary.trusted and summary.statistics is not None
        if self.uncounted and not counted:
            self._damage(self.uncounted)
        if summary is None or not summary.channels:
            self.ledger.note("A5", "no summary")
        if summary is not None and summary.damaged:
            self.ledger.note("E111", "summary is damaged and was not used")
        self.facts.sha256 = self.tape.finish()
        self.facts.integrity = self._integrity()

    def _integrity(self) -> Integrity:
        if self.facts.damage or self.uncounted or self.contents.skipped:
            return "damaged"
        if self.uncovered and not self.data_crc_held:
            self.ledger.note("A11", "unverified (no CRC in file)")
            return "unverified"
        return "verified"


def whole_loose(data: bytes) -> int:
    """Bytes that whole loose records take at the front of ``data``."""
    at, size = 0, len(data)
    while size - at >= HEAD.size:
        opcode, length = HEAD.unpack_from(data, at)
        if opcode not in container.LOOSE or length > size - at - HEAD.size:
            break
        at += HEAD.size + length
    return at
