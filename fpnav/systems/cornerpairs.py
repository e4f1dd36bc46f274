"""Corner-pair histogram: pairs of corners by direction and distance, under every turn; GLAROT.

D. L. Rizzini, F. Galasso, S. Caselli: Geometric relation distribution for place recognition, RA-L
2019, after M. Himstedt, J. Frost, S. Hellbach, H.-J. Boehme, E. Maehle: Large scale place
recognition in 2D LIDAR scans using geometrical landmark relations, IROS 2014. Corners here are
those of Douglas-Peucker, theirs FLIRT or FALKO keypoints.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, Params, Positive
from fpnav.sensing.polar import pair_histogram
from fpnav.systems.lasers import LASER_LATE, LaserParams, LaserSystem, corner_points
from fpnav.values import FloatArray, Signature


class CornerPairsParams(LaserParams, frozen=True):
    """``bins`` of direction, ``steps`` of distance up to ``most_m``."""

    bins: Count = 30
    steps: Count = 30
    most_m: Positive = 10.0


class CornerPairs(LaserSystem):
    """Histograms of corner pairs, compared by their cosine."""

    NAME: ClassVar[str] = "cornerpairs"
    SUMMARY: ClassVar[str] = "corner pairs by direction and distance, any turn (GLAROT)"
    PARAMS: ClassVar[type[Params]] = CornerPairsParams
    LATE: ClassVar[frozenset[str]] = LASER_LATE | {"bins", "steps", "most_m"}
    PRESETS: ClassVar[Mapping[str, Params]] = {
        "paper": CornerPairsParams(bins=24, steps=20),
        "default": CornerPairsParams(),
    }

    def grid(self, signature: Signature) -> FloatArray:
        """Pairs by direction and distance."""
        return pair_histogram(
            corner_points(signature), self._params.bins, self._params.steps, self._params.most_m
        )

    def cover(self, signature: Signature, bins: int) -> NDArray[np.bool_]:
        """Every direction: a pair has one whatever the laser looked at."""
        return np.ones(bins, bool)
