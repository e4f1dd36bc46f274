"""Colour patches of a view: runs of columns where one of sixteen hues stands out."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.edges import smooth
from fpnav.values import FloatArray

BINS = 16
BIN_DEG = 360.0 / BINS
SATURATION_MIN = math.ceil(0.35 * 255)
VALUE_MIN, VALUE_MAX = math.ceil(0.15 * 255), math.floor(0.98 * 255)
SMOOTH_COLUMNS = 7
FLOOR_SHARE = 0.06
FULL_SHARE = 0.35
RUN_MIN_COLUMNS = 4
RUN_MAX_COLUMNS = 120


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Colour patches: ``bins`` (P,) 0..15, ``columns`` (P,) fractional centres, ``widths`` (P,)
    in columns, ``certainty`` (P,) in [0.3, 1]."""

    bins: NDArray[np.int64]
    columns: FloatArray
    widths: FloatArray
    certainty: FloatArray


def hue_patches(pixels: NDArray[np.uint8], *, circular: bool) -> Patches:
    """Patches of a view (systems.md 1.3.3), by bin, then by column.

    A hue's run of columns above mean plus standard deviation of its tallies, and above 6 % of
    the height, is one patch; runs under 2 degrees are dropped, runs over 60 degrees are split.

    Parameters
    ----------
    pixels : (H, W, 3) uint8 BGR, 0.5 degrees a column
    """
    height = pixels.shape[0]
    tally = smooth(hue_tallies(pixels), SMOOTH_COLUMNS, circular=circular)
    threshold = np.maximum(tally.mean(axis=1) + tally.std(axis=1), FLOOR_SHARE * height)
    rows = [
        (number, *_patch(tally[number], first, length), length)
        for number in np.flatnonzero(tally.max(axis=1, initial=0.0) > FLOOR_SHARE * height)
        for run in _runs(tally[number] > threshold[number], circular=circular)
        for first, length in _split(*run)
    ]
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    certainty = np.clip(table[:, 2] / (FULL_SHARE * height), 0.3, 1.0)
    return Patches(table[:, 0].astype(np.int64), table[:, 1], table[:, 3], certainty)


def hue_tallies(pixels: NDArray[np.uint8]) -> FloatArray:
    """How many pixels of each column show each hue well, (BINS, W)."""
    hue = cv2.cvtColor(pixels * np.float32(1.0 / 255.0), cv2.COLOR_BGR2HSV)[..., 0]
    bins = (hue * np.float32(1.0 / BIN_DEG)).astype(np.uint8) & (BINS - 1)
    # OpenCV's byte hue has steps of 2 degrees, but its saturation and value are as good as floats
    low, high = (0, SATURATION_MIN, VALUE_MIN), (255, 255, VALUE_MAX)
    counts = cv2.inRange(cv2.cvtColor(pixels, cv2.COLOR_BGR2HSV), low, high) > 0
    bins[~counts] = BINS
    return np.array([(bins == number).sum(axis=0) for number in range(BINS)], dtype=np.float64)


def _runs(above: NDArray[np.bool_], *, circular: bool) -> list[tuple[int, int]]:
    """(first column, length) of the maximal runs; a run over the seam starts before it."""
    if above.all():
        return [(0, len(above))] if len(above) else []
    seam = int(np.argmin(above)) if circular else 0
    rolled = np.roll(above, -seam).astype(np.int8)
    steps = np.diff(np.concatenate([[0], rolled, [0]]))
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    return [(int(s) + seam, int(e - s)) for s, e in zip(starts, ends, strict=True)]


def _split(first: int, length: int) -> list[tuple[int, int]]:
    """Equal pieces of at most 60 degrees; nothing where the run is too short."""
    if length < RUN_MIN_COLUMNS:
        return []
    pieces = math.ceil(length / RUN_MAX_COLUMNS)
    cuts = [first + round(length * i / pieces) for i in range(pieces + 1)]
    return [(a, b - a) for a, b in itertools.pairwise(cuts)]


def _patch(tally: FloatArray, first: int, length: int) -> tuple[float, float]:
    """Tally-weighted centre column and mean tally of a run that may pass the seam."""
    columns = np.arange(first, first + length)
    weights = tally[columns % len(tally)]
    return float((weights * columns).sum() / weights.sum()), float(weights.mean())
