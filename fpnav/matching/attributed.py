"""Alignment of strings whose symbols carry bearing and range, over a grid of turns.

With the turn known, a pair of symbols of one kind is worth ``1 - (angle off / width)^2 -
(log range off / width)^2`` of their weight, never less than leaving both out; symbols the other
sensor could not have seen under that turn count for nothing. The best turn is the string's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.values import FloatArray

SYMBOL = np.dtype([("angle_rad", "<f8"), ("log_range", "<f8"), ("weight", "<f8"), ("kind", "<i8")])
"""A symbol: bearing in [-pi, pi), natural logarithm of its range in metres."""

BAND = 1.5
"""Angles off by more than this many widths are never paired."""

_entry = numba.njit(cache=True, nogil=True, error_model="numpy")
_inner = numba.njit(nogil=True, error_model="numpy")


@dataclass(frozen=True, slots=True, eq=False)
class Strings:
    """A batch: ``symbols`` (S,) SYMBOL, by angle within each string, ``offsets`` (B + 1,), ``arcs``
    (B, 2) centre and width of what each sensor covered."""

    symbols: NDArray[np.void]
    offsets: NDArray[np.int64]
    arcs: FloatArray

    @staticmethod
    def of(rows: Sequence[NDArray[np.void]], arcs: Sequence[FloatArray]) -> Strings:
        """Batch of single strings."""
        lengths = [len(row) for row in rows]
        flat = np.concatenate([np.zeros(0, SYMBOL), *rows]).astype(SYMBOL, copy=False)
        offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        return Strings(flat, offsets, np.array(arcs, dtype=np.float64).reshape(len(rows), 2))


@dataclass(frozen=True, slots=True)
class Tolerance:
    """``angle_rad`` and ``log_range`` per kind of symbol: what is off by so much is worth nought;
    ``gap`` share of its weight that a symbol left out costs."""

    angle_rad: float
    log_range: tuple[float, ...]
    gap: float


def ratios(
    query: Strings,
    others: Strings,
    rows: NDArray[np.int64],
    turns_rad: FloatArray,
    tolerance: Tolerance,
) -> tuple[FloatArray, FloatArray]:
    """Normalised score of the first query string with each named one under the best turn.

    Turns lie in [-pi, pi).

    Returns
    -------
    scores : (n,) in [-gap, 1], 0 where nothing could be compared
    turns_rad : (n,) turn from the other to the query: query heading minus other heading
    """
    scores, turns = np.zeros(len(rows)), np.zeros(len(rows))
    _ratios(
        _columns(query.symbols[: query.offsets[1]]), query.arcs[0],
        _columns(others.symbols), others.offsets, others.arcs, rows, turns_rad,
        tolerance.angle_rad, np.array(tolerance.log_range), tolerance.gap, scores, turns,
    )  # fmt: skip
    return scores, turns


def _columns(symbols: NDArray[np.void]) -> FloatArray:
    """Symbols as floats, (S, 4): bearing, log range, weight, kind."""
    names = SYMBOL.names or ()
    return np.column_stack([symbols[name].astype(np.float64) for name in names])


@_inner
def seen(angle, centre, half):  # type: ignore[no-untyped-def]
    """Whether a bearing lies on an arc; both in [-pi, pi)."""
    off = abs(angle - centre)
    return min(off, TAU - off) <= half + 1e-9


@_inner
def wrapped(angle):  # type: ignore[no-untyped-def]
    """Angle in [-pi, pi), at most one turn away from it."""
    if angle >= np.pi:
        return angle - TAU
    return angle + TAU if angle < -np.pi else angle


@_inner
def arranged(x, turn, out):  # type: ignore[no-untyped-def]
    """Symbols turned, by bearing from -pi on."""
    first = 0
    for i in range(len(x)):
        if wrapped(x[i, 0] + turn) < wrapped(x[first, 0] + turn):
            first = i
    for k in range(len(x)):
        i = (first + k) % len(x)
        out[k, 0] = wrapped(x[i, 0] + turn)
        out[k, 1], out[k, 2], out[k, 3] = x[i, 1], x[i, 2], x[i, 3]


@_inner
def visible(x, centre, half, out):  # type: ignore[no-untyped-def]
    """Symbols on an arc, in their order; how many."""
    n = 0
    for i in range(len(x)):
        if seen(x[i, 0], centre, half):
            for c in range(4):
                out[n, c] = x[i, c]
            n += 1
    return n


@_inner
def aligned(x, n, y, m, width, ranges, gap, row):  # type: ignore[no-untyped-def]
    """Best score of x[:n] with y[:m] over its largest possible value.

    A row of the recurrence is kept without the cost of the symbols of x so far, so that only
    cells near the band of angles, or changed by one to their left, need a visit.
    """
    total, cost = 0.0, 0.0
    row[0] = 0.0
    for j in range(m):
        total += y[j, 2]
        row[j + 1] = row[j] - gap * y[j, 2]
    low = 0
    for i in range(n):
        total += x[i, 2]
        own = gap * x[i, 2]
        while low < m and y[low, 0] < x[i, 0] - BAND * width:
            low += 1
        before, changed = row[low], False
        for j in range(low, m):
            near = y[j, 0] <= x[i, 0] + BAND * width
            if not near and not changed:
                break
            old = row[j + 1]
            best = max(old, row[j] - gap * y[j, 2])
            if near and x[i, 3] == y[j, 3]:
                a = (x[i, 0] - y[j, 0]) / width
                r = (x[i, 1] - y[j, 1]) / ranges[int(x[i, 3])]
                worth = 0.5 * (x[i, 2] + y[j, 2]) * (1.0 - a * a - r * r)
                best = max(best, before + own + worth)
            changed = best > old
            before = old
            row[j + 1] = best
        cost += own
    return (row[m] - cost) / (0.5 * total) if total > 0.0 else 0.0


@_entry
def _ratios(  # type: ignore[no-untyped-def]
    x, arc, symbols, offsets, arcs, rows, turns, width, ranges, gap, scores, found
):
    ways = np.empty((len(turns), len(x), 4))
    for t in range(len(turns)):
        arranged(x, turns[t], ways[t])
    longest = len(x)
    for row in rows:
        longest = max(longest, offsets[row + 1] - offsets[row])
    mine, theirs = np.empty((longest, 4)), np.empty((longest, 4))
    buffer = np.empty(longest + 1)
    for k in range(len(rows)):
        y = symbols[offsets[rows[k]] : offsets[rows[k] + 1]]
        centre, half = wrapped(arcs[rows[k], 0]), 0.5 * arcs[rows[k], 1]
        best = -np.inf
        for t in range(len(turns)):
            n = visible(ways[t], centre, half, mine)
            m = visible(y, wrapped(wrapped(arc[0]) + wrapped(turns[t])), 0.5 * arc[1], theirs)
            value = aligned(mine, n, theirs, m, width, ranges, gap, buffer)
            if value > best:
                best, found[k] = value, turns[t]
        scores[k] = best
