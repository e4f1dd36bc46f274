"""``--resume``: features already computed by a run that was killed are used again.

Beside the target stands ``.TARGET.fpresume/KEY/N.npz``, one file per chunk of frames, where KEY is
the digest of everything the features depend on. It is removed once the target is published.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnav import __version__
from fpnav.params import as_dict
from fpnav.publish import file_digest, publish_bytes
from fpnav.systems.base import Features, System
from fpnav.values import Frame, Reference

Described = Sequence[tuple[Reference, Features]]


@dataclass(frozen=True, slots=True)
class Work:
    """A chunk of frames to describe; ``done`` holds its features where they are known already."""

    frames: tuple[Frame, ...]
    done: tuple[Features, ...] | None = None


class Checkpoint(Protocol):
    """Where the features of one session's chunks are kept between runs."""

    def find(self, number: int, frames: tuple[Frame, ...]) -> Work:
        """The chunk as work, done or to do."""
        ...

    def keep(self, number: int, described: Described) -> None:
        """Remember the features of a chunk."""
        ...


class NoCheckpoint:
    """Nothing is kept."""

    def find(self, number: int, frames: tuple[Frame, ...]) -> Work:
        """All work is still to do."""
        return Work(frames)

    def keep(self, number: int, described: Described) -> None:
        """Forget."""


class FolderCheckpoint:
    """Chunks kept as .npz files in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def find(self, number: int, frames: tuple[Frame, ...]) -> Work:
        """The chunk with its features, where a sound file of the right length holds them."""
        try:
            with np.load(self._file(number), allow_pickle=False) as stored:
                done = _unpack(stored)
        except (OSError, ValueError, EOFError, zipfile.BadZipFile):
            return Work(frames)
        return Work(frames, done) if len(done) == len(frames) else Work(frames)

    def keep(self, number: int, described: Described) -> None:
        """Publish the chunk's features."""
        if self._file(number).exists():
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **_pack(described))
        publish_bytes(self._file(number), buffer.getvalue())

    def _file(self, number: int) -> Path:
        return self.folder / f"{number}.npz"


class Checkpoints:
    """The checkpoints of one target; without ``resume`` every one of them keeps nothing."""

    def __init__(self, target: Path, *, resume: bool) -> None:
        self._folder = target.with_name(f".{target.name}.fpresume")
        self._resume = resume

    def session(self, log: Path, system: System, settings: Any) -> Checkpoint:
        """Checkpoint of one log; ``settings`` is all else the features depend on, as JSON."""
        if not self._resume:
            return NoCheckpoint()
        facts = [__version__, file_digest(log), system.NAME, as_dict(system.params), settings]
        key = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]
        return FolderCheckpoint(self._folder / key)

    def clear(self) -> None:
        """The target is published: nothing needs to be kept."""
        shutil.rmtree(self._folder, ignore_errors=True)


def _pack(described: Described) -> dict[str, NDArray[Any]]:
    arrays = {"frames": np.array(len(described))}
    for number, (_, features) in enumerate(described):
        arrays.update({f"{number}/{name}": values for name, values in features.items()})
    return arrays


def _unpack(stored: Any) -> tuple[Features, ...]:
    rows: list[dict[str, NDArray[Any]]] = [{} for _ in range(int(stored["frames"]))]
    for key in stored.files:
        number, slash, name = key.partition("/")
        if slash:
            rows[int(number)][name] = stored[key]
    return tuple(rows)
