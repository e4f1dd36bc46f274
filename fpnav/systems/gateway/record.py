"""What a signature of a gateway holds beside its cues."""

from __future__ import annotations

import numpy as np

from fpnav.sensing.passages import Passage
from fpnav.values import Pose2

RECORD = np.dtype(
    [
        ("type", "u1"),
        ("facings", "u1"),
        ("x_m", "<f8"),
        ("y_m", "<f8"),
        ("axis_rad", "<f8"),
        ("width_m", "<f8"),
        ("wall_left_m", "<f8"),
        ("wall_right_m", "<f8"),
    ]
)
"""Type of the gateway (0 none); bit f set where a camera looked in direction f; the gateway's
centre and the direction of its walls as seen from the robot; its width and the distances of the
walls, NaN where not known."""


def record_of(code: int, facings: int, passage: Passage | None, centre: Pose2) -> np.void:
    """Record of a signature; ``centre`` in the robot's frame, its origin where there is none."""
    found = (np.nan,) * 3
    if passage is not None:
        found = passage.width_m, passage.wall_left_m, passage.wall_right_m
    place = centre.x_m, centre.y_m, centre.heading_rad
    value: np.void = np.array([(code, facings, *place, *found)], RECORD)[0]
    return value
