"""A recording of one or more containers turned into items, in order of log time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import FpnavError, LogError, LossError
from fpnav.logs import roles
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Container
from fpnav.logs.convert import Converter
from fpnav.logs.index import index_log
from fpnav.logs.ledger import Ledger
from fpnav.logs.payloads import Loader
from fpnav.logs.sources.base import WORLD, Item, SourceOptions
from fpnav.logs.topics import Recent, Topic
from fpnav.logs.transforms import transform_tree
from fpnav.values import PRIMARY_ROLES


def read_recording(
    paths: Sequence[Path],
    open_file: Callable[[Path], Container],
    options: SourceOptions,
    ledger: Ledger,
) -> Iterator[Item]:
    """Items of all topics that play a role, over all files of a recording.

    Parameters
    ----------
    open_file : opens one of the paths

    Raises
    ------
    LogError
        A file cannot be opened, or no topic plays a role (E206).
    """
    with ExitStack() as stack:
        files: list[Container] = []
        found: list[Mapping[str, Topic]] = []
        for path in paths:
            file = open_file(path)
            stack.callback(file.close)
            files.append(file)
            found.append(index_log(file, ledger))
        yield from Recording(files, found, options, ledger).items()
        worlds = (file.attachment(WORLD, ledger) for file in files)
        yield from (Item("world", 0, world) for world in worlds if world is not None)


class Recording:
    """Files of one recording with their topics and roles."""

    def __init__(
        self,
        files: list[Container],
        found: list[Mapping[str, Topic]],
        options: SourceOptions,
        ledger: Ledger,
    ) -> None:
        self.files = files
        self.found = found
        self.ledger = ledger
        self.options = options
        merged = roles.merge(found)
        self.chosen = roles.assign(merged, options.topics, role=options.role)
        for topics in found:
            roles.count_topics(topics, self.chosen, ledger)
            roles.note_unusable(topics, ledger)

    def items(self) -> Iterator[Item]:
        """Items in order of log time; what cannot be decoded is counted and left out."""
        places = roles.places(self.chosen)
        if not any(role in self.chosen for role in PRIMARY_ROLES):
            raise self._nothing_to_see()
        converter = Converter(places, transform_tree(self.found), self._infos(), self.options)
        loaders = [Loader(file) for file in self.files]
        names = list(places)
        recent = {name: Recent() for name in names}
        for key in self._order(names):
            number, name = int(key["file"]), names[int(key["topic"])]
            topic = self.found[number][name]
            row = topic.rows[int(key["row"])]
            count = self.ledger.topic(name)
            try:
                data = loaders[number].payload(row)
                if recent[name].repeats(int(row["stamp_ns"]), data):
                    count.drop("duplicate")
                    continue
                message = loaders[number].message(row, topic.codecs)
                stamp_ns, log_ns = int(row["stamp_ns"]), int(row["log_ns"])
                yield from converter.items(name, topic.type_name, message, stamp_ns, log_ns)
            except Damaged as damage:
                count.drop(damage.code)
                self.ledger.note(damage.code, f"{name}: {damage.reason}")
        for frame in sorted(converter.unplaced):
            self.ledger.note("E503", f"frame {frame!r} has no transform to the robot's base")

    def _nothing_to_see(self) -> FpnavError:
        """Why there is nothing a frame could stand on: damage, names, or other types."""
        name = self.files[0].path.name
        damaged = [file for file in self.ledger.inputs if file.integrity == "damaged"]
        if damaged:
            codes = ", ".join(c for c in self.ledger.notes if c.startswith(("E1", "E2")))
            reason = damaged[0].damage or f"{codes} damaged chunks"
            return LossError(f"{damaged[0].name}: {reason}; nothing is left to stand frames on")
        merged = roles.merge(self.found)
        could = [f"--topic {r}={t}" for r in roles.SENSORS for t in roles.by_type(merged, r)]
        held = sorted({topic.type_name for topic in merged.values()} - {""})
        what = (
            "no topic of a type that plays a role"
            if not self.chosen
            else ("no topic a frame can stand on (images, scans or sonar)")
        )
        hint = f"; if it is what you want, name it: {could[0]}" if could else ""
        return LogError(f"{name}: E206 {what}; the log holds "
                        f"{', '.join(held) or 'no messages'}{hint}")  # fmt: skip

    def _order(self, names: list[str]) -> NDArray[Any]:
        """Every message of the chosen topics by (log time, file, place in the file)."""
        parts = []
        for number, topics in enumerate(self.found):
            for place, name in enumerate(names):
                rows = topics[name].rows if name in topics else None
                if rows is not None and len(rows):
                    parts.append(_keys(rows, number, place))
        keys = np.concatenate(parts) if parts else np.empty(0, _KEY)
        return keys[np.lexsort((keys["offset"], keys["block"], keys["file"], keys["log_ns"]))]

    def _infos(self) -> dict[str, Any]:
        """First CameraInfo of each camera role."""
        infos: dict[str, Any] = {}
        for role in roles.IMAGE_ROLES:
            for topics in self.found:
                for name in self.chosen.get(role, ()):
                    if (info := roles.camera_info(topics, name)) is not None:
                        infos.setdefault(role, info)
        return infos


_KEY = np.dtype(
    [
        ("log_ns", "<i8"),
        ("file", "<i4"),
        ("block", "<i4"),
        ("offset", "<u4"),
        ("topic", "<i4"),
        ("row", "<i8"),
    ]
)


def _keys(rows: NDArray[Any], number: int, place: int) -> NDArray[Any]:
    keys = np.empty(len(rows), _KEY)
    for name in ("log_ns", "block", "offset"):
        keys[name] = rows[name]
    keys["file"], keys["topic"], keys["row"] = number, place, np.arange(len(rows))
    return keys
