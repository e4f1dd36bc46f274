"""One query beside its answer: what the cameras saw, and the scans over each other."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fpnav.execution.sights import Sight
from fpnav.report.figures.style import INK, MUTED, RIGHT, WITHHELD, WRONG

_COLORS = {"right": RIGHT, "wrong": WRONG}
_HEIGHT, _IMAGES, _SCAN = 1.5, 2.6, 1.5
_STACKED = 1.8
"""Images wider than this times their height stand above each other, others side by side."""


def draw_match(
    asked: Sight | None,
    answer: Sight | None,
    apart: tuple[float, float, float],
    outcome: str,
) -> tuple[Figure, str]:
    """The picture, and what it shows in words.

    ``apart`` : pose of the query as seen from the answer, metres and radians; where the heading is
    NaN the scans stand as they are. The query is drawn in the colour of its outcome, the answer in
    grey; an answer's panorama is turned to the query's heading.
    """
    both = [sight for sight in (asked, answer) if sight is not None]
    images = any(sight.pixels.size for sight in both)
    scans = any(len(sight.points_m) for sight in both)
    widths = [_IMAGES] * images + [_SCAN] * scans
    figure = Figure(figsize=(sum(widths) or _SCAN, _HEIGHT), layout="constrained")
    columns = figure.add_gridspec(1, max(1, len(widths)), width_ratios=widths or [1.0])
    said = []
    if images:
        wide = max(_aspect(sight) for sight in both) > _STACKED
        cells = columns[0].subgridspec(*((2, 1) if wide else (1, 2)))
        _image(figure.add_subplot(cells[0]), asked, 0.0, "query")
        _image(figure.add_subplot(cells[1]), answer, apart[2], "answer")
        said.append(f"image of the query {'above' if wide else 'left of'} that of the answer")
    if scans:
        _scans(figure.add_subplot(columns[-1]), asked, answer, apart, outcome)
        said.append("scan of the query over that of the answer")
    return figure, " and ".join(said) or "the log holds nothing to look at here"


def _aspect(sight: Sight) -> float:
    height, width = sight.pixels.shape[:2]
    return width / height if height else 0.0


def _image(axis: Axes, sight: Sight | None, turn_rad: float, name: str) -> None:
    axis.set_axis_off()
    if sight is None or not sight.pixels.size:
        axis.text(0.5, 0.5, f"{name}: no image at hand", ha="center", va="center", fontsize=7,
                  color=MUTED, transform=axis.transAxes)  # fmt: skip
        return
    axis.imshow(_turned(sight, turn_rad), interpolation="bilinear", aspect="equal")


def _turned(sight: Sight, turn_rad: float) -> NDArray[np.uint8]:
    """A panorama as it would be seen after a turn (column x at bearing pi - 2 pi (x + 0.5) / W)."""
    if sight.role != "panorama" or not math.isfinite(turn_rad):
        return sight.pixels
    columns = round(turn_rad / (2 * np.pi) * sight.pixels.shape[1])
    return np.roll(sight.pixels, columns, axis=1)


def _scans(
    axis: Axes,
    asked: Sight | None,
    answer: Sight | None,
    apart: tuple[float, float, float],
    outcome: str,
) -> None:
    x, y, heading = apart
    turn = heading if math.isfinite(heading) else 0.0
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    color = _COLORS.get(outcome, INK)
    if answer is not None:
        axis.plot(*_up(answer.points_m), ".", color=WITHHELD, ms=2.6)
        axis.plot(0.0, 0.0, "^", color=WITHHELD, ms=4)
    if asked is not None:
        axis.plot(*_up(asked.points_m @ rotation.T + [x, y]), ".", color=color, ms=1.4)
        axis.plot(-y, x, "o", color=color, ms=2.5)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_axis_off()


def _up(points_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points with ahead upwards on the page."""
    return -points_m[:, 1], points_m[:, 0]
