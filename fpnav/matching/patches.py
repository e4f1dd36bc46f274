"""Nearest stored patches by sum of absolute differences, exact, most of them never touched.

The mean of a block of pixels changes by no more than the mean of the pixels' changes, so the
differences of block means bound the sum of absolute differences (SAD) from below: what is bounded
above the best found so far is not compared pixel by pixel. Small stores are compared whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]

BLOCK = 4
"""Pixels of a block along each side."""

TILE_BYTES = 1 << 20
"""Stored patches compared together: what stays in a core's cache."""

LARGE_BYTES = 256 << 10
"""Stores from this size on are worth bounds and the start of the compiled kernel: at a thousand
patches of 16 x 16 pixels it halves the time, at ten thousand it is three times faster."""

NEVER = np.iinfo(np.int32).max


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """``pixels`` (N, D) uint8, and the rounded ``means`` (N, B) uint8 of their blocks of
    ``per_block`` pixels."""

    pixels: Bytes
    means: Bytes
    per_block: int

    @staticmethod
    def of(pixels: Bytes, rows: int, columns: int) -> Patches:
        """Patches of ``rows`` x ``columns`` pixels, row by row."""
        high, wide = min(BLOCK, rows), min(BLOCK, columns)
        means = _block_means(pixels.reshape(-1, rows, columns), high, wide)
        return Patches(np.ascontiguousarray(pixels), means, high * wide)

    def __len__(self) -> int:
        return len(self.pixels)


def _block_means(patches: Bytes, high: int, wide: int) -> Bytes:
    """Means of whole blocks, (N, B); pixels left over at the edges are in none."""
    count, rows, columns = patches.shape
    down, across = rows // high, columns // wide
    blocks = patches[:, : down * high, : across * wide].reshape(count, down, high, across, wide)
    sums = blocks.sum(axis=2, dtype=np.uint16).sum(axis=3, dtype=np.uint16)
    means = (sums + high * wide // 2) // (high * wide)
    return np.ascontiguousarray(means.reshape(count, down * across), dtype=np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The nearest stored patches of each view, best first.

    ``rows`` and ``sads`` : (V, k) int32; unused places hold -1 and the largest int32.
    """

    rows: NDArray[np.int32]
    sads: NDArray[np.int32]


def nearest(
    views: Patches,
    store: Patches,
    count: int,
    limit: int,
    allowed: NDArray[np.bool_] | None = None,
) -> Nearest:
    """Stored patches with the ``count`` least SADs below ``limit``, of equal ones the first.

    Parameters
    ----------
    views, store : patches of one shape
    limit : a SAD of this or more is no match
    allowed : (L,) patches that may be found; None = all
    """
    if store.pixels.nbytes >= LARGE_BYTES and len(views):
        return nearest_pruned(views, store, count, limit, allowed)
    return nearest_whole(views, store, count, limit, allowed)


def nearest_pruned(
    views: Patches,
    store: Patches,
    count: int,
    limit: int,
    allowed: NDArray[np.bool_] | None = None,
) -> Nearest:
    """The answer of ``nearest`` by bounds first."""
    from fpnav.matching.bounded import nearest_bounded

    found = _empty(len(views), count)
    mask = np.ones(len(store), np.bool_) if allowed is None else allowed
    nearest_bounded(
        views.pixels,
        views.means,
        store.pixels,
        np.ascontiguousarray(store.means.T),
        mask,
        store.per_block,
        limit,
        found.rows,
        found.sads,
    )
    return found


def nearest_whole(
    views: Patches,
    store: Patches,
    count: int,
    limit: int,
    allowed: NDArray[np.bool_] | None = None,
) -> Nearest:
    """The answer of ``nearest`` by comparing every pair pixel by pixel."""
    rows = np.arange(len(store)) if allowed is None else np.flatnonzero(allowed)
    pixels = store.pixels if allowed is None else store.pixels[rows]
    best = _empty(len(views), count)
    tile = max(1, TILE_BYTES // max(1, pixels.shape[1]))
    for start in range(0, len(pixels), tile):
        best = _merged(best, _tile(views.pixels, pixels[start : start + tile], count), start)
    found = (best.rows >= 0) & (best.sads < limit)
    named = np.where(found, rows[best.rows] if len(rows) else -1, -1)
    return Nearest(named.astype(np.int32), np.where(found, best.sads, NEVER).astype(np.int32))


def _empty(views: int, count: int) -> Nearest:
    return Nearest(np.full((views, count), -1, np.int32), np.full((views, count), NEVER, np.int32))


def _tile(views: Bytes, store: Bytes, count: int) -> Nearest:
    """Nearest of a tile, (V, min(count, tile)); OpenCV keeps the first of equal ones."""
    if len(views) == 0:
        return _empty(0, count)
    sads, rows = cv2.batchDistance(
        views, store, cv2.CV_32S, normType=cv2.NORM_L1, K=min(count, len(store))
    )
    return Nearest(np.asarray(rows, np.int32), np.asarray(sads, np.int32))


def _merged(best: Nearest, found: Nearest, start: int) -> Nearest:
    """Best of both; a tie goes to the earlier tile."""
    rows = np.concatenate([best.rows, found.rows + start], axis=1)
    sads = np.concatenate([best.sads, found.sads], axis=1)
    order = np.argsort(sads, axis=1, kind="stable")[:, : best.rows.shape[1]]
    return Nearest(
        np.take_along_axis(rows, order, axis=1).astype(np.int32),
        np.take_along_axis(sads, order, axis=1).astype(np.int32),
    )
