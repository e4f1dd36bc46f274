"""Histograms of oriented gradients of whole images.

N. Dalal, B. Triggs: Histograms of oriented gradients for human detection, CVPR 2005; as a
descriptor of places in VPR-Bench (M. Zaffar et al., IJCV 2021).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, Params
from fpnav.sensing.strips import CELL_PX, gradient_cells
from fpnav.sensing.thumbnails import thumbnail
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, cosine, no_turns
from fpnav.values import FloatArray

CLIP = 0.2


class HogParams(ImageParams, frozen=True):
    """``columns``, ``rows`` of cells of 8 px."""

    columns: Count = 32
    rows: Count = 16


class Hog(ImageSystem):
    """Cells of gradient orientations, normalised over blocks of two by two."""

    NAME: ClassVar[str] = "hog"
    SUMMARY: ClassVar[str] = "histograms of oriented gradients (Dalal, Triggs)"
    PARAMS: ClassVar[type[Params]] = HogParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": HogParams(), "default": HogParams()}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """Blocks end to end, of length 1 together."""
        p = self._params
        grey = thumbnail(pixels, p.columns * CELL_PX, p.rows * CELL_PX)
        flat = _blocks(gradient_cells(grey, circular=circular)).ravel()
        return np.asarray(flat / max(float(np.linalg.norm(flat)), 1e-9), np.float32)

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Cosines."""
        return no_turns(np.asarray(members @ query, np.float64))

    def alike(self, first: Vector, second: Vector) -> float:
        """Cosine."""
        return cosine(first, second)

    def drawn(self, vector: Vector) -> FloatArray:
        """How much of an edge there is in each block."""
        blocks = vector.reshape(self._params.rows - 1, self._params.columns - 1, -1)
        return np.asarray(np.linalg.norm(blocks, axis=2), np.float64)


def _blocks(cells: NDArray[np.float32]) -> NDArray[np.float32]:
    """Two by two cells side by side, of length 1, clipped and of length 1 again."""
    parts = [cells[:-1, :-1], cells[:-1, 1:], cells[1:, :-1], cells[1:, 1:]]
    blocks = np.concatenate(parts, axis=2)
    for most in (CLIP, 1.0):
        size = np.sqrt(np.square(blocks).sum(axis=2, keepdims=True) + 1e-4)
        blocks = np.minimum(blocks / size, most)
    return np.asarray(blocks, np.float32)
