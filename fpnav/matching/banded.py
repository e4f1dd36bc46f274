"""Alignment of rows of strips of equal angle: under all turns of a circle, else within a band."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fpnav.values import FloatArray

SingleArray = NDArray[np.float32]


def strip_distances(query: SingleArray, members: SingleArray) -> SingleArray:
    """Euclidean distance of every strip of a query and every strip of every member.

    Parameters
    ----------
    query : (S, D)
    members : (M, S, D)

    Returns
    -------
    (M, S, S), axes member, query strip, member strip
    """
    count, strips, _ = members.shape
    flat = members.reshape(count * strips, -1)
    squares = np.einsum("ij,ij->i", flat, flat)[None, :]
    squares = squares + np.einsum("ij,ij->i", query, query)[:, None] - 2.0 * (query @ flat.T)
    distances = np.sqrt(np.maximum(squares, 0.0))
    return np.ascontiguousarray(
        distances.reshape(len(query), count, strips).transpose(1, 0, 2), np.float32
    )


@njit(cache=True)
def turned_sums(values: NDArray[Any]) -> FloatArray:
    """Sum over the strips under every turn of a circle, (M, S): strip i against i + turn.

    ``values`` : (M, S, S) as from strip_distances.
    """
    count, strips, _ = values.shape
    out = np.zeros((count, strips))
    for m in range(count):
        for i in range(strips):
            for j in range(strips):
                turn = j - i
                if turn < 0:
                    turn += strips
                out[m, turn] += values[m, i, j]
    return out


@njit(cache=True)
def banded_scores(values: SingleArray, band: int) -> FloatArray:
    """Best global alignment of the strips (Needleman, Wunsch 1970), gaps free, (M,).

    A strip meets none that is more than ``band`` away from its own position.

    ``values`` : (M, S, S) likeness, positive where strips are more alike than most.
    """
    count, strips, _ = values.shape
    out = np.zeros(count)
    before = np.zeros(strips + 1)
    row = np.zeros(strips + 1)
    for m in range(count):
        before[:] = 0.0
        for i in range(1, strips + 1):
            first, last = max(1, i - band), min(strips, i + band)
            row[first - 1] = before[first - 1]
            for j in range(first, last + 1):
                best = before[j - 1] + values[m, i - 1, j - 1]
                best = max(best, row[j - 1])
                if j < i + band:
                    best = max(best, before[j])
                row[j] = best
            before[first - 1 : last + 1] = row[first - 1 : last + 1]
        out[m] = before[strips]
    return out


@njit(cache=True)
def shifted_means(values: NDArray[Any], band: int) -> FloatArray:
    """Mean over the overlap under every shift of at most ``band`` strips, (M, 2 band + 1)."""
    count, strips, _ = values.shape
    out = np.zeros((count, 2 * band + 1))
    for m in range(count):
        for shift in range(-band, band + 1):
            first, last = max(0, -shift), min(strips, strips - shift)
            total = 0.0
            for i in range(first, last):
                total += values[m, i, i + shift]
            out[m, shift + band] = total / max(last - first, 1)
    return out
