"""ROS 2 bags in SQLite, one file or the folder of a recording; metadata.yaml is not needed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fpnav.logs.db3 import MAGIC, Db3File
from fpnav.logs.ledger import Ledger
from fpnav.logs.recording import read_recording
from fpnav.logs.sources.base import Item, SourceOptions, files_in

SUMMARY = "ROS 2 db3, or a folder of its files"
SUFFIX = ".db3"


def recognises(path: Path, head: bytes) -> bool:
    """SQLite's first bytes, or a folder with .db3 files."""
    return head.startswith(MAGIC) or path.suffix == SUFFIX or bool(files_in(path, SUFFIX))


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Items of all topics that play a role, in order of log time over all files."""
    files = [file for path in paths for file in files_in(path, SUFFIX) or [path]]
    yield from read_recording(files, Db3File, options, ledger)
