"""Gradient magnitude by the Deriche pair: exponential smoothing and derivative as FIR kernels."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

FloatImage = NDArray[np.float32]

TAIL = 12.0
"""Kernels end where alpha |n| reaches this: 15 px at alpha 0.8, 12 px at alpha 1."""

TOP_SHARE = 0.995


def deriche_radius(alpha: float) -> int:
    """Half-size of the truncated kernels in pixels."""
    return math.ceil(TAIL / alpha)


def deriche_kernels(alpha: float) -> tuple[FloatArray, FloatArray]:
    """Smoothing kernel of sum 1 and derivative kernel of unit step response (Deriche 1987).

    ``S(n) = k (alpha |n| + 1) exp(-alpha |n|)``, ``D(n) = c n exp(-alpha |n|)`` for correlation;
    the tails cut off (less than 1e-4) are given back by scaling.
    """
    n = np.arange(-deriche_radius(alpha), deriche_radius(alpha) + 1, dtype=np.float64)
    decay = np.exp(-alpha * np.abs(n))
    smooth = (alpha * np.abs(n) + 1.0) * decay
    derivative = n * decay
    return smooth / smooth.sum(), derivative / derivative[n > 0].sum()


def gradient_magnitude(image: NDArray[Any], alpha: float, pad_px: int = 0) -> FloatImage:
    """Gradient magnitude in [0, 1]: scaled by its 99.5 percentile and clipped.

    Borders are replicated. A constant image gives zeros.

    Parameters
    ----------
    image : (H, W) uint8 or float32
    alpha : inverse width of the smoothing in 1/px; larger = less smoothing
    pad_px : columns on either side that repeat the other and do not count for the percentile
    """
    smooth, derivative = deriche_kernels(alpha)
    across = _filtered(image, derivative, smooth)
    down = _filtered(image, smooth, derivative)
    magnitude: FloatImage = np.asarray(cv2.magnitude(across, down), dtype=np.float32)
    top = _quantile(magnitude[:, pad_px : magnitude.shape[1] - pad_px], TOP_SHARE)
    if top <= 1e-4:
        return np.zeros_like(magnitude)
    return np.asarray(np.minimum(magnitude * np.float32(1.0 / top), 1.0), dtype=np.float32)


def _filtered(image: NDArray[Any], along_x: FloatArray, along_y: FloatArray) -> FloatImage:
    kernels = along_x.astype(np.float32), along_y.astype(np.float32)
    out = cv2.sepFilter2D(image, cv2.CV_32F, *kernels, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(out, dtype=np.float32)


def _quantile(values: FloatImage, share: float) -> float:
    flat = values.ravel()
    rank = min(len(flat) - 1, int(share * len(flat)))
    return float(np.partition(flat, rank)[rank])
