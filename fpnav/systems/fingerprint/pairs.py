"""Which fingerprints of one run show the same place, and which surely do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray, Reference

NEAR_M = (0.3, 0.6, 1.0)
NEAR_FRAMES = (2, 4, 7)
FAR_M = 10.0
FAR_FRAMES = 60
APART_M = 5.0
PAIRS = 400
STRIDES = (7919, 7933, 7949)

Pairs = NDArray[np.int64]


def near_pairs(references: Sequence[Reference]) -> Pairs:
    """Fingerprints a little travel apart, within one session, (M, 2), at most PAIRS a distance.

    By travelled path where it is known, else by frames.
    """
    travelled, session = _columns(references)
    by_path = bool(np.isfinite(travelled).all())
    found = []
    for metres, frames in zip(NEAR_M, NEAR_FRAMES, strict=True):
        first = _spread(len(references), PAIRS)
        second = (
            _later(travelled, session, first, metres)
            if by_path
            else np.minimum(first + frames, len(references) - 1)
        )
        keep = (session[first] == session[second]) & (second > first)
        found.append(np.column_stack([first, second])[keep])
    return np.concatenate([np.zeros((0, 2), np.int64), *found])


def far_pairs(references: Sequence[Reference]) -> Pairs:
    """Fingerprints of different places, (M, 2): far apart in travel and, where odometry is known
    within a session, in position."""
    count = len(references)
    travelled, session = _columns(references)
    rows = _spread(count, PAIRS)
    first = np.tile(rows, len(STRIDES))
    second = np.concatenate([(rows * stride + count // 2) % max(count, 1) for stride in STRIDES])
    if np.isfinite(travelled).all():
        far = np.abs(travelled[first] - travelled[second]) >= FAR_M
    else:
        far = np.abs(first - second) >= FAR_FRAMES
    same = session[first] == session[second]
    where = _positions(references)
    apart = np.hypot(*(where[first] - where[second]).T)
    keep = far & same & ~(apart < APART_M)
    return np.asarray(np.column_stack([first, second])[keep])


def _columns(references: Sequence[Reference]) -> tuple[FloatArray, NDArray[np.int64]]:
    travelled = np.array([one.travelled_m for one in references], dtype=np.float64)
    return travelled, np.array([one.session for one in references], dtype=np.int64)


def _positions(references: Sequence[Reference]) -> FloatArray:
    rows = [
        (np.nan, np.nan) if one.odometry is None else (one.odometry.x_m, one.odometry.y_m)
        for one in references
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 2)


def _spread(count: int, most: int) -> NDArray[np.int64]:
    """At most so many rows, evenly over the run."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).astype(np.int64))


def _later(
    travelled: FloatArray, session: NDArray[np.int64], first: NDArray[np.int64], metres: float
) -> NDArray[np.int64]:
    """First row at least so far on in the session of each, itself where there is none."""
    along = travelled + session * (np.nanmax(travelled, initial=0.0) + 1e3)
    order = np.argsort(along, kind="stable")
    at = np.searchsorted(along[order], along[first] + metres)
    row = order[np.minimum(at, len(order) - 1)]
    good = (at < len(order)) & (along[row] <= along[first] + 1.5 * metres + 0.2)
    return np.where(good, row, first)
