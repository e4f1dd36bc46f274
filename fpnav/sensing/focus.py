"""Focus points: local maxima of the gradient image filtered by a difference of Gaussians."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.gradient import FloatImage
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True)
class DogFilter:
    """Difference of Gaussians, ``centre_px`` minus ``surround_px``, on a square mask.

    ``half_px`` : the mask is (2 half_px + 1) pixels wide; maxima are sought over the square of
    half-side ``reach_px``.
    """

    centre_px: float
    surround_px: float
    half_px: int
    reach_px: int

    @staticmethod
    def of_size(centre_px: float, surround_px: float, size_px: int, *, half: bool) -> DogFilter:
        """Filter of the paper's "DoG size" l: mask (2 l - 1) wide, or l where not ``half``."""
        reach = max(1, size_px // 2 - 1)
        return DogFilter(centre_px, surround_px, size_px - 1 if half else size_px // 2, reach)

    def kernels(self) -> tuple[FloatArray, FloatArray]:
        """One-dimensional factors of the two Gaussians, (2 half_px + 1,) each."""
        n = np.arange(-self.half_px, self.half_px + 1, dtype=np.float64)
        return _gaussian(n, self.centre_px), _gaussian(n, self.surround_px)

    def mask(self) -> FloatArray:
        """The two-dimensional mask that ``response`` applies by its factors."""
        centre, surround = self.kernels()
        return np.outer(centre, centre) - np.outer(surround, surround)

    def response(self, gradient: FloatImage) -> FloatImage:
        """Filtered gradient image, borders replicated."""
        inner, outer = (_smoothed(gradient, kernel) for kernel in self.kernels())
        return inner - outer


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Where focus points may stand: columns x0 <= x < x1, rows y0 <= y < y1.

    ``period_px`` : width after which columns repeat (a padded panorama), 0 = never; ``shut`` (W,)
    columns of the image in which none may stand.
    """

    x0: int
    x1: int
    y0: int
    y1: int
    period_px: int = 0
    shut: NDArray[np.bool_] | None = None


def local_maxima(response: FloatImage, reach_px: int, region: Region) -> NDArray[np.int64]:
    """Points (n, 2) x, y of a region above zero and strictly above all others within the square
    of half-side reach, by rows."""
    side = 2 * reach_px + 1
    highest = cv2.dilate(response, np.ones((side, side), np.uint8))
    inside = np.s_[region.y0 : region.y1, region.x0 : region.x1]
    rows, columns = np.nonzero((response[inside] == highest[inside]) & (response[inside] > 0.0))
    rows, columns = rows + region.y0, columns + region.x0
    if region.shut is not None:
        rows, columns = rows[~region.shut[columns]], columns[~region.shut[columns]]
    padded = cv2.copyMakeBorder(
        response, reach_px, reach_px, reach_px, reach_px, cv2.BORDER_CONSTANT, value=-np.inf
    )
    windows = np.lib.stride_tricks.sliding_window_view(padded, (side, side))[rows, columns]
    alone = (windows == response[rows, columns, None, None]).sum(axis=(1, 2)) == 1
    return np.asarray(np.column_stack([columns, rows])[alone], dtype=np.int64)


def focus_points(
    response: FloatImage, reach_px: int, count: int, region: Region, spacing_px: float
) -> tuple[NDArray[np.int64], FloatArray]:
    """The most intense local maxima of a region, at least ``spacing_px`` apart.

    Ties are broken by row, then column.

    Returns
    -------
    points : (n, 2) int64, x and y, n <= count, strongest first
    strength : (n,) their response
    """
    points = local_maxima(response, reach_px, region)
    strength = response[points[:, 1], points[:, 0]].astype(np.float64)
    order = np.argsort(-strength, kind="stable")
    kept = _spaced(points[order], count, spacing_px, region.period_px)
    return points[order[kept]], strength[order[kept]]


def _spaced(
    points: NDArray[np.int64], count: int, spacing_px: float, period_px: int
) -> NDArray[np.int64]:
    """Rows taken greedily in order, none nearer than the spacing to one taken before."""
    free = np.ones(len(points), dtype=bool)
    kept: list[int] = []
    while len(kept) < count and free.any():
        row = int(np.argmax(free))
        kept.append(row)
        across = np.abs(points[:, 0] - points[row, 0])
        if period_px:
            across = np.minimum(across, period_px - across)
        free &= across**2 + (points[:, 1] - points[row, 1]) ** 2 >= spacing_px**2
        free[row] = False
    return np.array(kept, dtype=np.int64)


def _smoothed(image: FloatImage, kernel: FloatArray) -> FloatImage:
    weights = kernel.astype(np.float32)
    out = cv2.sepFilter2D(image, cv2.CV_32F, weights, weights, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(out, dtype=np.float32)


def _gaussian(n: NDArray[Any], sigma: float) -> FloatArray:
    return np.asarray(np.exp(-(n**2) / (2.0 * sigma**2)) / (np.sqrt(2.0 * np.pi) * sigma))
