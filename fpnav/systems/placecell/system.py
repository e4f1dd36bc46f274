"""Visual place cells (Giovannangeli, Gaussier, Desilles): the system as the pipeline sees it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Params
from fpnav.systems.base import (
    BY_PLACES,
    Features,
    MapRule,
    Needs,
    Picture,
    Thinning,
    no_verification,
    spread_likelihood,
)
from fpnav.systems.placecell.assembly import PIXEL, RECORD, signatures
from fpnav.systems.placecell.extract import CAMERA_ROLES, VIEW, features_of_frame
from fpnav.systems.placecell.memory import PlacecellMemory
from fpnav.systems.placecell.params import LATE, PRESETS, PlacecellParams
from fpnav.values import FloatArray, Frame, Reference, Signature


class Placecell:
    """Constellations of local views with their directions, recognised by place cells."""

    NAME: ClassVar[str] = "placecell"
    SUMMARY: ClassVar[str] = "visual place cells: local views by direction (Giovannangeli et al.)"
    NEEDS: ClassVar[Needs] = Needs((*CAMERA_ROLES, "pan"), (CAMERA_ROLES,))
    PARAMS: ClassVar[type[Params]] = PlacecellParams
    LATE: ClassVar[frozenset[str]] = LATE
    PRESETS: ClassVar[Mapping[str, Params]] = PRESETS
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"views": VIEW, "pixels": PIXEL}
    POLICY: ClassVar[str] = BY_PLACES

    verify = no_verification
    likelihood = spread_likelihood

    def __init__(self, params: PlacecellParams) -> None:
        self._params = params

    @property
    def params(self) -> PlacecellParams:
        """The parameter block."""
        return self._params

    @property
    def rule(self) -> MapRule:
        """New place where the present one's activity falls below the vigilance."""
        params = self._params
        threshold = 0.5 if params.spacing_m > 0.0 else 1.0 - params.vigilance
        return MapRule(threshold, min_observations=1, budget=params.budget)

    @property
    def thinning(self) -> Thinning:
        """Every frame, unless the parameters say otherwise."""
        return Thinning(self._params.step_m, math.radians(self._params.step_heading_deg))

    def describe(self, frame: Frame) -> Features:
        """Local views of one frame."""
        return features_of_frame(frame, self._params)

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """One constellation per panorama."""
        return signatures(stream, self._params)

    def memory(self) -> PlacecellMemory:
        """A new, empty memory."""
        return PlacecellMemory(self._params)

    def similarity(self, first: Signature, second: Signature) -> float:
        """Mean activity of a cell learned at either when the robot is at the other."""
        if all(np.array_equal(first.parts[name], second.parts[name]) for name in self.PARTS):
            return 1.0
        return 0.5 * (self._activity(first, second) + self._activity(second, first))

    def picture(self, signature: Signature) -> Picture:
        """A grid: the local views side by side, by bearing from the left edge of a panorama."""
        views = signature.parts["views"]
        order = np.argsort(-views["bearing_rad"], kind="stable")
        shape = (-1, self._params.patch_rows, self._params.patch_columns)
        pixels = signature.parts["pixels"].reshape(shape)[order]
        return Picture(
            "grid",
            views["bearing_rad"][order].astype(np.float64),
            views["strength"][order].astype(np.float64),
            values=_side_by_side(pixels),
            text=f"{len(views)} views",
        )

    def _activity(self, learned: Signature, seen: Signature) -> float:
        memory = self.memory()
        memory.learn(0, learned)
        recall, _ = memory.recall([seen], 1, None, None)
        return float(recall.scores[0, 0])


def _side_by_side(pixels: NDArray[np.uint8]) -> FloatArray:
    if len(pixels) == 0:
        return np.zeros((1, 1))
    return np.hstack(list(pixels)).astype(np.float64) / 255.0
