"""Rotational image differences of panoramas.

J. Zeil, M. Hofmann, J. Chahl: Catchment areas of panoramic snapshots in outdoor scenes, JOSA A
2003.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.params import Params, Pixels
from fpnav.sensing.thumbnails import thumbnail
from fpnav.systems.base import Needs
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector
from fpnav.values import FloatArray

ROUND = ("panorama", "omni")


class RidfParams(ImageParams, frozen=True):
    """``width_px``, ``height_px`` of the panorama, a column being the step of rotation."""

    width_px: Pixels = 120
    height_px: Pixels = 24


class Ridf(ImageSystem):
    """Grey panoramas and the least difference over all rotations."""

    NAME: ClassVar[str] = "ridf"
    SUMMARY: ClassVar[str] = "rotational image difference of panoramas (Zeil et al.)"
    NEEDS: ClassVar[Needs] = Needs(ROUND, (ROUND,))
    PARAMS: ClassVar[type[Params]] = RidfParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": RidfParams(), "default": RidfParams()}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """The grey panorama, row by row."""
        return thumbnail(pixels, self._params.width_px, self._params.height_px).ravel()

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Root mean square difference under the best rotation, negative, and that rotation."""
        squares = self._squares(query, members)
        best = squares.argmin(axis=1)
        least = squares[np.arange(len(best)), best] / query.size
        turns = (best * (TAU / self._params.width_px) + np.pi) % TAU - np.pi
        return -np.sqrt(least), turns

    def alike(self, first: Vector, second: Vector) -> float:
        """1 - squared difference over variances, means and all; 1 for equal ones."""
        least = float(self._squares(first, second[None])[0].min())
        room = sum(float(np.square(one - one.mean()).sum()) for one in (first, second))
        return 1.0 - least / room if room > 1e-6 else float(least < 1e-6)

    def drawn(self, vector: Vector) -> FloatArray:
        """The panorama."""
        return np.asarray(vector, np.float64).reshape(self._params.height_px, -1)

    def _squares(self, query: Vector, members: Vector) -> FloatArray:
        """Sum of squares under every rotation, (n, W): the query's columns moved left by so many.

        Columns run clockwise, so a query turned counter-clockwise by k columns has moved them
        right by k, and rotation k brings them back.
        """
        width = self._params.width_px
        one = np.fft.rfft(query.reshape(-1, width).astype(np.float64), axis=1)
        others = np.fft.rfft(members.reshape(len(members), -1, width).astype(np.float64), axis=2)
        both = np.fft.irfft((one[None] * np.conj(others)).sum(axis=1), n=width, axis=1)
        sizes = np.square(members, dtype=np.float64).sum(axis=1)[:, None]
        total = sizes + np.square(query, dtype=np.float64).sum() - 2.0 * both
        return np.asarray(np.maximum(total, 0.0))
