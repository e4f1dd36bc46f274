"""Logs, signatures and maps that experiments need: made once, kept and found again by content.

What a log is made from (world, route, seed, run, rig) and the code that makes it decide its name;
what signatures and maps are made from (the log's bytes, the system's parameters, the code) theirs.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import msgspec

from fpnav.errors import FpnavError, LogError
from fpnav.execution.checkpoint import Checkpoints
from fpnav.execution.spread import Here, Spread
from fpnav.execution.stages import make_map
from fpnav.execution.walk import LogOptions, Run, SystemChoice, extract, make_system
from fpnav.params import NO_TABLES, Tables
from fpnav.publish import file_digest, publish_once
from fpnav.sim.catalogue import Setting, default_rig, overrides_in
from fpnav.sim.record import Job, record
from fpnav.sim.rig import make_rig
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap, read_map, write_map
from fpnav.store.results import read_header
from fpnav.store.signatures import read_signatures, write_signatures
from fpnav.systems.base import System

SIMULATOR = ("sim", "logs", "geometry.py", "values.py")
EXTRACTION = ("systems", "sensing", "logs", "geometry.py", "values.py")
BUILDING = (*EXTRACTION, "matching", "mapping", "localization", "topomap", "execution/stages.py")


def job_of(
    world: str,
    route: str,
    seed: int,
    run: int = 1,
    *,
    sensors: Sequence[str] | None = None,
    tables: Tables = NO_TABLES,
) -> Job:
    """Run of a world, with the world's own rig but for what the tables say."""
    roles, defaults = default_rig(world)
    rig = make_rig(list(sensors) if sensors else roles, defaults, tables)
    return Job(Setting(world, seed, run, overrides_in(tables)), route, rig)


@dataclass(frozen=True)
class Workshop:
    """Where logs, signatures and maps are kept, and who makes them.

    ``small`` : experiments shorten their routes, to show that everything runs, not how well.
    """

    folder: Path
    spread: Spread
    small: bool = False

    def log(self, job: Job) -> Path:
        """Log of a run, simulated unless it is there already."""
        path = self._log_path(job)
        publish_once(path, lambda: record(job, path, spread=self.spread))
        return path

    def run(self, log: Path, choice: SystemChoice) -> Run:
        """Signatures of a log, extracted unless they are there already."""
        system, preset = make_system(choice)
        params = msgspec.to_builtins(system.params)
        path = self._run_path(log, system)

        def make() -> None:
            nowhere = Checkpoints(path, resume=False)
            made = extract(
                [log], system, preset, LogOptions(), self.spread, lambda done: None, nowhere
            )
            write_signatures(path, made.header, made.table)

        publish_once(path, make)
        header = {**read_header(path), "preset": preset, "params": params}
        return Run(header, read_signatures(path, system.RECORD, system.PARTS), system)

    def map(
        self, log: Path, choice: SystemChoice, *, close_loops: bool = True
    ) -> tuple[Header, BuiltMap]:
        """Map of a log with its header, built unless it is there already."""
        run = self.run(log, choice)
        key = [file_digest(log), run.system.NAME, run.header["params"], close_loops]
        path = self._kept("maps", f"{log.stem}-map", [*key, code_digest(BUILDING)], "h5")

        def make() -> None:
            header, built = make_map(
                run, [log], guided=False, close_loops=close_loops, advance=lambda done: None
            )
            write_map(path, header, built)

        publish_once(path, make)
        header = {**read_header(path), "preset": run.header["preset"]}
        return header, read_map(path, run.system.RECORD, run.system.PARTS)

    def runs(self, jobs: Sequence[Job], choice: SystemChoice) -> list[Run]:
        """Signatures of several runs, made side by side."""
        self.make(jobs, choice)
        return [self.run(self.log(job), choice) for job in jobs]

    def make(self, jobs: Sequence[Job], choice: SystemChoice) -> None:
        """Make the logs and signatures that are missing side by side, one log a worker.

        What fails here fails again where it is asked for, and is told there.
        """
        missing = [job for job in jobs if not self._has(job, choice)]
        spread = self.spread if len(missing) > 1 else Here()
        for _ in spread.ordered(Making(Workshop(self.folder, Here()), choice), missing):
            pass

    def _has(self, job: Job, choice: SystemChoice) -> bool:
        log = self._log_path(job)
        return log.exists() and self._run_path(log, make_system(choice)[0]).exists()

    def _log_path(self, job: Job) -> Path:
        setting = job.setting
        name = f"{setting.name}-{job.route}-{setting.seed}-{setting.run}"
        key = [setting.name, setting.seed, setting.run, setting.overrides, job.route]
        rig = msgspec.to_builtins(job.rig)
        return self._kept("logs", name, [*key, rig, code_digest(SIMULATOR)], "mcap")

    def _run_path(self, log: Path, system: System) -> Path:
        params = msgspec.to_builtins(system.params)
        early = {name: params[name] for name in params if name not in system.LATE}
        key = [file_digest(log), system.NAME, early, code_digest(EXTRACTION)]
        return self._kept("signatures", f"{log.stem}-{system.NAME}", key, "h5")

    def _kept(self, kind: str, name: str, key: Sequence[Any], ending: str) -> Path:
        text = json.dumps(key, sort_keys=True).encode()
        folder = self.folder / kind
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FpnavError(f"{folder}: cannot be made a folder: {error.strerror}") from error
        return folder / f"{name}-{hashlib.sha256(text).hexdigest()[:12]}.{ending}"


@dataclass(frozen=True, slots=True)
class Making:
    """Picklable: makes log and signatures of a run for a workshop, where they are found again."""

    shop: Workshop
    choice: SystemChoice

    def __call__(self, job: Job) -> None:
        """Make what is missing, as far as it can be made."""
        with contextlib.suppress(LogError):
            self.shop.run(self.shop.log(job), self.choice)


@functools.cache
def code_digest(parts: tuple[str, ...]) -> str:
    """Digest of the source of some rooms: what they make is made anew when they change."""
    digest = hashlib.sha256()
    for part in parts:
        for name, data in _sources(files("fpnav") / part):
            digest.update(name.encode() + data)
    return digest.hexdigest()


def _sources(place: Traversable) -> list[tuple[str, bytes]]:
    """Names and bytes of all Python and TOML files at or below a place, by name."""
    if place.is_file():
        wanted = place.name.endswith((".py", ".toml"))
        return [(place.name, place.read_bytes())] if wanted else []
    below = sorted(place.iterdir(), key=lambda entry: entry.name)
    return [source for entry in below for source in _sources(entry)]
