"""Cyclic strings of weighted symbols, packed, and the scores that align them.

Weights are multiples of 2^-15 and scores of 2^-16. Sums of up to 255 such scores are exact in
float32, and all are in float64: whatever order an implementation adds in, the answers and their
ties are the same to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

WEIGHT_GRID = 2.0**-15
SCORE_GRID = 2.0**-16


@dataclass(frozen=True, eq=False)
class Strings:
    """A batch of B cyclic strings; string b is ``[offsets[b], offsets[b + 1])``.

    ``codes`` (S,) uint8, ``weights`` (S,) float64 >= 0 on the weight grid, ``angles_rad`` (S,),
    ``offsets`` (B + 1,), ``arcs`` (B, A, 2): centre and width, radians, of what each of A kinds
    of sensor covered, width 0 where it is missing; ``fixed`` (B,) bool: the string has two ends
    (an open view); two such strings are aligned as they stand, all others under every rotation.
    """

    codes: NDArray[np.uint8]
    weights: FloatArray
    angles_rad: FloatArray
    offsets: NDArray[np.int64]
    arcs: FloatArray
    fixed: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.offsets) - 1

    @cached_property
    def lengths(self) -> NDArray[np.int64]:
        """Number of symbols of each string, (B,)."""
        return np.diff(self.offsets)

    @cached_property
    def totals(self) -> FloatArray:
        """Sum of the weights of each string, (B,)."""
        sums = np.concatenate([[0.0], np.cumsum(self.weights)])
        return np.asarray(sums[self.offsets[1:]] - sums[self.offsets[:-1]])

    def take(self, rows: Sequence[int] | NDArray[np.int64]) -> Strings:
        """The named strings, in that order."""
        rows = np.asarray(rows, dtype=np.int64)
        lengths = self.lengths[rows]
        offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        source = np.arange(offsets[-1]) - np.repeat(offsets[:-1] - self.offsets[rows], lengths)
        return Strings(
            self.codes[source],
            self.weights[source],
            self.angles_rad[source],
            offsets,
            self.arcs[rows],
            self.fixed[rows],
        )

    def padded(self) -> tuple[NDArray[np.uint8], FloatArray, FloatArray, NDArray[np.bool_]]:
        """Codes, weights, angles (B, L) and which entries are symbols; padding weighs nothing."""
        width = int(self.lengths.max(initial=0))
        real = np.arange(width)[None, :] < self.lengths[:, None]
        out = []
        for flat in (self.codes, self.weights, self.angles_rad):
            block = np.zeros(real.shape, flat.dtype)
            block[real] = flat
            out.append(block)
        return out[0], out[1], out[2], real


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """What matches and gaps are worth, for C codes.

    ``sigma`` (C, C) symmetric in [-1, 1] with ones on the diagonal; ``gap`` (C,) >= 0, the share
    of its weight an unmatched symbol costs; ``visible`` (C, 2^A) bool: can a symbol of that code
    be seen where exactly those of A kinds of sensor cover (bit a = kind a).
    """

    sigma: FloatArray
    gap: FloatArray
    visible: NDArray[np.bool_]


def on_grid(values: FloatArray, grid: float = WEIGHT_GRID) -> FloatArray:
    """Nearest multiples of the grid."""
    return np.asarray(np.rint(np.asarray(values, dtype=np.float64) / grid) * grid)


def concatenated(parts: Sequence[Strings], kinds: int = 2) -> Strings:
    """All strings of several batches as one batch."""
    lengths = np.concatenate([np.zeros(0, np.int64), *(part.lengths for part in parts)])
    return Strings(
        np.concatenate([np.zeros(0, np.uint8), *(part.codes for part in parts)]),
        np.concatenate([np.zeros(0), *(part.weights for part in parts)]),
        np.concatenate([np.zeros(0), *(part.angles_rad for part in parts)]),
        np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        np.concatenate([np.zeros((0, kinds, 2)), *(part.arcs for part in parts)]),
        np.concatenate([np.zeros(0, bool), *(part.fixed for part in parts)]),
    )
