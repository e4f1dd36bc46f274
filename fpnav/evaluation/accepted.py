"""Which answers to a query are right: rows near enough in truth, places that own them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import angular_distance
from fpnav.store.tables import Ragged
from fpnav.values import FloatArray

_CELLS = 4_000_000
_ROWS = np.dtype(np.int64)
_NONE = np.zeros(0, np.int64)

Bools = NDArray[np.bool_]


def rows_by_pose(
    queries: FloatArray,
    references: FloatArray,
    candidates: NDArray[np.int64],
    radius_m: float,
    heading_rad: float | None,
) -> Ragged:
    """Reference rows that count as the same place as each query.

    Parameters
    ----------
    queries, references : (Q, 3) and (R, 3) x_m, y_m, heading_rad; NaN rows match nothing
    candidates : (Q,) query i may match rows 0 .. candidates[i] - 1 only
    heading_rad : largest difference of headings, None = any

    Returns
    -------
    Ragged of Q rows of int64, increasing.
    """
    rows: list[NDArray[np.int64]] = []
    columns = np.arange(len(references))
    for first, block in _blocks(queries, len(references)):
        same = _distances(block, references) <= radius_m
        if heading_rad is not None:
            same &= angular_distance(block[:, 2:3], references[None, :, 2]) <= heading_rad
        same &= columns < candidates[first : first + len(block), None]
        rows += [np.flatnonzero(row) for row in same]
    return Ragged.of(rows, _ROWS)


def nearest_match_m(
    queries: FloatArray,
    references: FloatArray,
    candidates: NDArray[np.int64],
    heading_rad: float | None,
) -> FloatArray:
    """Distance from each query to the nearest reference it may match, (Q,); inf where none is.

    Parameters as in ``rows_by_pose``: the rows within a radius are some exactly where this is at
    most that radius.
    """
    nearest = np.full(len(queries), np.inf)
    columns = np.arange(len(references))
    for first, block in _blocks(queries, len(references)):
        rows = slice(first, first + len(block))
        away = _distances(block, references)
        out = np.isnan(away) | (columns >= candidates[rows, None])
        if heading_rad is not None:
            out |= ~(angular_distance(block[:, 2:3], references[None, :, 2]) <= heading_rad)
        away[out] = np.inf
        nearest[rows] = away.min(axis=1, initial=np.inf)
    return nearest


def nearest_rows(
    queries: FloatArray,
    references: FloatArray,
    labels: tuple[NDArray[np.bytes_], NDArray[np.bytes_]],
    within_m: float,
) -> NDArray[np.int64]:
    """Reference row nearest to each query, (Q,); -1 where none lies within ``within_m``.

    ``labels`` are those of queries and references: where both have a name it must be the same.
    """
    found = np.full(len(queries), -1, dtype=np.int64)
    if not len(references):
        return found
    for first, block in _blocks(queries, len(references)):
        here = labels[0][first : first + len(block), None]
        elsewhere = (here != labels[1]) & (here != b"") & (labels[1] != b"")
        away = _distances(block, references)
        away[elsewhere | np.isnan(away)] = np.inf
        best = np.argmin(away, axis=1)
        near = away[np.arange(len(block)), best] <= within_m
        found[first : first + len(block)] = np.where(near, best, -1)
    return found


def owners(rows: Ragged, owner: NDArray[np.int64], candidates: NDArray[np.int64]) -> Ragged:
    """Places that own the accepted rows of each query, its candidates only."""
    pairs = zip(ragged_rows(rows), candidates, strict=True)
    return Ragged.of([np.unique(owner[row[row < last]]) for row, last in pairs], _ROWS)


def border_places(
    queries: FloatArray,
    foot: NDArray[np.int64],
    poses: FloatArray,
    owner: NDArray[np.int64],
    neighbours: dict[int, set[int]],
    within_m: float,
) -> Ragged:
    """Graph neighbours of the true place whose border each query is at.

    A place reaches as far as its mapping poses (R, 3) are the nearest, and so does its border: the
    query (Q, 3), whose own nearest pose is row ``foot`` (Q,), is at the border where it would be
    in the neighbour after at most ``within_m`` straight towards one of that one's poses.
    """
    found = [_NONE] * len(foot)
    for query in np.flatnonzero(foot >= 0).tolist():
        beside = neighbours.get(int(owner[foot[query]]), set())
        away = poses[:, :2] - queries[query, :2]
        far = np.hypot(away[:, 0], away[:, 1])
        rows = np.flatnonzero(far <= far[foot[query]] + 2.0 * within_m)
        rivals = [row for row in rows.tolist() if int(owner[row]) in beside]
        if rivals:
            near = _entered_after(away[rivals], away[rows]) <= within_m
            found[query] = np.unique(owner[rivals][near])
    return Ragged.of(found, _ROWS)


def _entered_after(targets: FloatArray, around: FloatArray) -> FloatArray:
    """Way (T,) from the origin straight towards each target (T, 2) until it is the nearest.

    ``around`` (N, 2): all that could be nearer on the way. Points p = t * target are as near to
    the target as to c where t * 2 (target - c) . target = |target|^2 - |c|^2.
    """
    far = np.hypot(targets[:, 0], targets[:, 1])
    lead = far[:, None] ** 2 - (around**2).sum(axis=1)
    turn = 2.0 * (far[:, None] ** 2 - targets @ around.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = np.where(turn > 0.0, lead / turn, np.where(lead > 0.0, np.inf, 0.0))
    return np.asarray(far * np.clip(crossed, 0.0, None).max(axis=1))


def contains(accepted: Ragged, places: NDArray[np.int64]) -> Bools:
    """Whether each of k answers of each query is accepted, (Q, k); -1 never is.

    Rows of ``accepted`` are increasing, so that (query, place) keys are sorted as they stand.
    """
    if not len(accepted.flat):
        return np.zeros(places.shape, bool)
    span = int(max(places.max(initial=0), accepted.flat.max())) + 1
    query = np.repeat(np.arange(len(accepted)), np.diff(accepted.offsets))
    known = query * span + accepted.flat
    keys = np.arange(len(places))[:, None] * span + places
    at = np.minimum(np.searchsorted(known, keys), len(known) - 1)
    return np.asarray((known[at] == keys) & (places >= 0))


def ragged_rows(ragged: Ragged) -> Iterator[NDArray[np.int64]]:
    """The rows, in order."""
    return (ragged[row] for row in range(len(ragged)))


def singles(places: NDArray[np.int64]) -> Ragged:
    """One accepted place a query, none where it is -1."""
    known = places >= 0
    return Ragged(places[known], np.concatenate([[0], np.cumsum(known)]).astype(np.int64))


def _blocks(queries: FloatArray, references: int) -> Iterator[tuple[int, FloatArray]]:
    """Slices of the queries whose tables against all references stay small."""
    rows = max(1, _CELLS // max(1, references))
    for first in range(0, len(queries), rows):
        yield first, queries[first : first + rows]


def _distances(queries: FloatArray, references: FloatArray) -> FloatArray:
    away = queries[:, None, :2] - references[None, :, :2]
    return np.hypot(away[..., 0], away[..., 1])
