"""Small place-cell signatures made by hand: views with their bearings, no image needed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.systems.placecell.assembly import RECORD
from fpnav.systems.placecell.extract import VIEW
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import Pose2, Reference, Signature

PARAMS = PlacecellParams(
    patch_rows=4,
    patch_columns=4,
    interpretations=4,
    rho_az=0.33,
    heading="compass",
    stm="counter",
    qmax=0,
)
"""Views of 16 pixels, linear diffusion, compass."""


def view(number: int) -> NDArray[np.uint8]:
    """Local view number ``number``: unlike every other."""
    return np.random.default_rng(number).integers(0, 256, 16).astype(np.uint8)


def constellation(
    views: dict[int, float],
    *,
    heading: float = math.nan,
    odometry: float = math.nan,
    index: int = 0,
    session: int = 0,
    travelled: float = math.nan,
    elevation: Sequence[float] = (),
    image: Sequence[int] = (),
) -> Signature:
    """Signature of the numbered views at the given bearings in degrees."""
    rows = np.zeros(len(views), VIEW)
    rows["bearing_rad"] = np.radians(list(views.values()))
    rows["elevation_rad"] = np.radians(elevation) if len(elevation) else 0.0
    rows["image"] = image if len(image) else 0
    rows["strength"] = 1.0
    pixels = [np.zeros(0, np.uint8), *(view(number) for number in views)]
    pose = None if math.isnan(odometry) else Pose2(0.0, 0.0, math.radians(odometry))
    reference = Reference(
        index,
        index * 10**9,
        session=session,
        travelled_m=travelled,
        odometry=pose,
        heading_rad=math.radians(heading),
    )
    record = np.array([(len(rows), 1)], RECORD)[0]
    return Signature(reference, record, {"views": rows, "pixels": np.concatenate(pixels)})


def scenery(seed: int, height: int = 120, width: int = 720) -> NDArray[Any]:
    """A panorama (height, width, 3) of soft blobs that joins at its edges."""
    rng = np.random.default_rng(seed)
    image = np.full((height, 3 * width), 90.0, np.float32)
    for _ in range(60):
        x, y = rng.integers(0, width), rng.integers(0, height)
        radius, level = rng.uniform(4, 14), float(rng.uniform(0, 255))
        for turn in range(3):
            cv2.circle(image, (int(x + turn * width), int(y)), int(radius), level, -1)
    soft = cv2.GaussianBlur(image, (0, 0), 1.5)[:, width : 2 * width]
    return np.repeat(np.round(soft).astype(np.uint8)[:, :, None], 3, axis=2)
