"""Signatures of gateways made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fpnav.sensing.cues import CUE
from fpnav.systems.gateway.record import RECORD
from fpnav.systems.gateway.types import NAMES
from fpnav.values import Pose2, Reference, Signature

Row = tuple[float, ...]


def cue(x: float, metres: float = 3.0, direction: int = 1, top: float = 100) -> Row:
    """A cue 200 pixels tall in the view ahead."""
    return (0, direction, x, top, top + 199, 1.0, metres)


def gateway(
    kind: str,
    cues: Sequence[Row] = (),
    *,
    index: int = 0,
    at: Pose2 | None = None,
    session: int = 0,
    facings: int = 1,
    axis_rad: float = 0.0,
    label: str = "",
) -> Signature:
    """A gateway of a type, with cues, where dead reckoning has it."""
    record = np.zeros(1, RECORD)
    record["type"] = NAMES.index(kind)
    record["facings"] = facings
    record["axis_rad"] = axis_rad
    record["width_m"] = math.nan
    reference = Reference(index, index * 10**9, session=session, odometry=at, label=label)
    return Signature(reference, record[0], {"cues": np.array(list(cues), CUE)})
