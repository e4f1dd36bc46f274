"""Ground truth from files: poses in TUM form, accepted pairs in JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import TruthError
from fpnav.geometry import interpolate_poses
from fpnav.store.tables import Ragged
from fpnav.values import FloatArray

_COLUMNS = 8
_LARGEST_BYTES = 2**30
_NS = 10**9


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Timed planar poses.

    ``stamps_ns`` (N,) strictly increasing; ``poses`` (N, 3) x_m, y_m, heading_rad. ``notes``
    counts what was repaired or dropped: ``unsorted``, ``duplicate``, ``not_finite``.
    """

    stamps_ns: NDArray[np.int64]
    poses: FloatArray
    notes: Mapping[str, int] = field(default_factory=dict)


def read_tum(path: Path) -> Track:
    """Poses of a TUM file: ``t tx ty tz qx qy qz qw`` a line, any white space, ``#`` comments.

    Height, roll and pitch are dropped. Rows are sorted by time; of rows with one stamp the first
    stays; rows with NaN or a zero quaternion are dropped. All three are counted in the notes.

    Raises
    ------
    TruthError
        Names the file and the line: not numbers, not 8 columns, decimal commas, no row at all.
    """
    rows = [_tum_row(path, number, line) for number, line in _lines(path)]
    finite = [row for row in rows if all(map(math.isfinite, row[1]))]
    if not finite:
        raise TruthError(f"{path}: holds no pose; expected lines 't tx ty tz qx qy qz qw'")
    stamps = np.array([stamp for stamp, _ in finite], dtype=np.int64)
    poses = np.array([pose for _, pose in finite], dtype=np.float64)
    unsorted = int((np.diff(stamps) < 0).sum())
    stamps, first = np.unique(stamps, return_index=True)
    notes = {
        "unsorted": unsorted,
        "duplicate": len(finite) - len(stamps),
        "not_finite": len(rows) - len(finite),
    }
    return Track(stamps, poses[first], {name: count for name, count in notes.items() if count})


def read_pairs(path: Path) -> dict[int, tuple[int, ...]]:
    """Accepted reference indices per query index: ``{"0": [3, 4], ...}``.

    Indices count the primary role's messages from 0, before thinning.

    Raises
    ------
    TruthError
        Says what was found in place of an index, and where.
    """
    try:
        data = json.loads(_text(path), object_pairs_hook=_no_duplicates)
    except RecursionError:
        raise TruthError(f'{path}: nested too deeply; expected {{"0": [3, 4], ...}}') from None
    except ValueError as error:
        raise TruthError(f"{path}: not JSON: {error}") from None
    if not isinstance(data, dict) or not data:
        raise TruthError(f'{path}: expected an object {{"0": [3, 4], ...}} with at least one query')
    return {_index(path, "query", key): _accepted(path, key, data[key]) for key in data}


def poses_at(path: Path, track: Track, stamps_ns: NDArray[np.int64]) -> FloatArray:
    """Truth at the stamps of a run, (Q, 3); NaN where the track does not reach.

    Nothing is shifted: clocks that differ are the user's to align.

    Raises
    ------
    TruthError
        No stamp lies within the track; both ranges and the offset of their starts are given.
    """
    poses = interpolate_poses(track.stamps_ns, track.poses, stamps_ns)
    if len(stamps_ns) and np.isnan(poses).all():
        offset = (int(track.stamps_ns[0]) - int(stamps_ns.min())) / _NS
        raise TruthError(
            f"{path}: covers {_span(track.stamps_ns)}, the run {_span(stamps_ns)}: no overlap; "
            f"the starts differ by {offset:.3f} s; shift the file's stamps if its clock differs"
        )
    return poses


def pairs_to_rows(
    path: Path,
    pairs: Mapping[int, tuple[int, ...]],
    query_index: NDArray[np.int64],
    reference_index: NDArray[np.int64],
) -> Ragged:
    """Accepted reference rows per query row, from indices counted before thinning.

    A query the truth does not name has no match; a reference that was thinned away is left out.

    Parameters
    ----------
    query_index : (Q,) primary message index of each query row
    reference_index : (R,) the same of each reference row

    Raises
    ------
    TruthError
        The truth names none of the queries.
    """
    row_of = {int(index): row for row, index in enumerate(reference_index)}
    if not any(int(index) in pairs for index in query_index):
        raise TruthError(
            f"{path}: names queries {min(pairs)} .. {max(pairs)}, none of which is in this run"
        )
    rows = [
        sorted(
            {row_of[reference] for reference in pairs.get(int(index), ()) if reference in row_of}
        )
        for index in query_index
    ]
    return Ragged.of([np.array(row, dtype=np.int64) for row in rows], np.dtype(np.int64))


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise TruthError(f"{path}: larger than 1 GiB; this is no ground truth file")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TruthError(f"{path}: not text: byte {error.start} is not UTF-8") from None
    except OSError as error:
        raise TruthError(f"{path}: cannot be read: {error.strerror}") from error


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Line numbers from 1 and the lines that hold something."""
    for number, line in enumerate(_text(path).splitlines(), start=1):
        stripped = line.strip().strip("\0")
        if stripped and not stripped.startswith("#"):
            yield number, stripped


def _tum_row(path: Path, number: int, line: str) -> tuple[int, tuple[float, float, float]]:
    """Stamp and planar pose of one line; NaN where it cannot be used."""
    cells = line.split()
    if "," in line:
        raise TruthError(
            f"{path}: line {number}: commas found; expected blanks between and points in numbers"
        )
    if len(cells) != _COLUMNS:
        raise TruthError(
            f"{path}: line {number}: {len(cells)} columns, expected 8: t tx ty tz qx qy qz qw"
        )
    try:
        stamp = Decimal(cells[0])
        x, y, _, qx, qy, qz, qw = (float(cell) for cell in cells[1:])
    except (ValueError, InvalidOperation):
        raise TruthError(f"{path}: line {number}: not eight numbers: {line[:60]!r}") from None
    if not stamp.is_finite() or abs(stamp) > 9 * _NS:
        raise TruthError(f"{path}: line {number}: stamp {cells[0]!r} is not a time in seconds")
    if math.hypot(qx, qy, qz, qw) < 1e-6:
        return round(stamp * _NS), (math.nan, math.nan, math.nan)
    heading = math.atan2(2 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz)
    return round(stamp * _NS), (x, y, heading)


def _no_duplicates(items: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(items)
    if len(found) != len(items):
        raise ValueError("one query is named twice")
    return found


def _accepted(path: Path, query: str, value: Any) -> tuple[int, ...]:
    if not isinstance(value, list):
        raise TruthError(
            f"{path}: query {query!r}: expected a list of indices, found {value!r:.40}"
        )
    return tuple(_index(path, f"query {query!r}: reference", item) for item in value)


def _index(path: Path, what: str, value: Any) -> int:
    if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 19:
        return int(value)
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**62:
        return value
    raise TruthError(f"{path}: {what} {value!r:.40} is not an index counted from 0")


def _span(stamps_ns: NDArray[np.int64]) -> str:
    return f"{int(stamps_ns.min()) / _NS:.3f} .. {int(stamps_ns.max()) / _NS:.3f} s"
