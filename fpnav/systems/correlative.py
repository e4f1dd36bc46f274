"""Correlative scan matching of the best candidates of two cheap signatures.

E. Olson: Real-time correlative scan matching, ICRA 2009: every turn and translation in a window is
scored by the likelihood of one scan's points in the other's blurred map. Candidates come from the
polar signature and the corner-pair histogram, their cosines in units of their spread summed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU, wrap
from fpnav.matching.grids import cosines, quantised
from fpnav.matching.sweeps import Sweep, correlated, turns_between
from fpnav.params import Count, Params, Positive
from fpnav.sensing.polar import pair_histogram, polar_grid
from fpnav.systems.base import Features, State, Verification
from fpnav.systems.lasers import (
    LASER_LATE,
    Grids,
    LaserParams,
    LaserSystem,
    corner_points,
    mount_of,
    sweep_of,
)
from fpnav.values import FloatArray, Pose2, RelativePose, Signature

PAIR_BINS, PAIR_STEPS, PAIR_M = 30, 30, 10.0
POLAR_BINS, POLAR_RINGS = 90, 16
SPREADS = (0.13, 0.12)
"""Spread of the polar and of the pair cosine over the candidates of a query (intel,
freiburg-079)."""


class CorrelativeParams(LaserParams, frozen=True):
    """``checked`` candidates laid over the query; ``reach_m``, ``grid_m`` and ``grid_deg`` of the
    window that is searched."""

    checked: Count = 20
    reach_m: Positive = 2.0
    grid_m: Positive = 0.1
    grid_deg: Positive = 3.0


class Correlative(LaserSystem):
    """Two cheap signatures, re-ranked by scan matching."""

    NAME: ClassVar[str] = "correlative"
    SUMMARY: ClassVar[str] = "polar and corner-pair signatures re-ranked by scan matching (Olson)"
    PARAMS: ClassVar[type[Params]] = CorrelativeParams
    LATE: ClassVar[frozenset[str]] = LASER_LATE | {"checked", "reach_m", "grid_m", "grid_deg"}
    PRESETS: ClassVar[Mapping[str, Params]] = {
        "paper": CorrelativeParams(),
        "default": CorrelativeParams(),
    }

    def grid(self, signature: Signature) -> FloatArray:
        """Hits by bearing and range."""
        sweep = sweep_of(signature.parts["rays"])
        points = np.column_stack([axis[sweep.hits] for axis in sweep.points])
        return polar_grid(points, POLAR_BINS, POLAR_RINGS)

    def descriptor(self, signature: Signature, model: State) -> Features:
        """The polar grid and the pair histogram."""
        pairs = pair_histogram(corner_points(signature), PAIR_BINS, PAIR_STEPS, PAIR_M)
        found = dict(super().descriptor(signature, model))
        found["pairs"] = quantised(pairs).astype(np.uint8)[None][: len(found["grid"])]
        return found

    def stack(self, descriptors: Sequence[Features]) -> Any:
        """Both as grids."""
        second = [
            {
                "grid": one["pairs"],
                "cover": np.ones((len(one["pairs"]), PAIR_BINS), bool),
                "closed": one["closed"],
            }
            for one in descriptors
        ]
        return super().stack(descriptors), super().stack(second)

    def compare(
        self, query: Features, members: Any, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        """Sum of both cosines in units of their spread; the turn is the polar one."""
        polar, pairs = members
        first, turns = super().compare(query, polar, rows, model)
        second = self._pairs(query, pairs, rows)
        return first / SPREADS[0] + second / SPREADS[1], turns

    def likeness(self, first: Features, second: Features, model: State) -> float:
        """Cosine of the polar grids."""
        if len(first["grid"]) != len(second["grid"]):
            return 0.0
        if not len(first["grid"]) or np.array_equal(first["grid"], second["grid"]):
            return 1.0
        polar, row = self.stack([second])[0], np.zeros(1, np.int64)
        return float(np.clip(super().compare(first, polar, row, model)[0][0], 0.0, 1.0))

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification | None:
        """Mean likelihood of the best overlay of the first ``checked``; the others come after, in
        their order."""
        mine = sweep_of(query.parts["rays"])
        scores = -1.0 - np.arange(len(candidates)) / max(len(candidates), 1)
        relative: list[RelativePose | None] = [None] * len(candidates)
        for at, candidate in enumerate(candidates[: self._params.checked]):
            other = sweep_of(candidate.parts["rays"])
            if len(mine.hits) and len(other.hits):
                scores[at], pose = self._laid(mine, other)
                relative[at] = _relative(pose, mount_of(query), mount_of(candidate))
        return Verification(scores, tuple(relative))

    def _laid(self, mine: Sweep, other: Sweep) -> tuple[float, FloatArray]:
        p = self._params
        turns = turns_between(
            mine, other, float(np.deg2rad(p.turn_deg)), float(np.deg2rad(p.grid_deg))
        )
        return correlated(mine, other, turns, p.reach_m, p.grid_m)

    def _pairs(self, query: Features, members: Grids, rows: NDArray[np.int64]) -> FloatArray:
        if not len(query["pairs"]):
            return np.zeros(len(rows))
        closed = bool(query["closed"][0] and members.closed[rows].all())
        everywhere = np.ones(PAIR_BINS, bool)
        shifts = self._shifts(PAIR_BINS, closed=closed)
        histogram = query["pairs"][0].astype(np.int32)
        return cosines(histogram, everywhere, members.values, members.covers, rows, shifts)[0]


def _relative(pose: FloatArray, query_m: FloatArray, other_m: FloatArray) -> RelativePose:
    """The query's robot from the candidate's robot; as certain as the grid is fine."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    back = np.array([[c, s], [-s, c]])
    x, y = back @ (-query_m - pose[:2]) + other_m
    variance = np.diag([0.05**2, 0.05**2, (TAU / 240.0) ** 2])
    where = Pose2(float(x), float(y), wrap(-float(pose[2])))
    return RelativePose(where, tuple(variance.ravel().tolist()))
