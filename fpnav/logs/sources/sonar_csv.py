"""Sonar rings in CSV: ``stamp_s,range_BEARINGDEG,...``, one column a transducer.

The bearing stands in the column's name, in degrees, counter-clockwise positive, 0 ahead. Where
the transducers stand on the robot is not in the file: they are placed at its centre. Their
opening is taken as the spacing of the ring. The largest reading, where it occurs again and
again, is the end of the range: nothing was heard.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.logs.ledger import Ledger
from fpnav.logs.sources.base import Item, SourceOptions
from fpnav.logs.text import lines, text_facts
from fpnav.values import FloatArray, SonarRing

SUMMARY = "sonar ring CSV (stamp_s,range_BEARINGDEG,...)"

_HEADER = re.compile(rb"\s*stamp_s\s*,\s*range_-?\d")
_COLUMN = re.compile(r"range_(-?\d+(?:\.\d+)?)")
_REPEATS = 3
_NEAREST_M = 0.01


def recognises(path: Path, head: bytes) -> bool:
    """A text whose first line names ranges by bearing."""
    return _HEADER.match(head) is not None


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Readings of the ring of one file after another."""
    for path in paths:
        ledger.inputs.append(text_facts(path))
        bearings = _bearings(path)
        stamps, ranges = _readings(path, len(bearings), ledger)
        if len(stamps) == 0:
            raise LogError(f"{path}: E206 no reading")
        farthest = _farthest(ranges)
        ledger.note("saturated", f"{path.name}: readings of {farthest:g} m are nothing in range")
        ranges[ranges >= farthest] = np.inf
        mounts = np.column_stack([np.zeros((len(bearings), 2)), bearings])
        opening = 2.0 * math.pi / len(bearings)
        for stamp_ns, row in zip(stamps, ranges, strict=True):
            yield Item("sonar", stamp_ns, SonarRing(row, mounts, opening, _NEAREST_M, farthest))


def _bearings(path: Path) -> FloatArray:
    """Bearings (n,) in radians, from the header line."""
    words = [word.strip() for word in next(lines(path), (0, ""))[1].split(",")]
    found = [_COLUMN.fullmatch(word) for word in words[1:]]
    if words[0] != "stamp_s" or not found or not all(found):
        raise LogError(f"{path}: first line is {','.join(words)!r}, expected stamp_s,range_DEG,...")
    return np.radians([float(match[1]) for match in found if match])


def _readings(path: Path, count: int, ledger: Ledger) -> tuple[list[int], NDArray[np.float32]]:
    """Stamps, and ranges (rows, transducers); an empty cell is unknown."""
    stamps: list[int] = []
    rows: list[list[float]] = []
    topic = ledger.topic("/sonar")
    for number, text in lines(path, ledger.inputs[-1]):
        if number == 1 or not text.strip():
            continue
        try:
            stamp, row = _row(text.split(","), count)
        except (ValueError, OverflowError) as error:
            topic.skipped["E305"] += 1
            ledger.note("E305", f"{path.name} line {number}: {error}")
            continue
        stamps.append(stamp)
        rows.append(row)
        topic.used += 1
    return stamps, np.array(rows, dtype=np.float32).reshape(len(rows), count)


def _row(words: list[str], count: int) -> tuple[int, list[float]]:
    if len(words) != count + 1:
        raise ValueError(f"{len(words)} columns, expected {count + 1}")
    values = [float(word) if word.strip() else math.nan for word in words[1:]]
    return round(float(words[0]) * 1e9), values


def _farthest(ranges: NDArray[np.float32]) -> float:
    """The end of the range: the largest reading where it repeats, else beyond all readings."""
    finite = ranges[np.isfinite(ranges)]
    if len(finite) == 0:
        return math.inf
    largest = finite.max()
    repeats = int(np.count_nonzero(finite == largest))
    return float(largest if repeats >= _REPEATS else np.nextafter(largest, np.float32(np.inf)))
