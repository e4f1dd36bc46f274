"""How a fingerprint comes about, as in figure 1 of Tapus et al."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.gridspec import GridSpec
from numpy.typing import NDArray

from fpnav.report.figures.style import INK, MUTED, RIGHT, WIDE, WRONG, Drawing, new_figure
from fpnav.values import FloatArray

ROWS = ("colours", "edges", "corners", "f and n")


@dataclass(frozen=True, slots=True, eq=False)
class Generation:
    """One data set and what was made of it.

    ``image`` (H, W, 3) RGB, column x at bearing pi - 2 pi (x + 0.5) / W; ``points`` (N, 2) laser
    points in the robot's frame, metres; ``bearings_rad`` (S,), ``letters`` S, ``certainty`` (S,)
    of the symbols; ``corners`` (C, 2) in the robot's frame.
    """

    image: NDArray[np.uint8]
    points: FloatArray
    corners: FloatArray
    bearings_rad: FloatArray
    letters: str
    certainty: FloatArray


def generation(made: Generation) -> Drawing:
    """Panorama, scan, the symbols by kind over the bearing, and the string."""
    figure, axis = new_figure(WIDE, 5.6)
    axis.remove()
    grid = GridSpec(2, 2, figure=figure, width_ratios=[2.4, 1.0], height_ratios=[1.0, 1.0])
    _panorama(figure.add_subplot(grid[0, 0]), made)
    _scan(figure.add_subplot(grid[:, 1]), made)
    _rows(figure.add_subplot(grid[1, 0]), made)
    return Drawing(figure, f"A fingerprint in the making; it reads {made.letters}.", wide=True)


def _panorama(axis: Axes, made: Generation) -> None:
    axis.imshow(made.image, extent=(180.0, -180.0, 0.0, 90.0), aspect="auto")
    for bearing, letter in zip(np.rad2deg(made.bearings_rad), made.letters, strict=True):
        if letter == "v":
            axis.axvline(_half(bearing), color="#ffe000", lw=0.9)
        elif letter.isupper():
            axis.text(_half(bearing), 82, letter, color="#ffffff", ha="center", va="center",
                      fontsize=9, fontweight="bold",
                      bbox={"facecolor": INK, "alpha": 0.75, "lw": 0, "pad": 1.2})  # fmt: skip
    axis.set_yticks([])
    axis.set_xlabel("bearing, \u00b0 (0 is ahead)")
    axis.set_title("(a) panorama with edges v and colour patches", loc="left")
    axis.grid(False)


def _scan(axis: Axes, made: Generation) -> None:
    axis.plot(-made.points[:, 1], made.points[:, 0], ".", color=RIGHT, ms=1.6)
    axis.plot(-made.corners[:, 1], made.corners[:, 0], "o", mfc="none", mec=WRONG, ms=7, mew=1.3)
    axis.plot(0, 0, "^", color=INK, ms=7)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("m")
    axis.set_title("(b) scan with corners c", loc="left")


def _rows(axis: Axes, made: Generation) -> None:
    """Symbols by kind; the higher a letter stands out, the more certain it is."""
    for bearing, letter, sure in zip(
        np.rad2deg(made.bearings_rad), made.letters, made.certainty, strict=True
    ):
        row = _row(letter)
        color = MUTED if letter == "n" else INK
        axis.text(_half(bearing), row, letter, ha="center", va="center", fontsize=8.5,
                  color=color, alpha=0.35 + 0.65 * float(sure))  # fmt: skip
    axis.set(xlim=(180.0, -180.0), ylim=(len(ROWS) - 0.5, -0.5))
    axis.set_yticks(range(len(ROWS)), ROWS)
    axis.set_xlabel("bearing, \u00b0")
    half = len(made.letters) // 2
    axis.set_title(f"(c) {made.letters[:half]}\n{made.letters[half:]}", loc="left",
                   family="monospace", fontsize=8.5)  # fmt: skip


def _half(degrees: float) -> float:
    """In -180 .. 180."""
    return (degrees + 180.0) % 360.0 - 180.0


def _row(letter: str) -> int:
    kinds: Mapping[str, Any] = {"v": 1, "c": 2, "f": 3, "n": 3}
    return int(kinds.get(letter, 0))
