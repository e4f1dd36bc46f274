"""Gateways and scenes (Kortenkamp, Weymouth): the system as the pipeline sees it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np

from fpnav.params import Params
from fpnav.sensing.cues import CUE
from fpnav.sensing.scene import CELLS, cells_of
from fpnav.systems.base import (
    BY_WALLS,
    Features,
    MapRule,
    Needs,
    Picture,
    Thinning,
    no_verification,
)
from fpnav.systems.gateway.evidence import likeness
from fpnav.systems.gateway.look import features_of_frame
from fpnav.systems.gateway.memory import GatewayMemory
from fpnav.systems.gateway.params import LATE, PRESETS, GatewayParams
from fpnav.systems.gateway.record import RECORD
from fpnav.systems.gateway.replay import signatures_of
from fpnav.systems.gateway.types import NAMES
from fpnav.values import FloatArray, Frame, Reference, Signature

NOVEL = 0.5
LEAST = 1e-4
"""Likelihood of the impossible against that of the best."""


class Gateway:
    """Openings found by sonar, told apart by the vertical edges seen from them."""

    NAME: ClassVar[str] = "gateway"
    SUMMARY: ClassVar[str] = "sonar gateways and scenes of vertical edges (Kortenkamp, Weymouth)"
    NEEDS: ClassVar[Needs] = Needs(
        uses=("camera", "camera_offset", "scan", "sonar", "pan"),
        must=(("sonar", "scan", "camera"),),
        frames_on=("sonar", "scan", "camera"),
    )
    PARAMS: ClassVar[type[Params]] = GatewayParams
    LATE: ClassVar[frozenset[str]] = LATE
    PRESETS: ClassVar[Mapping[str, Params]] = PRESETS
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"cues": CUE}
    POLICY: ClassVar[str] = BY_WALLS

    verify = no_verification

    def __init__(self, params: GatewayParams) -> None:
        self._params = params

    @property
    def params(self) -> GatewayParams:
        """The parameter block."""
        return self._params

    @property
    def rule(self) -> MapRule:
        """Every gateway is a place; a lap is a sequence of them that comes again."""
        return MapRule(NOVEL, min_observations=1, sequences=True)

    @property
    def thinning(self) -> Thinning:
        """A reading every step of travel or turn."""
        return Thinning(self._params.step_m, float(np.deg2rad(self._params.step_heading_deg)))

    def describe(self, frame: Frame) -> Features:
        """Ranges to the sides and ahead, and the cues of the view where it may be a gateway."""
        return features_of_frame(frame, self._params)

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """A scene at every gateway; without ranges one every so much travel."""
        return signatures_of(stream, self._params)

    def memory(self) -> GatewayMemory:
        """A new, empty memory."""
        return GatewayMemory(self._params)

    def similarity(self, first: Signature, second: Signature) -> float:
        """Likeness of scenes and types."""
        return likeness(first, second, self._params)

    def likelihood(self, scores: FloatArray) -> FloatArray:
        """Scores are logarithms of likelihoods."""
        scores = np.asarray(scores, dtype=np.float64)
        finite = np.isfinite(scores)
        best = np.where(finite, scores, -np.inf).max(axis=-1, keepdims=True, initial=-np.inf)
        top = np.where(np.isfinite(best), best, 0.0)
        values = np.where(finite, np.exp(np.where(finite, scores, 0.0) - top), 0.0)
        flat = np.where(np.isfinite(best), values, 1.0)
        return np.asarray(np.maximum(flat, LEAST), dtype=np.float64)

    def picture(self, signature: Signature) -> Picture:
        """The 5 x 5 grid: how many cues lie in each cell of the view ahead."""
        cues = signature.parts["cues"]
        ahead = cues[cues["facing"] == 0] if np.any(cues["facing"] == 0) else cues
        bits = cells_of(ahead)[:, None] >> np.arange(CELLS * CELLS) & 1
        grid = bits.sum(axis=0).reshape(CELLS, CELLS).astype(np.float64)
        name = NAMES[int(signature.record["type"])]
        return Picture("grid", np.zeros(0), np.zeros(0), values=grid, text=name or "SCENE")
