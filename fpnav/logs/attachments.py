"""Attachments of an MCAP file: found on the way, read when asked for, never extracted by name."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import BinaryIO

from fpnav.logs.checksums import crc32
from fpnav.logs.container import Damaged

HEAD_BYTES = 1 << 16
"""Bytes of the record within which its names must end."""


@dataclass(frozen=True, slots=True)
class AttachmentFacts:
    """An attachment, not yet read. Its name is data, never a path."""

    name: str
    media_type: str
    offset: int
    size: int
    crc: int


def attachment_facts(content: bytes, start: int, length: int) -> AttachmentFacts:
    """Names and place of an attachment from the first bytes of its record.

    Parameters
    ----------
    content : the first bytes of the record's content, at most HEAD_BYTES
    start, length : place of the content in the file

    Raises
    ------
    Damaged
        E102 lengths contradict, E113 names too long, E121 names not UTF-8.
    """
    try:
        name, at = _word(content, 16)
        media_type, at = _word(content, at)
        (size,) = struct.unpack_from("<Q", content, at)
    except struct.error:
        raise Damaged("E102", "attachment ends within its head") from None
    except UnicodeDecodeError:
        raise Damaged("E121", "attachment name is not UTF-8") from None
    if at + 8 + size + 4 > length:
        raise Damaged("E102", f"attachment of {size} bytes in a record of {length}")
    return AttachmentFacts(name, media_type, start + at + 8, size, 0)


def _word(content: bytes, at: int) -> tuple[str, int]:
    (size,) = struct.unpack_from("<I", content, at)
    word = content[at + 4 : at + 4 + size]
    if len(word) != size:
        raise Damaged("E113", "attachment name is too long")
    return word.decode(), at + 4 + size


def read_attachment(handle: BinaryIO, facts: AttachmentFacts) -> bytes:
    """Bytes of an attachment; raises Damaged (A14) where its CRC is wrong."""
    names = 8 + len(facts.name.encode()) + len(facts.media_type.encode())
    before = 16 + names + 8
    handle.seek(facts.offset - before)
    covered = handle.read(before + facts.size)
    if facts.crc and crc32(covered, 0) != facts.crc:
        raise Damaged("A14", f"CRC of attachment {facts.name!r} is wrong")
    return covered[before:]
