"""Any recording as open logs, for commands that only look at it.

MCAP logs, bags and db3 files are read where they are, a folder of them file by file. Other formats
are ingested into a temporary log first; what the reading lost of the source stays known.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fpnav.logs.frames import Log, open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.sources.registry import find_source

_LOOK = Budget(max_loss=1.0, allow_truncated=True)
_AS_IT_IS = {"mcap": ".mcap", "bag": ".bag", "db3": ".db3"}
"""Formats that are read in place, and the suffix of their files in a folder."""


@dataclass(frozen=True, slots=True)
class View:
    """One file of a recording: ``path`` to open, ``format`` and ``ledger`` of what it stands for.

    ``format`` is empty and ``ledger`` None where the file itself is opened.
    """

    path: Path
    name: str
    format: str = ""
    ledger: Ledger | None = None

    def open(self, topics: Mapping[str, str]) -> Log:
        """The log, whatever was lost of it."""
        log = open_log(self.path, topics, max_loss=1.0, allow_truncated=True)
        if self.ledger is not None:
            source = self.ledger.inputs[0]
            log.name, log.size, log.sha256 = self.name, source.size, source.sha256
            log.integrity = source.integrity
            log.file.contents.facts = source
            log.ledger.inputs[:] = self.ledger.inputs
            log.ledger.topics.update(self.ledger.topics)
            for code, count in self.ledger.notes.items():
                log.ledger.note(code, self.ledger.remarks.get(code, ""), count)
        return log


@contextmanager
def views(path: Path) -> Iterator[list[View]]:
    """Files of a recording, ready to be opened while the context lasts.

    Raises
    ------
    LogError
        The format is not known, or the recording cannot be read at all.
    """
    if path.is_file():
        with open(path, "rb") as handle:
            plain = handle.read(1) == b""
        if plain or path.suffix in _AS_IT_IS.values():
            yield [View(path, path.name)]
            return
    name, _ = find_source([path], None)
    if name in _AS_IT_IS:
        suffix = _AS_IT_IS[name]
        yield [View(file, file.name) for file in _files(path, suffix)]
        return
    with tempfile.TemporaryDirectory(prefix="fpnav-") as folder:
        target = Path(folder) / "log.mcap"
        done = ingest([path], target, budget=_LOOK, compression="none")
        yield [View(target, path.name, f"{name} recording", done.ledger)]


def _files(path: Path, suffix: str) -> list[Path]:
    from fpnav.logs.sources.base import files_in

    return files_in(path, suffix) or [path]
