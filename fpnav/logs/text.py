"""Lines of text logs, plain, gzip or the one member of a zip, within bounds."""

from __future__ import annotations

import gzip
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, cast

from fpnav.errors import LogError
from fpnav.logs import limits
from fpnav.logs.ledger import InputFile
from fpnav.publish import file_digest

GZIP = b"\x1f\x8b"
ZIP = b"PK\x03\x04"
_BROKEN = (
    EOFError,
    zlib.error,
    gzip.BadGzipFile,
    zipfile.BadZipFile,
    NotImplementedError,  # a zip's compression that Python does not know
    RuntimeError,  # a zip with a password
)


def lines(path: Path, facts: InputFile | None = None) -> Iterator[tuple[int, str]]:
    """(number from 1, line) of a UTF-8 text file without line ends; bad bytes become U+FFFD.

    A gzip stream that is cut off ends the text; the damage is put down in ``facts``.

    Raises
    ------
    LogError
        The file cannot be read, a line or the text is over the limit, or the gzip stream is
        damaged and there are no ``facts`` to say so.
    """
    total = 0
    try:
        with open_packed(path) as handle:
            for number, line in enumerate(iter(lambda: handle.readline(limits.LINE_BYTES), b""), 1):
                total += len(line)
                if len(line) == limits.LINE_BYTES or total > limits.TEXT_BYTES:
                    raise LogError(f"{path}: line {number} is over the limit of a text log")
                yield number, line.decode("utf-8-sig", "replace").rstrip("\r\n")
    except _BROKEN as error:
        reason = f"E102 packed text is cut off or damaged: {error}"
        if facts is None:
            raise LogError(f"{path}: {reason}") from None
        facts.damage, facts.integrity = reason, "damaged"
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error


def open_packed(path: Path) -> BinaryIO:
    """Binary stream of a file, unpacked on the way where it is gzip or a zip of one file."""
    with open(path, "rb") as handle:
        head = handle.read(4)
    if head.startswith(GZIP):
        return cast(BinaryIO, gzip.open(path, "rb"))
    return _open_zip(path) if head == ZIP else open(path, "rb")


def _open_zip(path: Path) -> BinaryIO:
    """The one member of a zip; it is read in place, its name is not used."""
    archive = zipfile.ZipFile(path)
    names = [info.filename for info in archive.infolist() if not info.is_dir()]
    members = [n for n in names if not n.startswith("__MACOSX/") and n.isprintable()]
    if len(members) != 1:
        archive.close()
        raise LogError(f"{path}: E100 a zip of {len(members)} files, expected one; unpack it first")
    return cast(BinaryIO, archive.open(members[0]))


def head_of(path: Path, size: int = 4096) -> bytes:
    """First bytes of a file, unpacked where it is packed; empty for a folder."""
    if path.is_dir():
        return b""
    try:
        with open_packed(path) as handle:
            return handle.read(size)
    except _BROKEN as error:
        return _whole_head(path, size, error)
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror or error}") from error


def _whole_head(path: Path, size: int, damage: Exception) -> bytes:
    """First bytes of a gzip file that is damaged within them, as far as they can be unpacked."""
    with open(path, "rb") as handle:
        stored = handle.read(size)
    try:
        found = zlib.decompressobj(wbits=31).decompress(stored, size)
    except zlib.error:
        found = b""
    if not found:
        raise LogError(f"{path}: E102 packed file is cut off or damaged: {damage}")
    return found


def text_facts(path: Path) -> InputFile:
    """Ledger line of a text log: gzip and zip carry a CRC, plain text does not."""
    try:
        size, digest = path.stat().st_size, file_digest(path)
        with open(path, "rb") as handle:
            packed = handle.read(4).startswith((GZIP, ZIP))
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror or error}") from error
    return InputFile(path.name, size, digest, "verified" if packed else "unverified")
