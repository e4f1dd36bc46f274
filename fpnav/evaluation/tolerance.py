"""Recall at 1 over the radius within which a match counts as the same place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import nearest_match_m
from fpnav.evaluation.case import Case, tolerance_of
from fpnav.values import FloatArray

RADII_M = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0])


@dataclass(frozen=True, slots=True, eq=False)
class Tolerance:
    """``right`` of ``base`` queries at each radius, (N,) each; the base grows with the radius."""

    radii_m: FloatArray
    right: NDArray[np.int64]
    base: NDArray[np.int64]


def tolerance_sweep(case: Case, radii_m: FloatArray = RADII_M) -> Tolerance | None:
    """Recall at 1 had the protocol had another radius; its heading limit stays.

    None on a map of places, where the truth is a place, and without true poses.
    """
    result = case.result
    if case.has_map or result.truth.kind != "poses" or not case.judged.any():
        return None
    _, heading_rad = tolerance_of(result)
    poses = result.queries["truth"], result.references["truth"]
    nearest = nearest_match_m(*poses, result.candidates, heading_rad)
    turned = case.member_apart_rad <= (np.pi if heading_rad is None else heading_rad)
    best = np.where(turned & case.answered, case.member_apart_m, np.inf)
    return Tolerance(
        radii_m,
        np.array([int((best <= radius).sum()) for radius in radii_m]),
        np.array([int((nearest <= radius).sum()) for radius in radii_m]),
    )
