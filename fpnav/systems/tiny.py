"""Tiny images: patch-normalised thumbnails and their mean absolute difference.

M. Milford, G. Wyeth: SeqSLAM: visual route-based navigation for sunny summer days and stormy
winter nights, ICRA 2012; without its sequences, which are another system.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Params, Pixels
from fpnav.sensing.thumbnails import patch_normalised
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, no_turns, overlap
from fpnav.values import FloatArray


class TinyParams(ImageParams, frozen=True):
    """``width_px``, ``height_px`` of the thumbnail; ``patch_px`` over which it is normalised."""

    width_px: Pixels = 64
    height_px: Pixels = 32
    patch_px: Pixels = 8


class TinyImage(ImageSystem):
    """Patch-normalised thumbnails."""

    NAME: ClassVar[str] = "tiny"
    SUMMARY: ClassVar[str] = "patch-normalised thumbnails, absolute difference (Milford, Wyeth)"
    PARAMS: ClassVar[type[Params]] = TinyParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {
        "paper": TinyParams(theta=0.5),
        "default": TinyParams(theta=0.5),
    }

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """The thumbnail, row by row."""
        p = self._params
        return patch_normalised(pixels, p.width_px, p.height_px, p.patch_px).ravel()

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Mean absolute difference, negative."""
        return no_turns(-np.abs(members - query).mean(axis=1, dtype=np.float64))

    def alike(self, first: Vector, second: Vector) -> float:
        """Difference by what is there to differ."""
        return overlap(first, second)

    def drawn(self, vector: Vector) -> FloatArray:
        """The thumbnail."""
        return np.asarray(vector, np.float64).reshape(self._params.height_px, -1)
