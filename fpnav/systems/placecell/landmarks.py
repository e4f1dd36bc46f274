"""Landmark recognition (eq. 1) and the competition among landmarks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.patches import Patches, nearest
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import FloatArray

WHITE = 255.0


@dataclass(frozen=True, slots=True, eq=False)
class Interpretations:
    """Landmarks recognised in views, after the competition.

    ``view``, ``landmark`` : (n,) rows; ``level`` : (n,) activity l in (0, 1]; by view, best first.
    """

    view: NDArray[np.int64]
    landmark: NDArray[np.int64]
    level: FloatArray


def level(sad: NDArray[Any], pixels: int, threshold: float) -> FloatArray:
    """Recognition level l = f_RT(1 - SAD / N) of grey levels in [0, 1] (eq. 1)."""
    likeness = 1.0 - np.asarray(sad, dtype=np.float64) / (WHITE * pixels)
    return np.asarray(np.maximum(likeness - threshold, 0.0) / (1.0 - threshold))


def sad_limit(pixels: int, threshold: float) -> int:
    """The least SAD of 0 .. 255 grey levels whose recognition level is zero."""
    return math.ceil(round((1.0 - threshold) * WHITE * pixels, 6))


def recognise(
    views: Patches,
    landmarks: Patches,
    params: PlacecellParams,
    allowed: NDArray[np.bool_] | None = None,
) -> Interpretations:
    """The most active landmarks of each view: at most ``interpretations``, all above RT.

    ``allowed`` : (L,) landmarks that take part in the competition; None = all.
    """
    limit = sad_limit(params.pixels, params.rt)
    found = nearest(views, landmarks, params.interpretations, limit, allowed)
    view, rank = np.nonzero(found.rows >= 0)
    return Interpretations(
        view.astype(np.int64),
        found.rows[view, rank].astype(np.int64),
        level(found.sads[view, rank], params.pixels, params.rt),
    )


def reusable(views: Patches, landmarks: Patches, params: PlacecellParams) -> NDArray[np.int64]:
    """Landmark each view is so like that it needs none of its own, (V,); -1 where there is none."""
    if not params.reuse:
        return np.full(len(views), -1)
    limit = math.floor(round((1.0 - params.reuse_vigilance) * WHITE * params.pixels, 6)) + 1
    return nearest(views, landmarks, 1, limit).rows[:, 0].astype(np.int64)
