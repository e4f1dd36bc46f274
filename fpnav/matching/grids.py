"""Grids over bearing compared under every turn, in whole numbers: exact, whatever the order.

``cover`` (bins,) says where the sensor looked; only bins that both cover are compared.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

LARGEST = 127

_entry = numba.njit(cache=True, nogil=True, error_model="numpy")


def quantised(grid: FloatArray) -> NDArray[np.int32]:
    """Non-negative values as whole numbers, the largest LARGEST."""
    most = float(np.max(grid, initial=0.0))
    return np.rint(np.asarray(grid) * (LARGEST / most if most > 0.0 else 0.0)).astype(np.int32)


def cosines(
    query: NDArray[np.int32],
    query_cover: NDArray[np.bool_],
    others: NDArray[np.int32],
    covers: NDArray[np.bool_],
    rows: NDArray[np.int64],
    shifts: NDArray[np.int64],
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Best cosine of a grid (bins, k) with each named one of (R, bins, k) over cyclic shifts.

    Returns
    -------
    scores : (n,) in [0, 1]
    shifts : (n,) bin b of the query lay on bin b + shift of the other; the first of equals
    """
    scores, found = np.zeros(len(rows)), np.zeros(len(rows), np.int64)
    _cosines(query, query_cover, others, covers, rows, shifts, scores, found)
    return scores, found


@_entry
def _cosines(query, cover, others, covers, rows, shifts, scores, found):  # type: ignore[no-untyped-def]
    bins, depth = query.shape
    mine, theirs = np.zeros(bins, np.int64), np.zeros(bins, np.int64)
    lanes = np.zeros(depth, np.int32)
    for b in range(bins):
        for c in range(depth):
            mine[b] += query[b, c] * query[b, c]
    for k in range(len(rows)):
        other, seen = others[rows[k]], covers[rows[k]]
        for b in range(bins):
            theirs[b] = 0
            for c in range(depth):
                theirs[b] += other[b, c] * other[b, c]
        best = -1.0
        for shift in shifts:
            first, second = 0, 0
            lanes[:] = 0
            for b in range(bins):
                j = (b + shift) % bins
                if not (cover[b] and seen[j]):
                    continue
                first += mine[b]
                second += theirs[j]
                for c in range(depth):
                    lanes[c] += query[b, c] * other[j, c]
            product = 0
            for c in range(depth):
                product += lanes[c]
            value = 0.0
            if product > 0:
                value = product / np.sqrt(float(first) * float(second))
            if value > best:
                best, found[k] = value, shift
        scores[k] = best
