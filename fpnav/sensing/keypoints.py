"""Keypoints of an image: where they are, and a normalised SIFT descriptor of each in bytes."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

LONGEST_PX = 320
MOST = 200
LEAST_CONTRAST = 0.01

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("descriptor", "u1", (128,))])
"""Position in units of the image's width, from its upper left corner, and 255 times the square
roots of a SIFT descriptor of sum 1 (Arandjelovic, Zisserman 2012), of length 255."""


def keypoints(
    pixels: NDArray[np.uint8], most: int = MOST, longest_px: int = LONGEST_PX
) -> NDArray[Any]:
    """The strongest SIFT keypoints (Lowe 2004) of an image brought to one size, (N,) POINT.

    An image without texture has none.

    Parameters
    ----------
    pixels : (H, W, 3) uint8 BGR
    most : keypoints kept
    longest_px : length of the longer side at which they are looked for
    """
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    scale = longest_px / max(grey.shape)
    how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_CUBIC
    size = (max(1, round(grey.shape[1] * scale)), max(1, round(grey.shape[0] * scale)))
    image = cv2.resize(grey, size, interpolation=how)
    detector = cv2.SIFT.create(most, contrastThreshold=LEAST_CONTRAST)
    found, descriptors = detector.detectAndCompute(image, None)
    rows = np.zeros(min(len(found), most), POINT)
    if len(rows):
        places = np.array([point.pt for point in found], np.float32)[:most]
        rows["x"], rows["y"] = (places / np.float32(size[0])).T
        rows["descriptor"] = _rooted(np.asarray(descriptors[:most], np.float32))
    return rows


def unit(points: NDArray[Any]) -> NDArray[np.float32]:
    """Descriptors of length 1, (N, 128)."""
    values = points["descriptor"].astype(np.float32)
    size = np.linalg.norm(values, axis=1, keepdims=True)
    return np.asarray(values / np.maximum(size, 1.0), np.float32)


def _rooted(descriptors: NDArray[np.float32]) -> NDArray[np.uint8]:
    total = descriptors.sum(axis=1, keepdims=True)
    rooted = np.sqrt(descriptors / np.maximum(total, 1e-6))
    return np.asarray(np.clip(np.rint(rooted * 255.0), 0, 255), np.uint8)
