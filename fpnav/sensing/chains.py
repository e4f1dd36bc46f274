# mypy: disable-error-code="no-untyped-def"
"""Edge pixels thinned and linked downwards into chains; compiled, since every pixel asks for the
last of its column."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

CHAIN = np.dtype(
    [
        ("sign", "<i8"),
        ("top", "<i8"),
        ("bottom", "<i8"),
        ("low", "<i8"),
        ("high", "<i8"),
        ("count", "<i8"),
        ("sum_x", "<f8"),
        ("sum_strength", "<f8"),
    ]
)
"""First and last row, least and greatest column, and sums over the pixels of a chain."""


def steep_pixels(
    across: NDArray[np.float32], down: NDArray[np.float32], threshold: float, steep: float
) -> NDArray[np.int64]:
    """Pixels (n, 2) row, column of vertical edges, by row and column.

    Those where the step across is above the threshold and ``steep`` times that down, no weaker
    than in the column to the left and stronger than in that to the right; no border columns.
    """
    found = np.zeros((across.size // 2 + 1, 2), np.int64)
    return found[: _steep(across, down, np.float32(threshold), np.float32(steep), found)]


def link(across: NDArray[np.float32], pixels: NDArray[np.int64], reach_px: int) -> NDArray[np.void]:
    """Chains of edge pixels of one sign, each pixel one column or none aside from the last.

    Parameters
    ----------
    across : (H, W) step at every pixel; its sign is the pixel's
    pixels : (n, 2) row, column, by row
    reach_px : most rows from one pixel of a chain to the next

    Returns
    -------
    (m,) CHAIN, in the order their first pixels are met
    """
    whole, sums = np.zeros((len(pixels), 6), np.int64), np.zeros((len(pixels), 2))
    count = _link(across, pixels, reach_px, whole, sums)
    chains = np.zeros(count, CHAIN)
    for number, name in enumerate(("sign", "top", "bottom", "low", "high", "count")):
        chains[name] = whole[:count, number]
    chains["sum_x"], chains["sum_strength"] = sums[:count].T
    return chains


@numba.njit(cache=True, nogil=True)
def _steep(across, down, threshold, steep, found):
    count = 0
    for row in range(across.shape[0]):
        for column in range(1, across.shape[1] - 1):
            here = abs(across[row, column])
            if here <= threshold or here <= steep * abs(down[row, column]):
                continue
            if here >= abs(across[row, column - 1]) and here > abs(across[row, column + 1]):
                found[count, 0], found[count, 1] = row, column
                count += 1
    return count


@numba.njit(cache=True, nogil=True)
def _link(across, pixels, reach, whole, sums):
    owner = np.full(across.shape[1] + 2, -1, np.int64)
    count = 0
    for i in range(len(pixels)):
        row, column = pixels[i]
        sign = 1 if across[row, column] > 0.0 else -1
        best, latest = -1, row - reach - 1
        for aside in (0, -1, 1):
            chain = owner[column + 1 + aside]
            if chain < 0 or whole[chain, 0] != sign:
                continue
            bottom = whole[chain, 2]
            if bottom < row and bottom > latest:
                best, latest = chain, bottom
        if best < 0:
            best = count
            whole[best, 0], whole[best, 1] = sign, row
            whole[best, 3] = whole[best, 4] = column
            count += 1
        whole[best, 2] = row
        whole[best, 3] = min(whole[best, 3], column)
        whole[best, 4] = max(whole[best, 4], column)
        whole[best, 5] += 1
        sums[best, 0] += column
        sums[best, 1] += abs(across[row, column])
        owner[column + 1] = best
    return count
