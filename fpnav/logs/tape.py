"""A file read once from front to back, digested on the way. No mmap: a file that shrinks while it
is read ends early instead of killing the process (faults.md A30)."""

from __future__ import annotations

import hashlib
import os
from typing import BinaryIO

from fpnav.errors import LogError
from fpnav.logs.checksums import crc32

_BLOCK = 1 << 20


class Tape:
    """Sequential bytes of an open file up to the size it has now.

    With ``digest`` every byte is read and goes into the sha256; without it skipped bytes are
    sought over. ``checksum`` is the CRC32 of all bytes consumed so far, None once bytes were
    sought over.
    """

    def __init__(self, handle: BinaryIO, name: str, *, digest: bool, checksum: bool) -> None:
        self._handle = handle
        self._name = name
        self._buffer = b""
        self._at = 0
        self.position = 0
        self.size = os.fstat(handle.fileno()).st_size
        self._hash = hashlib.sha256() if digest else None
        self.checksum: int | None = 0 if checksum else None

    @property
    def left(self) -> int:
        """Bytes from here to the end."""
        return self.size - self.position

    def peek(self, length: int) -> bytes:
        """The next bytes without consuming them, fewer at the end of the file."""
        self._fill(length)
        return self._buffer[self._at : self._at + length]

    def read(self, length: int) -> bytes:
        """The next bytes, fewer at the end of the file."""
        length = min(length, self.left)
        buffered = self._buffer[self._at : self._at + length]
        missing = length - len(buffered)
        if missing < _BLOCK:
            data = self.peek(length)
            self._at += len(data)
        else:
            rest = self._read_raw(missing)
            data = buffered + rest if buffered else rest
            self._buffer, self._at = b"", 0
        self._account(data, length)
        return data

    def skip(self, length: int) -> None:
        """Go over bytes; sought where no digest needs them."""
        length = min(length, self.left)
        buffered = min(length, len(self._buffer) - self._at)
        self.read(buffered)
        length -= buffered
        if self._hash is None and self.checksum is None:
            self._seek(self.position + length)
            return
        while length > 0 and (data := self.read(min(length, _BLOCK))):
            length -= len(data)

    def jump(self, position: int) -> None:
        """Go on at a later byte; what lies between is digested but not checksummed."""
        self.checksum = None
        self.skip(position - self.position)

    def again(self, position: int, length: int) -> bytes:
        """Bytes that were consumed before, read once more."""
        here = self._handle.tell()
        self._handle.seek(position)
        data = self._handle.read(length)
        self._handle.seek(here)
        return data

    def finish(self) -> str:
        """sha256 of the whole file as hex, the rest read for it; empty without ``digest``."""
        if self._hash is None:
            return ""
        self.checksum = None
        self.skip(self.left)
        return self._hash.hexdigest()

    def _account(self, data: bytes, length: int) -> None:
        self.position += len(data)
        if len(data) < length:
            self.size = self.position
        if self.checksum is not None:
            self.checksum = crc32(data, self.checksum)

    def _fill(self, length: int) -> None:
        have = len(self._buffer) - self._at
        want = min(length, self.left) - have
        if want <= 0:
            return
        data = self._read_raw(min(max(want, _BLOCK), self.left - have))
        self._buffer = self._buffer[self._at :] + data
        self._at = 0

    def _seek(self, position: int) -> None:
        self._handle.seek(position)
        self._buffer, self._at, self.position = b"", 0, position

    def _read_raw(self, length: int) -> bytes:
        try:
            data = self._handle.read(length)
        except OSError as error:
            raise LogError(
                f"{self._name}: cannot be read at byte {self._handle.tell()}: {error.strerror}"
            ) from error
        if self._hash is not None:
            self._hash.update(data)
        return data
