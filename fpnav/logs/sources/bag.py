"""ROS 1 bags (version 2.0), indexed or not; several files are merged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fpnav.logs.bag import MAGIC, BagFile
from fpnav.logs.ledger import Ledger
from fpnav.logs.recording import read_recording
from fpnav.logs.sources.base import Item, SourceOptions, files_in

SUMMARY = "ROS 1 bag, or a folder of its files"
SUFFIX = ".bag"


def recognises(path: Path, head: bytes) -> bool:
    """The first line of a bag, whatever its version; the suffix too, for damaged ones."""
    return head.startswith(MAGIC[:8]) or path.suffix == SUFFIX or bool(files_in(path, SUFFIX))


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Items of all topics that play a role, in order of log time over all files."""
    files = [file for path in paths for file in files_in(path, SUFFIX) or [path]]
    yield from read_recording(files, BagFile, options, ledger)
