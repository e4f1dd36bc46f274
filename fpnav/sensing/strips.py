"""What a camera sees strip by strip of angle: edges, hue and grey of each as one row of numbers.

The attributes a symbol of a fingerprint carries when it stands for an angle rather than for a
feature; each in itself common: histograms of oriented gradients (Dalal, Triggs 2005), of hue, and
grey patches, normalised for themselves and over the image.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Strips = NDArray[np.float32]

HEIGHT, STRIP_PX, CELL_PX = 64, 8, 8
BANDS, ORIENTATIONS = HEIGHT // CELL_PX, 8
HUES, GREYS, COLOUR_BANDS = 10, 6, 2
PATCH_ROWS, PATCH_COLUMNS = 24, 2
LEAST_CONTRAST = 4.0 / 255.0

EDGES = slice(0, BANDS * ORIENTATIONS)
COLOUR = slice(EDGES.stop, EDGES.stop + COLOUR_BANDS * (HUES + GREYS))
SHAPE = slice(COLOUR.stop, COLOUR.stop + PATCH_ROWS * PATCH_COLUMNS)
TONE = slice(SHAPE.stop, SHAPE.stop + PATCH_ROWS * PATCH_COLUMNS)
KINDS = (EDGES, COLOUR, SHAPE, TONE)
"""Columns of a strip by attribute: oriented edges, hue and grey distribution, grey normalised
within the strip, grey normalised over the image."""

WIDTH = TONE.stop


def strips_of(pixels: NDArray[np.uint8], count: int, *, circular: bool) -> Strips:
    """Attributes of the strips of an image, from left to right, (count, WIDTH) float32.

    Parameters
    ----------
    pixels : (H, W, 3) uint8 BGR
    count : strips over the width
    circular : whether the last column borders on the first
    """
    wide = count * STRIP_PX
    shrinks = pixels.shape[1] >= wide and pixels.shape[0] >= HEIGHT
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    image = np.asarray(cv2.resize(pixels, (wide, HEIGHT), interpolation=how), np.uint8)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float32) / 255.0
    patches = _patches(grey, count)
    parts = [
        edge_histograms(grey, circular=circular),
        _colours(image, count, circular=circular),
        _within(patches),
        (patches - grey.mean()) / (grey.std() + LEAST_CONTRAST),
    ]
    return np.asarray(np.hstack(parts), np.float32)


def edge_histograms(grey: NDArray[np.float32], *, circular: bool) -> NDArray[np.float32]:
    """Gradient orientations of every strip by height, its neighbours counting half.

    Square roots of histograms normalised by strip, with the mean of the image as floor.

    Parameters
    ----------
    grey : (H, W) in [0, 1], both multiples of CELL_PX

    Returns
    -------
    (W / CELL_PX, H / CELL_PX * ORIENTATIONS)
    """
    cells = gradient_cells(grey, circular=circular)
    rows = _with_neighbours(cells, circular=circular).transpose(1, 0, 2)
    flat = rows.reshape(rows.shape[0], -1)
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    return np.asarray(np.sqrt(flat / (size + 0.3 * size.mean() + 1e-6)), np.float32)


def gradient_cells(grey: NDArray[np.float32], *, circular: bool) -> NDArray[np.float32]:
    """Gradient magnitude by unsigned orientation, shared between the two nearest bins, summed over
    cells, (H / CELL_PX, W / CELL_PX, ORIENTATIONS)."""
    border = cv2.BORDER_WRAP if circular else cv2.BORDER_REPLICATE
    padded = cv2.copyMakeBorder(grey, 0, 0, 1, 1, border)
    across = cv2.Sobel(padded, cv2.CV_32F, 1, 0, ksize=3)[:, 1:-1]
    down = cv2.Sobel(padded, cv2.CV_32F, 0, 1, ksize=3)[:, 1:-1]
    size = np.hypot(across, down)
    position = np.mod(np.arctan2(down, across), np.pi) / np.pi * ORIENTATIONS - 0.5
    low = np.floor(position).astype(np.int64)
    share = (position - low).astype(np.float32)
    high, wide = grey.shape[0] // CELL_PX, grey.shape[1] // CELL_PX
    cells = np.zeros((high, wide, ORIENTATIONS), np.float32)
    for bin_ in range(ORIENTATIONS):
        part = np.where(low % ORIENTATIONS == bin_, 1.0 - share, np.float32(0.0))
        part = part + np.where((low + 1) % ORIENTATIONS == bin_, share, np.float32(0.0))
        blocks = (size * part).reshape(high, CELL_PX, wide, CELL_PX)
        cells[:, :, bin_] = blocks.sum(axis=(1, 3))
    return cells


def colour_bins(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Every pixel as weights of HUES hue and GREYS grey bins that sum to 1, (H, W, bins).

    Colour counts by its saturation, and little where it is dark.
    """
    hsv = cv2.cvtColor(pixels.astype(np.float32) / 255.0, cv2.COLOR_BGR2HSV)
    hue = np.minimum((hsv[..., 0] / 360.0 * HUES).astype(np.int64), HUES - 1)
    grey = HUES + np.minimum((hsv[..., 2] * GREYS).astype(np.int64), GREYS - 1)
    vivid = np.minimum(2.0 * hsv[..., 1], 1.0) * np.minimum(4.0 * hsv[..., 2], 1.0)
    out = np.zeros((*hue.shape, HUES + GREYS), np.float32)
    np.put_along_axis(out, hue[..., None], vivid[..., None], axis=2)
    np.put_along_axis(out, grey[..., None], 1.0 - vivid[..., None], axis=2)
    return out


def _colours(image: NDArray[np.uint8], count: int, *, circular: bool) -> NDArray[np.float32]:
    """Square roots of hue and grey shares of each strip, upper and lower half for themselves."""
    shape = (COLOUR_BANDS, HEIGHT // COLOUR_BANDS, count, STRIP_PX, HUES + GREYS)
    bands = colour_bins(image).reshape(shape).sum(axis=(1, 3))
    rows = _with_neighbours(bands, circular=circular).transpose(1, 0, 2).reshape(count, -1)
    return np.asarray(np.sqrt(rows / rows.sum(axis=1, keepdims=True)), np.float32)


def _with_neighbours(cells: NDArray[Any], *, circular: bool) -> NDArray[Any]:
    """Cells (bands, strips, bins) with half of those on either side added."""
    left = np.roll(cells, 1, axis=1)
    right = np.roll(cells, -1, axis=1)
    if not circular:
        left[:, 0], right[:, -1] = cells[:, 0], cells[:, -1]
    return np.asarray(cells + 0.5 * (left + right))


def _patches(grey: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    size = (count * PATCH_COLUMNS, PATCH_ROWS)
    small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    cut = small.reshape(PATCH_ROWS, count, PATCH_COLUMNS)
    return np.asarray(cut.transpose(1, 0, 2).reshape(count, -1), np.float32)


def _within(patches: NDArray[np.float32]) -> NDArray[np.float32]:
    centred = patches - patches.mean(axis=1, keepdims=True)
    spread = centred.std(axis=1, keepdims=True) + LEAST_CONTRAST
    return np.asarray(centred / spread, np.float32)
