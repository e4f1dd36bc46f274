"""From described frames to signatures: panoramas, and sweeps of a panning camera joined."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap_array
from fpnav.systems.base import Features
from fpnav.systems.placecell.extract import VIEW
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import Reference, Signature

RECORD = np.dtype([("views", "<i4"), ("images", "<i4")])
"""Number of local views, and of images they were found in."""

PIXEL = np.dtype(np.uint8)

Image = tuple[Reference, Features]


def signatures(stream: Iterable[Image], params: PlacecellParams) -> Iterator[Signature]:
    """One signature per panorama.

    ``images`` consecutive images taken by a panning camera are a panorama; where images stream,
    every image completes one with those before it. Images of other cameras stand alone.
    """
    sweep: deque[Image] = deque(maxlen=params.images)
    for reference, features in stream:
        if params.images == 1 or not bool(features["panned"][0]):
            yield joined([(reference, features)])
            continue
        if sweep and sweep[-1][0].session != reference.session:
            sweep.clear()
        sweep.append((reference, features))
        if len(sweep) == params.images:
            yield joined(tuple(sweep))
            if not params.streaming:
                sweep.clear()


def joined(images: Sequence[Image]) -> Signature:
    """The images, in order, as one panorama in the robot's frame at the last of them."""
    newest = images[-1][0]
    rows = [
        _seen_from(newest, reference, features["views"], len(images) - 1 - number)
        for number, (reference, features) in enumerate(images)
    ]
    views = np.concatenate([np.zeros(0, VIEW), *rows])
    pixels = np.concatenate([np.zeros(0, PIXEL), *(features["pixels"] for _, features in images)])
    record = np.array([(len(views), len(images))], RECORD)[0]
    return Signature(newest, record, {"views": views, "pixels": pixels})


def _seen_from(
    newest: Reference, reference: Reference, views: NDArray[Any], back: int
) -> NDArray[Any]:
    """Views of an earlier image with their bearings from the robot's present heading."""
    rows = views.copy()
    rows["image"] = back
    turn = _turn(reference, newest)
    rows["bearing_rad"] = wrap_array(rows["bearing_rad"] - turn)
    return rows


def _turn(first: Reference, second: Reference) -> float:
    """Turn of the robot between two frames of a session; 0 where nothing tells."""
    turn = second.heading_rad - first.heading_rad
    if first.odometry is not None and second.odometry is not None:
        turn = second.odometry.heading_rad - first.odometry.heading_rad
    return turn if math.isfinite(turn) else 0.0
