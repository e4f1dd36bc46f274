"""What is known of one place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.scene import CELLS, FACINGS, cells_of
from fpnav.systems.gateway import asr
from fpnav.systems.gateway.asr import Asr
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.types import KINDS, NONE
from fpnav.values import Signature

SHOWN = (FACINGS, 2, CELLS * CELLS)
"""Shape of a table by direction looked in, direction of transition, and cell."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceModel:
    """One place.

    ``scene`` : its abstracted scene representation
    ``types`` (26,) : how often it was classified as each type
    ``shown`` SHOWN : visits in which a cell held an edge
    ``axis_rad`` : direction of its walls as its first observation saw them
    """

    scene: Asr
    types: NDArray[np.int64]
    shown: NDArray[np.int64]
    axis_rad: float

    @property
    def type(self) -> int:
        """Type it was classified as most often, the first of equals; 0 where it never was."""
        return int(np.argmax(self.types)) if self.types.any() else NONE


def observed(model: PlaceModel | None, signature: Signature, params: GatewayParams) -> PlaceModel:
    """The place after one more visit; a new one where there is none yet."""
    code, facings = int(signature.record["type"]), int(signature.record["facings"])
    if model is None:
        axis = float(signature.record["axis_rad"])
        none = np.zeros(len(KINDS) + 1, np.int64)
        model = PlaceModel(asr.EMPTY, none, np.zeros(SHOWN, np.int64), axis)
    types = model.types.copy()
    types[code] += int(code != NONE)
    cues = signature.parts["cues"]
    scene = asr.visited(model.scene, cues, facings, params)
    return PlaceModel(scene, types, model.shown + shown(cues), model.axis_rad)


def shown(cues: NDArray[np.void]) -> NDArray[np.int64]:
    """Which cells hold an edge of each direction of transition, SHOWN of 0 and 1."""
    table = np.zeros(SHOWN, np.int64)
    bits = cells_of(cues)[:, None] >> np.arange(CELLS * CELLS) & 1
    rows, cells = np.nonzero(bits)
    table[cues["facing"][rows], (cues["direction"][rows] > 0).astype(int), cells] = 1
    return table
