"""CARMEN logs, plain or gzip: FLASER, ROBOTLASER1, ODOM, TRUEPOS, PARAM.

A log that a mapper corrected carries its poses in every line, ODOM included: they are truth, and
using them as odometry would leak it. ``poses=auto`` takes a log for corrected where the mapper
left NEFF lines or the name says ``corrected``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fpnav.errors import LogError, LossError
from fpnav.geometry import relative
from fpnav.logs.carmen_lines import FARTHEST_M, WORDS, Line, parse
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.sources.base import Item, Motion, SourceOptions
from fpnav.logs.text import lines, text_facts
from fpnav.values import Pose2

SUMMARY = "CARMEN log, plain or .gz"

_SIGNS = (*WORDS, "PARAM", "SYNC", "RLASER", "RAWLASER1", "NEFF")
_SILENT = ("#", "PARAM", "SYNC", "NEFF")
"""Lines that hold no message."""

_SICK_FULL_M = (8.192, 16.384, 32.768)
_STEP_NS = 100_000_000


@dataclass(frozen=True, slots=True)
class Survey:
    """What must be known of a whole log before its first line can be used.

    ``no_return_m`` : readings from here on hit nothing. ``mount`` : of the laser on the robot.
    ``ordered`` : stamps are useless (many are equal) and are made from the order.
    ``odometry`` : ODOM lines carry the odometry, scans need not.
    """

    corrected: bool
    no_return_m: float
    mount: Pose2
    ordered: bool
    scans: int
    odometry: bool


def recognises(path: Path, head: bytes) -> bool:
    """A text whose first lines begin with CARMEN's words."""
    words = [line.split(b" ", 1)[0] for line in head.splitlines() if not line.startswith(b"#")]
    return bool(words) and words[0].decode("latin1") in _SIGNS


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Scans and poses of one log after another."""
    for path in paths:
        facts = text_facts(path)
        ledger.inputs.append(facts)
        survey = _survey(path, facts)
        if survey.scans == 0 and facts.damage:
            raise LossError(f"{path}: {facts.damage}; no scan is left")
        if survey.scans == 0:
            raise LogError(f"{path}: E206 no FLASER or ROBOTLASER1 line; nothing to recognise by")
        as_truth = options.poses == "truth" or (options.poses == "auto" and survey.corrected)
        ledger.note("poses", "scan poses are " + ("truth" if as_truth else "odometry"))
        yield from _items(path, survey, as_truth, ledger)


def _items(path: Path, survey: Survey, as_truth: bool, ledger: Ledger) -> Iterator[Item]:
    if survey.ordered:
        ledger.note("B6", f"{path.name}: stamps repeat; made from the order, 0.1 s apart")
    scans = 0
    for number, text in lines(path, ledger.inputs[-1]):
        if not text.startswith(WORDS):
            if not text.startswith(_SILENT) and text:
                ledger.note("lines", f"line {number}: {text.split(' ', 1)[0]} is not read")
            continue
        word = text.split(" ", 1)[0]
        count = ledger.topic(word)
        if word == "ODOM" and as_truth:
            count.skipped["unused"] += 1
            continue
        try:
            line = parse(text, survey.no_return_m)
        except (ValueError, IndexError) as error:
            count.skipped["E305"] += 1
            ledger.note("E305", f"{path.name} line {number}: {error}")
            continue
        stamp_ns = scans * _STEP_NS if survey.ordered else line.stamp_ns
        scans += line.scan is not None
        count.used += 1
        yield from _of_line(line, stamp_ns, survey, as_truth)


def _of_line(line: Line, stamp_ns: int, survey: Survey, as_truth: bool) -> Iterator[Item]:
    """Items of one line."""
    if line.scan is not None:
        if as_truth:
            yield Item("truth", stamp_ns, line.robot)
        elif not survey.odometry:
            yield Item("odometry", stamp_ns, Motion(line.robot))
        yield Item("scan", stamp_ns, replace(line.scan, mount=survey.mount))
    elif line.word == "TRUEPOS":
        yield Item("truth", stamp_ns, line.robot)
    else:
        yield Item("odometry", stamp_ns, Motion(line.robot, *line.speeds))


def _survey(path: Path, facts: InputFile) -> Survey:
    """First pass: is the log corrected, what is no return, where is the laser, are stamps real."""
    corrected = "corrected" in path.name
    farthest, mount, odometry = 0.0, None, False
    stamps: list[int] = []
    for _, text in lines(path, facts):
        corrected = corrected or text.startswith("NEFF")
        odometry = odometry or text.startswith("ODOM ")
        if not text.startswith(("FLASER", "ROBOTLASER1")):
            continue
        try:
            line = parse(text, math.inf)
        except (ValueError, IndexError):
            continue
        if line.scan is not None and text.startswith("FLASER"):
            farthest = max(farthest, float(np.nanmax(line.scan.ranges_m)))
        mount = mount or relative(line.robot, line.laser)
        stamps.append(line.stamp_ns)
    steps = np.diff(np.array(stamps, dtype=np.int64))
    ordered = len(steps) > 0 and np.count_nonzero(steps <= 0) > len(steps) // 10
    mount = mount or Pose2(0.0, 0.0, 0.0)
    return Survey(
        corrected, _no_return(farthest), _rounded(mount), bool(ordered), len(stamps), odometry
    )


def _no_return(farthest_m: float) -> float:
    """Reading from which on a SICK scanner reports a code instead of a range.

    The eight highest values of the scale are codes: 81.83 .. 81.91 m in centimetres, 8.183 ..
    8.191 m and so on in millimetres.
    """
    for full in _SICK_FULL_M:
        if full - 0.0095 <= farthest_m < full:
            return full - 0.0095
    return FARTHEST_M


def _rounded(mount: Pose2) -> Pose2:
    """Mount without the last digits that differ from line to line."""
    return Pose2(round(mount.x_m, 3), round(mount.y_m, 3), round(mount.heading_rad, 4))
