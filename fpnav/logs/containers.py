"""Which container a file is, by its first bytes."""

from __future__ import annotations

from pathlib import Path

from fpnav.errors import LogError
from fpnav.logs import bag, db3
from fpnav.logs.contents import Container
from fpnav.logs.reader import LogFile


def open_container(path: Path) -> Container:
    """Open a ROS 1 bag or ROS 2 db3 as such, and anything else as MCAP.

    Raises
    ------
    LogError
        The file cannot be opened, or is none of these.
    """
    try:
        with open(path, "rb") as handle:
            head = handle.read(16)
    except OSError as error:
        raise LogError(f"{path}: cannot be opened: {error.strerror}") from error
    if head.startswith(bag.MAGIC[:8]):
        return bag.BagFile(path)
    return db3.Db3File(path) if head.startswith(db3.MAGIC) else LogFile(path)
