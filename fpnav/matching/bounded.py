# mypy: disable-error-code="no-untyped-def"
"""Nearest patches by SAD with block-mean bounds, compiled by numba.

Stored means lie block by block, so the inner loop runs over stored patches without a lookup.
Compiled code is cached on disk.
"""

from __future__ import annotations

import numba
import numpy as np

TILE = 4096
NEVER = np.int32(np.iinfo(np.int32).max)

_jit = numba.njit(cache=True, nogil=True, error_model="numpy")


@_jit
def nearest_bounded(views, view_means, store, means, allowed, per_block, limit, rows, sads):
    """Fill ``rows`` and ``sads`` (V, k) with the nearest allowed patches, ties by row.

    ``views`` (V, D), ``view_means`` (V, B), ``store`` (L, D), ``means`` (B, L), all uint8;
    ``allowed`` (L,) bool; SADs of ``limit`` or more are no match.

    A rounded mean is off by half a grey level at most, the difference of two by one: a SAD is at
    least ``per_block`` times what the differences of means sum to beyond one for each block.
    """
    apart, near = np.empty(TILE, np.uint16), np.empty(TILE, np.int32)
    blocks = means.shape[0]
    for start in range(0, store.shape[0], TILE):
        size = min(TILE, store.shape[0] - start)
        for v in range(views.shape[0]):
            _block_differences(view_means[v], means, start, size, apart)
            seeded = -1
            if rows[v, -1] < 0:
                seeded = _seed_bound(apart, size, rows.shape[1])
                count = _between(apart, size, -1, seeded, near)
                _refine(views[v], store, allowed, start, apart, near[:count], per_block, blocks,
                        limit, rows[v], sads[v])  # fmt: skip
            top = min(np.int64(sads[v, -1]), limit - 1) // per_block + blocks
            count = _between(apart, size, seeded, top, near)
            _refine(views[v], store, allowed, start, apart, near[:count], per_block, blocks,
                    limit, rows[v], sads[v])  # fmt: skip


@_jit
def _block_differences(view_means, means, start, size, apart):
    """Sum over blocks of absolute differences of means, for a tile of stored patches."""
    for j in range(size):
        apart[j] = 0
    for b in range(means.shape[0]):
        value = view_means[b]
        row = means[b, start : start + size]
        for j in range(size):
            other = row[j]
            apart[j] += np.uint16(max(value, other) - min(value, other))


@_jit
def _seed_bound(apart, size, count):
    """A bound that at least ``count`` patches of the tile keep, or the largest there is."""
    histogram = np.zeros(1024, np.int32)
    for j in range(size):
        histogram[apart[j] >> 6] += 1
    total = 0
    for bin in range(1024):
        total += histogram[bin]
        if total >= count:
            return (bin << 6) + 63
    return 65535


@_jit
def _between(apart, size, low, high, near):
    """Collect the patches with low < difference <= high, without a branch; their number."""
    count = 0
    for j in range(size):
        near[count] = j
        count += (apart[j] > low) & (apart[j] <= high)
    return count


@_jit
def _refine(view, store, allowed, start, apart, near, per_block, blocks, limit, rows, sads):
    """Compare pixel by pixel what may still be among the best."""
    top = min(np.int64(sads[-1]), limit - 1) // per_block + blocks
    for j in near:
        if np.int64(apart[j]) > top or not allowed[start + j]:
            continue
        sad = _sad(view, store[start + j])
        if sad < limit and _insert(rows, sads, start + j, sad):
            top = min(np.int64(sads[-1]), limit - 1) // per_block + blocks


@_jit
def _insert(rows, sads, row, sad):
    """Put a match where it belongs among the best; False where it is not among them."""
    k = len(rows) - 1
    if sad > sads[k] or (sad == sads[k] and rows[k] >= 0 and row > rows[k]):
        return False
    while k > 0 and (sads[k - 1] > sad or (sads[k - 1] == sad and rows[k - 1] > row)):
        rows[k], sads[k] = rows[k - 1], sads[k - 1]
        k -= 1
    rows[k], sads[k] = row, sad
    return True


@_jit
def _sad(first, second):
    """Sum of absolute differences of two byte rows; this form becomes one vector instruction."""
    total = np.int32(0)
    for d in range(len(first)):
        total += abs(np.int32(first[d]) - np.int32(second[d]))
    return np.int64(total)
