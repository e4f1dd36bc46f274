"""Every format fpnav ingests: one module, one line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fpnav.errors import LogError, UsageError
from fpnav.logs.sniff import looks_like
from fpnav.logs.sources import bag, carmen, db3, g2o, images, mcap, sonar_csv
from fpnav.logs.sources.base import Source
from fpnav.logs.text import head_of

SOURCES: dict[str, Source] = {
    "mcap": mcap,
    "bag": bag,
    "db3": db3,
    "carmen": carmen,
    "g2o": g2o,
    "images": images,
    "sonar_csv": sonar_csv,
}


def find_source(paths: Sequence[Path], wanted: str | None) -> tuple[str, Source]:
    """Name and module of the format of a recording: as wanted, or the one all files look like.

    Raises
    ------
    UsageError
        No such format, or the files are of several.
    LogError
        No format is recognised.
    """
    if wanted is not None:
        if wanted not in SOURCES:
            raise UsageError(f"--format {wanted}: no such format; there are {', '.join(SOURCES)}")
        return wanted, SOURCES[wanted]
    names = [_recognise(path) for path in paths]
    if len(set(names)) > 1:
        raise UsageError(
            f"{paths[0].name} is {names[0]}, another is {sorted(set(names) - {names[0]})[0]}; "
            "ingest one recording at a time"
        )
    return names[0], SOURCES[names[0]]


def _recognise(path: Path) -> str:
    if str(path) == "-":
        raise UsageError("a recording cannot be read from a pipe; give a file")
    if not path.exists():
        raise LogError(f"{path}: no such file")
    head = head_of(path)
    for name, source in SOURCES.items():
        if source.recognises(path, head):
            return name
    known = f"known formats are {', '.join(SOURCES)} (--format overrides the guess)"
    if path.is_dir():
        raise LogError(
            f"{path}: E100 a folder without images.csv, .mcap, .bag or .db3 files; {known}"
        )
    if not head:
        raise LogError(f"{path}: E101 empty file; {known}")
    raise LogError(f"{path}: E100 looks like {looks_like(head)}; {known}")
