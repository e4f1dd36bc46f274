"""The walk from logs to signatures, spread as asked; signature files are taken as they are."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fpnav.errors import LogError, UsageError
from fpnav.execution.checkpoint import Checkpoint, Checkpoints, Work
from fpnav.execution.spread import Spread
from fpnav.logs.frames import Log, open_log
from fpnav.params import NO_TABLES, Tables, as_dict, choose_preset, resolve
from fpnav.store.header import (
    SIGNATURES,
    Header,
    check_header,
    check_same_signatures,
    make_header,
    source_of,
)
from fpnav.store.results import read_header
from fpnav.store.signatures import collect, read_signatures
from fpnav.store.tables import Ragged, SignatureTable
from fpnav.systems.base import Features, System
from fpnav.systems.registry import SYSTEMS, system_class
from fpnav.values import Frame, Reference, Signature

CHUNK = 16
"""Frames handed to a worker at a time: at some milliseconds each, 50 ms of work or more."""

_HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"


@dataclass(frozen=True, slots=True)
class LogOptions:
    """How logs are read. Steps None = what the system's preset asks for.

    ``start_s``, ``end_s`` : the part of each log that is used, seconds after its first frame.
    """

    topics: dict[str, str] = field(default_factory=dict)
    step_m: float | None = None
    step_deg: float | None = None
    max_loss: float = 0.01
    allow_truncated: bool = False
    start_s: float = 0.0
    end_s: float = math.inf

    def within(self, log: Log, frames: Iterator[Frame]) -> Iterator[Frame]:
        """The frames of the part that is used."""
        if self.start_s <= 0 and math.isinf(self.end_s):
            return frames
        first_ns = log.references()[0].stamp_ns
        return (
            frame
            for frame in frames
            if self.start_s <= (frame.reference.stamp_ns - first_ns) * 1e-9 <= self.end_s
        )


@dataclass(frozen=True, slots=True)
class SystemChoice:
    """The system asked for on the command line; None = what the input says, else the default.

    ``flags`` : parameter blocks named by flags. A file may serve several systems; a flag for
    another system than the one at work is a mistake.
    """

    name: str | None = None
    preset: str | None = None
    tables: Tables = field(default_factory=lambda: NO_TABLES)
    flags: frozenset[str] = frozenset()

    def check_flags(self, name: str) -> None:
        """Refuse flags for the parameters of a system that is not at work (UsageError)."""
        for block in sorted(self.flags & SYSTEMS.keys()):
            if block not in name.split("+"):
                raise UsageError(f"--set {block}.KEY is for {block}; the system at work is {name}")


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Signatures of one or more sessions with the header their file has or would have."""

    header: Header
    table: SignatureTable
    system: System


def make_system(choice: SystemChoice) -> tuple[System, str]:
    """System with its preset and overrides, and the preset's name.

    Raises
    ------
    UsageError
        No system was named, or it has no such preset or parameter.
    """
    if choice.name is None:
        raise UsageError("no system given; choose one with -s (see fpnav systems)")
    choice.check_flags(choice.name)
    kind = system_class(choice.name)
    preset = choice.preset or "default"
    block = resolve(kind.NAME, choose_preset(kind.NAME, kind.PRESETS, preset), choice.tables)
    return kind(block), preset


def system_of(header: Header, choice: SystemChoice) -> tuple[System, str]:
    """System as a file's header has it, with the overrides that were asked for on top.

    Raises
    ------
    UsageError
        Another system was asked for than the file was made with.
    """
    name = header["system"]
    if choice.name not in (None, name):
        raise UsageError(f"-s {choice.name}: the file was made with {name}")
    choice.check_flags(name)
    kind = system_class(name)
    if choice.preset not in (None, header["preset"]):
        return make_system(SystemChoice(name, choice.preset, choice.tables))
    stored = resolve(name, next(iter(kind.PRESETS.values())), {name: header["params"]})
    return kind(resolve(name, stored, choice.tables)), header["preset"]


def is_store(path: Path) -> bool:
    """Whether a file is one of ours rather than a log."""
    try:
        with path.open("rb") as handle:
            return handle.read(len(_HDF5_MAGIC)) == _HDF5_MAGIC
    except FileNotFoundError:
        raise LogError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise LogError(f"{path}: is a folder, expected a log or signature file") from None


def signatures_of(
    paths: Sequence[Path],
    choice: SystemChoice,
    options: LogOptions,
    spread: Spread,
    advance: Callable[[int], None],
    checkpoints: Checkpoints,
) -> Run:
    """Signatures of logs (extracted on the way) or of signature files (read).

    Raises
    ------
    UsageError
        Logs and signature files are mixed.
    StoreError, LogError, LossError
        As the files deserve.
    """
    stored = [is_store(path) for path in paths]
    if all(stored):
        return _read_runs(paths, choice)
    if any(stored):
        raise UsageError("logs and signature files are mixed; give one kind")
    system, preset = make_system(choice)
    return extract(paths, system, preset, options, spread, advance, checkpoints)


