"""MCAP logs of any encoding that is decoded, with any topic names; several files are merged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fpnav.logs.container import MAGIC
from fpnav.logs.ledger import Ledger
from fpnav.logs.reader import LogFile
from fpnav.logs.recording import read_recording
from fpnav.logs.sources.base import Item, SourceOptions, files_in

SUMMARY = "MCAP log, or a folder of its files"
SUFFIX = ".mcap"


def recognises(path: Path, head: bytes) -> bool:
    """MCAP's magic; the suffix too, so that a damaged start is answered by the reader."""
    return head.startswith(MAGIC) or path.suffix == SUFFIX or bool(files_in(path, SUFFIX))


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Items of all topics that play a role, in order of log time over all files."""
    files = [file for path in paths for file in files_in(path, SUFFIX) or [path]]
    yield from read_recording(files, LogFile, options, ledger)
