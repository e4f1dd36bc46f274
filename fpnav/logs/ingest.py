"""Any recording -> one standard log, with a ledger of what became of every message."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fpnav import __version__
from fpnav.errors import LogError, UsageError
from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.reader import LogFile
from fpnav.logs.sources.base import SourceOptions, write_item
from fpnav.logs.sources.registry import find_source
from fpnav.logs.writer import LogWriter
from fpnav.publish import file_digest, publish

METADATA = "fpnav.ingest"


@dataclass(frozen=True, slots=True)
class Ingested:
    """What was written: messages by role, the ledger of the reading, the format it was read as."""

    format: str
    messages: dict[str, int]
    ledger: Ledger


def ingest(
    paths: Sequence[Path],
    output: Path,
    *,
    format: str | None = None,
    options: SourceOptions | None = None,
    budget: Budget | None = None,
    compression: str = "zstd",
    clobber: bool = True,
    advance: Callable[[int], None] = lambda done: None,
) -> Ingested:
    """Write the standard log of one recording.

    Parameters
    ----------
    paths : files of one recording, in any order
    format : name in sources.registry; None = guessed
    advance : called with the number of messages written

    Raises
    ------
    UsageError
        A file is given twice, or files of several formats are mixed.
    LogError
        The recording cannot be used.
    LossError
        More was lost than the budget allows; nothing is published.
    """
    name, source = find_source(paths, format)
    _refuse_duplicates(paths)
    ledger = Ledger()
    counts: Counter[str] = Counter()
    with (
        publish(output, clobber=clobber, verify=_verify) as stream,
        LogWriter(stream, compression=compression) as writer,
    ):
        for item in source.read(paths, options or SourceOptions(), ledger):
            write_item(writer, item)
            counts[item.role] += 1
            advance(1)
        ledger.settle(budget or Budget())
        writer.metadata(METADATA, _facts(name, ledger))
    return Ingested(name, dict(sorted(counts.items())), ledger)


def _refuse_duplicates(paths: Sequence[Path]) -> None:
    """The same recording given twice is a mistake of the glob, not two sessions (A28)."""
    if len(paths) < 2:
        return
    seen: dict[str, Path] = {}
    for path in paths:
        digest = str(path.resolve()) if path.is_dir() else file_digest(path)
        if digest in seen:
            raise UsageError(f"{path}: the same file as {seen[digest]}")
        seen[digest] = path


def _facts(format: str, ledger: Ledger) -> dict[str, str]:
    return {
        "version": __version__,
        "format": format,
        "ledger": json.dumps(ledger.as_dict(), sort_keys=True, allow_nan=False),
    }


def _verify(path: Path) -> None:
    """Read back what was written; every CRC must hold."""
    with LogFile(path) as file:
        for _ in file.scan(Ledger(), digest=False):
            pass
        facts = file.contents.facts
    if facts.integrity != "verified":
        raise LogError(f"{path.name}: written log does not read back: {facts.damage}")
