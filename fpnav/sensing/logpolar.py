"""Local views: log-polar patches around focus points, all of an image in one resampling."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

CLIP_SIGMAS = 2.5
FLAT = 1e-6


def sample_offsets(radius_px: float, columns: int, rows: int) -> tuple[FloatArray, FloatArray]:
    """Offsets x and y, (rows, columns) each, of a log-polar patch.

    Rows are angles from the x axis towards y, columns radii ``radius ** (j / columns) - 1``: the
    grid of OpenCV's warpPolar with WARP_POLAR_LOG.
    """
    angle = 2.0 * np.pi * np.arange(rows) / rows
    reach = radius_px ** (np.arange(columns) / columns) - 1.0
    return np.outer(np.cos(angle), reach), np.outer(np.sin(angle), reach)


def local_views(
    image: NDArray[np.uint8],
    points: NDArray[np.int64],
    radius_px: float,
    columns: int,
    rows: int,
) -> NDArray[np.uint8]:
    """Views (n, rows * columns) of the discs around points (n, 2); borders are replicated."""
    if len(points) == 0:
        return np.zeros((0, rows * columns), np.uint8)
    across, down = sample_offsets(radius_px, columns, rows)
    map_x = (points[:, :1] + across.ravel()).astype(np.float32)
    map_y = (points[:, 1:] + down.ravel()).astype(np.float32)
    views = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(views)


def standardised(views: NDArray[Any]) -> NDArray[np.uint8]:
    """Views with mean and contrast taken out: +-2.5 standard deviations become 0 .. 255."""
    values = views.astype(np.float64)
    centred = values - values.mean(axis=1, keepdims=True)
    spread = np.maximum(values.std(axis=1, keepdims=True), FLAT)
    scaled = np.clip(centred / spread, -CLIP_SIGMAS, CLIP_SIGMAS) / (2.0 * CLIP_SIGMAS) + 0.5
    return np.asarray(np.round(scaled * 255.0), dtype=np.uint8)