def extract(
    paths: Sequence[Path],
    system: System,
    preset: str,
    options: LogOptions,
    spread: Spread,
    advance: Callable[[int], None],
    checkpoints: Checkpoints,
) -> Run:
    """Signatures of logs, each log a session; heavy work spread, order kept."""
    step_m, step_rad = _thinning(system, options)
    settings = [step_m, step_rad, options.topics, options.start_s, str(options.end_s)]
    kept = [checkpoints.session(path, system, settings) for path in paths]
    with contextlib.ExitStack() as stack:
        logs = [
            stack.enter_context(
                open_log(
                    path,
                    options.topics,
                    session=session,
                    max_loss=options.max_loss,
                    allow_truncated=options.allow_truncated,
                    frames_on=system.NEEDS.frames_on,
                )
            )
            for session, path in enumerate(paths)
        ]
        for log in logs:
            _require_roles(system, log)
        signatures = (
            _signatures(
                options.within(log, log.frames(step_m, step_rad)),
                system,
                spread,
                advance,
                checkpoint,
            )
            for log, checkpoint in zip(logs, kept, strict=True)
        )
        table = collect(itertools.chain.from_iterable(signatures), system.RECORD, system.PARTS)
        facts = _log_facts(logs)
    if len(table) == 0:
        raise LogError(f"{paths[0].name}: no signature came out of its frames")
    header = make_header(
        SIGNATURES,
        system=system.NAME,
        preset=preset,
        params=as_dict(system.params),
        step_m=step_m,
        step_heading_rad=step_rad,
        part_s=[options.start_s, None if math.isinf(options.end_s) else options.end_s],
        **facts,
    )
    return Run(header, table, system)


def _log_facts(logs: Sequence[Log]) -> dict[str, Any]:
    """What the header says of the logs; a log that carries its world comes from a simulator."""
    worlds = [log.world for log in logs]
    return {
        "sources": [
            {"name": log.name, "sha256": log.sha256, "bytes": log.size, "integrity": log.integrity}
            for log in logs
        ],
        "ledger": [log.ledger.as_dict() for log in logs],
        "roles": [list(log.roles) for log in logs],
        "travelled_from": sorted({log.travelled_from or "nothing" for log in logs}),
        "synthetic": any(world is not None for world in worlds),
        "worlds": worlds,
    }


def _thinning(system: System, options: LogOptions) -> tuple[float, float]:
    wanted = system.thinning
    step_m = wanted.step_m if options.step_m is None else options.step_m
    if options.step_deg is not None:
        return step_m, float(np.deg2rad(options.step_deg))
    return step_m, wanted.step_heading_rad if options.step_m is None else 0.0


def _require_roles(system: System, log: Log) -> None:
    missing = system.NEEDS.missing(log.roles)
    if missing:
        needs = " and ".join(" or ".join(group) for group in missing)
        has = ", ".join(log.roles) or "none"
        raise LogError(
            f"{log.name}: {system.NAME} needs {needs}; the log's roles are {has} "
            "(fpnav info lists topics, --topic role=/name names one)"
        )


def _signatures(
    frames: Iterator[Frame],
    system: System,
    spread: Spread,
    advance: Callable[[int], None],
    checkpoint: Checkpoint,
) -> Iterator[Signature]:
    return system.assemble(_described(frames, system, spread, advance, checkpoint))


def _described(
    frames: Iterator[Frame],
    system: System,
    spread: Spread,
    advance: Callable[[int], None],
    checkpoint: Checkpoint,
) -> Iterator[tuple[Reference, Features]]:
    chunks = enumerate(_chunked(frames, CHUNK))
    work = (checkpoint.find(number, chunk) for number, chunk in chunks)
    for number, described in enumerate(spread.ordered(Describe(system), work)):
        checkpoint.keep(number, described)
        advance(len(described))
        yield from described


def _chunked(frames: Iterator[Frame], size: int) -> Iterator[tuple[Frame, ...]]:
    while chunk := tuple(itertools.islice(frames, size)):
        yield chunk


@dataclass(frozen=True, slots=True)
class Describe:
    """Picklable: features of a chunk of frames, computed unless they are known already."""

    system: System

    def __call__(self, work: Work) -> list[tuple[Reference, Features]]:
        """Features of each frame with its reference."""
        references = (frame.reference for frame in work.frames)
        done = work.done or tuple(self.system.describe(frame) for frame in work.frames)
        return list(zip(references, done, strict=True))


def _read_runs(paths: Sequence[Path], choice: SystemChoice) -> Run:
    headers = [read_header(path) for path in paths]
    for path, header in zip(paths, headers, strict=True):
        check_header(path, header, SIGNATURES)
    system, preset = system_of(headers[0], choice)
    ours = {"system": system.NAME, "params": as_dict(system.params)}
    for path, header in zip(paths, headers, strict=True):
        check_same_signatures(ours, header, ("what was asked for", path.name), system.LATE)
    tables = [read_signatures(path, system.RECORD, system.PARTS) for path in paths]
    if len(paths) == 1:
        header = {**headers[0], "preset": preset, "params": ours["params"]}
        return Run(header, tables[0], system)
    return Run(_joined_header(paths, headers, system, preset), _join(tables, system), system)


def _joined_header(
    paths: Sequence[Path], headers: Sequence[Header], system: System, preset: str
) -> Header:
    return make_header(
        SIGNATURES,
        system=system.NAME,
        preset=preset,
        params=as_dict(system.params),
        sources=[source_of(path) for path in paths],
        chain=headers,
        **{key: [v for h in headers for v in h[key]] for key in ("ledger", "roles", "worlds")},
        step_m=headers[0]["step_m"],
        step_heading_rad=headers[0]["step_heading_rad"],
        part_s=headers[0]["part_s"],
        travelled_from=sorted({v for h in headers for v in h["travelled_from"]}),
        synthetic=any(h["synthetic"] for h in headers),
    )


def _join(tables: Sequence[SignatureTable], system: System) -> SignatureTable:
    """Tables one after the other, their sessions renumbered."""
    references = []
    first = 0
    for table in tables:
        rows = table.references.copy()
        rows["session"] += first
        first = int(rows["session"].max(initial=first - 1)) + 1
        references.append(rows)
    parts = {
        name: Ragged.of(
            [table.parts[name][row] for table in tables for row in range(len(table))], dtype
        )
        for name, dtype in system.PARTS.items()
    }
    records = np.concatenate([table.records for table in tables])
    return SignatureTable(np.concatenate(references), records, parts)
