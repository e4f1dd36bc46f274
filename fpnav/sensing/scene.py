"""A scene as a grid of 5 x 5 cells (Kortenkamp and Weymouth's abstracted scene representation).

A robot that stops at a gateway to 3.5 degrees sees a cue two metres away within one cell
(systems.md 3.6).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.sensing.cues import SIZE_PX

CELLS = 5
CELL_PX = SIZE_PX // CELLS
COVERED_PX = CELL_PX // 2
"""A cue lies in the rows of which it covers half."""

FACINGS = 8
CLASSES_M = 2.0, 4.0, 8.0
FAR, UNKNOWN = 3, 4


def columns_of(cues: NDArray[np.void]) -> NDArray[np.int64]:
    """Column of the grid each cue lies in."""
    columns = np.clip(cues["x_px"] // CELL_PX, 0, CELLS - 1)
    return np.asarray(columns, dtype=np.int64)


def cells_of(cues: NDArray[np.void]) -> NDArray[np.int64]:
    """Cells each cue lies in, as 25 bits: bit 5 row + column.

    It lies in the column of its x and in every row it covers half of; where there is none, in
    the first it covers most of.
    """
    edges = CELL_PX * np.arange(CELLS, dtype=np.float64)
    top, bottom = cues["top_px"][:, None], cues["bottom_px"][:, None] + 1.0
    covered = np.minimum(bottom, edges + CELL_PX) - np.maximum(top, edges)
    inside = covered >= COVERED_PX
    nowhere = ~inside.any(axis=1)
    inside[nowhere, covered[nowhere].argmax(axis=1)] = True
    rows = (inside << (CELLS * np.arange(CELLS))).sum(axis=1, dtype=np.int64)
    return np.asarray(rows << columns_of(cues), dtype=np.int64)


def distance_class(distance_m: NDArray[np.float32]) -> NDArray[np.int64]:
    """Below 2, 2-4, 4-8, beyond 8 metres, unknown: 0..4."""
    known = np.searchsorted(CLASSES_M, distance_m, side="right")
    return np.where(np.isnan(distance_m), UNKNOWN, known).astype(np.int64)


def compatible(
    first_m: NDArray[np.float32], second_m: NDArray[np.float32], share: float
) -> NDArray[np.bool_]:
    """Whether distances may be of one thing, broadcasting.

    Within a share of the larger; the unknown may be far or unknown.
    """
    a, b = distance_class(first_m), distance_class(second_m)
    unknown = (a == UNKNOWN) | (b == UNKNOWN)
    with np.errstate(invalid="ignore"):
        near = np.abs(first_m - second_m) <= share * np.maximum(first_m, second_m)
    return np.asarray(np.where(unknown, np.minimum(a, b) >= FAR, near), dtype=np.bool_)


def facing_of(bearing_rad: float) -> int:
    """Which of eight directions of 45 degrees a bearing lies in: 0 ahead, counter-clockwise."""
    return math.floor(bearing_rad / (TAU / FACINGS) + 0.5) % FACINGS
