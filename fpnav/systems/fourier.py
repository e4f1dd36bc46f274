"""Fourier signatures of panoramas.

H. Ishiguro, S. Tsuji: Image-based memory of environment, IROS 1996; E. Menegatti, T. Maeda, H.
Ishiguro: Image-based memory for robot navigation using properties of omnidirectional images,
Robotics and Autonomous Systems 2004.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, Params, Pixels
from fpnav.sensing.thumbnails import thumbnail
from fpnav.systems.base import Needs
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, overlap
from fpnav.values import FloatArray

ROUND = ("panorama", "omni")
LEADING = 5
"""Harmonics whose phases tell the turn, those a small shift of place changes least."""

STEPS = 360


class FourierParams(ImageParams, frozen=True):
    """``width_px``, ``height_px`` of the panorama; ``harmonics`` kept of every row."""

    width_px: Pixels = 360
    height_px: Pixels = 24
    harmonics: Count = 15
    theta: float = 0.15


class FourierSignature(ImageSystem):
    """Leading Fourier coefficients of every row: what turns with the robot is their phase alone."""

    NAME: ClassVar[str] = "fourier"
    SUMMARY: ClassVar[str] = "Fourier signatures of panoramas (Ishiguro, Tsuji; Menegatti et al.)"
    NEEDS: ClassVar[Needs] = Needs(ROUND, (ROUND,))
    PARAMS: ClassVar[type[Params]] = FourierParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]] = {
        "paper": FourierParams(),
        "default": FourierParams(),
    }

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """Real and imaginary parts, row by row, the mean left out."""
        p = self._params
        small = thumbnail(pixels, p.width_px, p.height_px)
        found = np.fft.rfft(small, axis=1)[:, 1 : p.harmonics + 1] / p.width_px
        return np.asarray(np.stack([found.real, found.imag], axis=2).ravel(), np.float32)

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Sum of differences of magnitude, negative, and the turn the leading phases agree on."""
        one, others = self._coefficients(query), self._coefficients(members)
        apart = np.abs(np.abs(others) - np.abs(one)[None]).sum(axis=(1, 2))
        return -apart, self._turns(one, others)

    def alike(self, first: Vector, second: Vector) -> float:
        """Difference of magnitudes by what there is."""
        one, other = (np.abs(self._coefficients(side)) for side in (first, second))
        return overlap(one, other)

    def drawn(self, vector: Vector) -> FloatArray:
        """Magnitudes: rows of the image by harmonic."""
        return np.abs(self._coefficients(vector))

    def _coefficients(self, vectors: Vector) -> NDArray[np.complex128]:
        pairs = vectors.reshape(*vectors.shape[:-1], self._params.height_px, -1, 2)
        return np.asarray(pairs[..., 0] + 1j * pairs[..., 1], np.complex128)

    def _turns(self, one: NDArray[np.complex128], others: NDArray[np.complex128]) -> FloatArray:
        """Turn at which the leading harmonics correlate best, by steps of a degree.

        A query turned counter-clockwise by t has its columns moved right by t: harmonic h turns by
        -h t.
        """
        crossed = (one[None] * np.conj(others)).sum(axis=1)[:, :LEADING]
        harmonics = np.arange(1, crossed.shape[1] + 1)
        angles = np.arange(STEPS) * (2.0 * np.pi / STEPS)
        waves = np.exp(1j * harmonics[:, None] * angles[None, :])
        best = (crossed @ waves).real.argmax(axis=1)
        return np.asarray((angles[best] + np.pi) % (2.0 * np.pi) - np.pi)
