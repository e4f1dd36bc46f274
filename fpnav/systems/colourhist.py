"""Colour histograms of whole images and their intersection.

M. Swain, D. Ballard: Color indexing, IJCV 1991; for topological localization with panoramas I.
Ulrich, I. Nourbakhsh: Appearance-based place recognition for topological localization, ICRA 2000.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, Params
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, no_turns
from fpnav.values import FloatArray


class ColourParams(ImageParams, frozen=True):
    """``hues``, ``saturations``, ``values``: bins of each axis."""

    hues: Count = 16
    saturations: Count = 4
    values: Count = 4


class ColourHistogram(ImageSystem):
    """Histograms of hue, saturation and value."""

    NAME: ClassVar[str] = "colourhist"
    SUMMARY: ClassVar[str] = "colour histograms, intersection (Swain, Ballard; Ulrich, Nourbakhsh)"
    PARAMS: ClassVar[type[Params]] = ColourParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": ColourParams(), "default": ColourParams()}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """Shares of the bins."""
        p = self._params
        hsv = cv2.cvtColor(pixels, cv2.COLOR_BGR2HSV)
        bins, limits = [p.hues, p.saturations, p.values], [0, 180, 0, 256, 0, 256]
        counts = cv2.calcHist([hsv], [0, 1, 2], None, bins, limits)
        return np.asarray(counts.ravel() / counts.sum(), np.float32)

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Intersections."""
        return no_turns(np.minimum(members, query).sum(axis=1, dtype=np.float64))

    def alike(self, first: Vector, second: Vector) -> float:
        """Intersection by what there is."""
        total = float(np.maximum(first.sum(), second.sum()))
        return float(np.minimum(first, second).sum()) / total

    def drawn(self, vector: Vector) -> FloatArray:
        """Hues from left to right, saturation by value from top to bottom."""
        return np.asarray(vector, np.float64).reshape(self._params.hues, -1).T
