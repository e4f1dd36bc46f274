"""ROS 1 bags (version 2.0), indexed or not; several files are merged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from fpnav.logs.bag import MAGIC, BagFile
from fpnav.logs.ledger import Ledger
from fpnav.logs.recording import read_recording
from fpnav.logs.sources.base import Item, SourceOptions

SUMMARY = "ROS 1 bag"


def recognises(path: Path, head: bytes) -> bool:
    """The first line of a bag, whatever its version; the suffix too, for damaged ones."""
    return head.startswith(MAGIC[:8]) or path.suffix == ".bag"


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Items of all topics that play a role, in order of log time over all files."""
    yield from read_recording(paths, BagFile, options, ledger)
