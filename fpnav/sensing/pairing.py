# mypy: disable-error-code="no-untyped-def"
"""Cheapest one-to-one pairing of two ordered lists that keeps the order; compiled."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray


def in_order(cost: FloatArray, unmatched: float) -> NDArray[np.int64]:
    """Partner of each row among the columns, -1 where it has none, (n,).

    Least sum of the costs of pairs and of ``unmatched`` for every row and column left alone;
    partners increase with the rows. Of equally cheap pairings the one with more pairs, and the
    later rows and columns paired first.

    Parameters
    ----------
    cost : (n, m), +inf where a pair is impossible
    """
    partner = np.full(len(cost), -1, np.int64)
    _in_order(np.ascontiguousarray(cost, dtype=np.float64), float(unmatched), partner)
    return partner


@numba.njit(cache=True, nogil=True)
def _in_order(cost, unmatched, partner):
    n, m = cost.shape
    best = np.zeros((n + 1, m + 1))
    best[:, 0] = np.arange(n + 1) * unmatched
    best[0, :] = np.arange(m + 1) * unmatched
    for i in range(n):
        for j in range(m):
            alone = min(best[i, j + 1], best[i + 1, j]) + unmatched
            best[i + 1, j + 1] = min(alone, best[i, j] + cost[i, j])
    i, j = n, m
    while i > 0 and j > 0:
        if best[i, j] == best[i - 1, j - 1] + cost[i - 1, j - 1]:
            i, j = i - 1, j - 1
            partner[i] = j
        elif best[i, j] == best[i - 1, j] + unmatched:
            i -= 1
        else:
            j -= 1
