"""From described frames to signatures: panoramas, and sweeps of a panning camera joined."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

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
    counts = np.array([len(features["views"]) for _, features in images])
    turns = np.array([_turn(reference, newest) for reference, _ in images], np.float32)
    views = np.zeros(counts.sum(), VIEW)
    for end, count, (_, features) in zip(np.cumsum(counts), counts, images, strict=True):
        views[end - count : end] = features["views"]
    views["image"] = np.repeat(np.arange(len(images))[::-1], counts)
    views["bearing_rad"] = wrap_array(views["bearing_rad"] - np.repeat(turns, counts))
    pixels = np.concatenate([np.zeros(0, PIXEL), *(features["pixels"] for _, features in images)])
    record = np.array([(len(views), len(images))], RECORD)[0]
    return Signature(newest, record, {"views": views, "pixels": pixels})


def _turn(first: Reference, second: Reference) -> float:
    """Turn of the robot between two frames of a session; 0 where nothing tells."""
    turn = second.heading_rad - first.heading_rad
    if first.odometry is not None and second.odometry is not None:
        turn = second.odometry.heading_rad - first.odometry.heading_rad
    return turn if math.isfinite(turn) else 0.0
