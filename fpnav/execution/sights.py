"""What single frames of logs showed, made small, to be looked at beside what was said of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.logs.frames import open_log
from fpnav.values import FloatArray, Frame

_IMAGE_ROLES = ("panorama", "omni", "camera")
_WIDEST_PX, _HIGHEST_PX = 420, 160
_MOST_POINTS = 360


class FrameKey(NamedTuple):
    """A frame of any log: the log's digest, the roles its frames stand on, which of them it is."""

    sha256: str
    frames_on: tuple[str, ...]
    frame: int


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """What a frame showed; empty arrays where it showed nothing.

    ``pixels`` (H, W, 3) uint8 RGB, at most 420 x 160, ``role`` says of which camera; ``points_m``
    (N, 2) hits of laser or sonar in the robot's frame, at most 360.
    """

    pixels: NDArray[np.uint8]
    role: str
    points_m: FloatArray


def sights_of(logs: Sequence[Path], keys: Collection[FrameKey]) -> dict[FrameKey, Sight]:
    """What the wanted frames showed, as far as the logs hold them.

    Raises
    ------
    UsageError
        None of the frames is of one of the logs: it is another log, or has been changed.
    """
    found: dict[FrameKey, Sight] = {}
    for path in logs:
        bases = sorted({key.frames_on for key in keys}) or [()]
        of_log = [sight for base in bases for sight in _sights(path, base, keys)]
        if keys and not of_log:
            raise UsageError(
                f"{path}: no result was made from this log as it is now; expected one of the logs "
                "that the report names under 'Where it comes from' (same sha256)"
            )
        found |= dict(of_log)
    return found


def _sights(
    path: Path, frames_on: tuple[str, ...], keys: Collection[FrameKey]
) -> list[tuple[FrameKey, Sight]]:
    with open_log(path, max_loss=1.0, allow_truncated=True, frames_on=frames_on) as log:
        wanted = sorted(key.frame for key in keys if key[:2] == (log.sha256, frames_on))
        return [
            (FrameKey(log.sha256, frames_on, frame.reference.index), sight(frame))
            for frame in (log.at(wanted) if wanted else ())
        ]


def sight(frame: Frame) -> Sight:
    """A frame's image and hits, made small."""
    role = next((role for role in _IMAGE_ROLES if role in frame.payloads), "")
    image: Any = frame.get(role) if role else None
    pixels = np.zeros((0, 0, 3), np.uint8) if image is None else _small(image.pixels)
    points = _hits(frame)
    every = max(1, -(-len(points) // _MOST_POINTS))
    return Sight(pixels, role, points[::every])


def _hits(frame: Frame) -> FloatArray:
    """What laser or, without one, sonar met, (N, 2) in the robot's frame."""
    if frame.scan is not None:
        return frame.scan.points_m()
    if frame.sonar is None:
        return np.zeros((0, 2))
    ring = frame.sonar
    ranges = ring.ranges_m.astype(np.float64)
    with np.errstate(invalid="ignore"):
        met = (ranges >= ring.range_min_m) & (ranges <= ring.range_max_m)
    x, y, heading = ring.mounts[met].T
    return np.column_stack([x + ranges[met] * np.cos(heading), y + ranges[met] * np.sin(heading)])


def _small(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width = pixels.shape[:2]
    scale = min(1.0, _WIDEST_PX / width, _HIGHEST_PX / height)
    size = max(1, round(width * scale)), max(1, round(height * scale))
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_BGR2RGB), np.uint8)
