"""Polar scan signature: hits by bearing and range, under every turn; Scan Context in the plane.

G. Kim, A. Kim: Scan Context: egocentric spatial descriptor for place recognition within 3D point
cloud map, IROS 2018. A planar scan has counts where theirs has heights, and rings that widen with
range.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from fpnav.params import Count, Params
from fpnav.sensing.polar import polar_grid
from fpnav.systems.lasers import LASER_LATE, LaserParams, LaserSystem, sweep_of
from fpnav.values import FloatArray, Signature


class PolarParams(LaserParams, frozen=True):
    """``bins`` of bearing, ``rings`` of range."""

    bins: Count = 90
    rings: Count = 16


class Polar(LaserSystem):
    """Polar grids, compared by their cosine."""

    NAME: ClassVar[str] = "polar"
    SUMMARY: ClassVar[str] = "hits by bearing and range, any turn (Scan Context in the plane)"
    PARAMS: ClassVar[type[Params]] = PolarParams
    LATE: ClassVar[frozenset[str]] = LASER_LATE | {"bins", "rings"}
    PRESETS: ClassVar[Mapping[str, Params]] = {
        "paper": PolarParams(bins=60, rings=20),
        "default": PolarParams(),
    }

    def grid(self, signature: Signature) -> FloatArray:
        """Hits by bearing and range."""
        sweep = sweep_of(signature.parts["rays"])
        points = np.column_stack([axis[sweep.hits] for axis in sweep.points])
        return polar_grid(points, self._params.bins, self._params.rings)
