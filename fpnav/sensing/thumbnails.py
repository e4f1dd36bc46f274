"""Images made small: grey thumbnails, normalised in patches or as they are."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

SingleArray = NDArray[np.float32]


def thumbnail(pixels: NDArray[np.uint8], width_px: int, height_px: int) -> SingleArray:
    """Luminance in [0, 1] of an image (H, W, 3) uint8 brought to a size, (height_px, width_px)."""
    shrinks = pixels.shape[1] >= width_px and pixels.shape[0] >= height_px
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    small = cv2.resize(grey, (width_px, height_px), interpolation=how)
    return np.asarray(small, np.float32) / np.float32(255.0)


def patch_normalised(
    pixels: NDArray[np.uint8], width_px: int, height_px: int, patch_px: int
) -> SingleArray:
    """Thumbnail with mean 0 and deviation 1 in every square patch; a patch that is flat is 0.

    The sides are multiples of ``patch_px``, the last patches smaller where they are not.
    """
    small = thumbnail(pixels, width_px, height_px)
    out = np.zeros_like(small)
    for top in range(0, height_px, patch_px):
        for left in range(0, width_px, patch_px):
            where = np.s_[top : top + patch_px, left : left + patch_px]
            centred = small[where] - small[where].mean()
            spread = float(centred.std())
            out[where] = centred / spread if spread > 1e-3 else 0.0
    return out
