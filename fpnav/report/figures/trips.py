"""Ways that a policy drove: home to a goal, or along a route."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from fpnav.evaluation.guidance import HOME_M, ends_home, trips
from fpnav.report.figures.style import (
    INK,
    MUTED,
    RIGHT,
    TRUTH,
    WRONG,
    Drawing,
    legend_below,
    new_figure,
)
from fpnav.values import FloatArray


def draw_home(actions: NDArray[Any], goal: FloatArray, places: FloatArray) -> Drawing:
    """Trips to a goal (2,), those that failed in another colour; ``places`` (P, 3) poses."""
    figure, axis = new_figure(height=5.4)
    home = ends_home(actions, goal)
    for trip, right in zip(trips(actions), home.tolist(), strict=True):
        x, y = trip["truth"][:, 0], trip["truth"][:, 1]
        colour = RIGHT if right else WRONG
        axis.plot(x, y, color=colour, lw=0.9, alpha=0.8)
        axis.plot(x[:1], y[:1], "o", color=colour, ms=3.5)
        axis.plot(x[-1:], y[-1:], "x", color=colour, ms=5)
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    ring = goal + HOME_M * np.column_stack([np.cos(angle), np.sin(angle)])
    axis.plot(ring[:, 0], ring[:, 1], color=INK, lw=1.0, ls="--", label=f"{HOME_M} m of the goal")
    _places(axis, places)
    _plan(axis)
    legend_below(figure, axis)
    return Drawing(figure, f"Ways of {len(home)} trips to a goal: {int(home.sum())} end at it.")


def draw_way(actions: NDArray[Any], way: FloatArray, places: FloatArray) -> Drawing:
    """Trips along a way (n, 2)."""
    figure, axis = new_figure(height=4.6)
    axis.plot(way[:, 0], way[:, 1], color=TRUTH, lw=4.0, label="taught")
    driven = trips(actions)
    for number, trip in enumerate(driven):
        label = "driven" if number == 0 else None
        axis.plot(trip["truth"][:, 0], trip["truth"][:, 1], color=RIGHT, lw=1.2, label=label)
        axis.plot(trip["truth"][-1:, 0], trip["truth"][-1:, 1], "x", color=RIGHT, ms=6)
    _places(axis, places)
    _plan(axis)
    legend_below(figure, axis)
    return Drawing(figure, f"A way of {len(way)} decimetres as taught and as driven.")


def _places(axis: Axes, places: FloatArray) -> None:
    axis.plot(places[:, 0], places[:, 1], "^", color=MUTED, ms=5, label="places", zorder=1)


def _plan(axis: Axes) -> None:
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x, m")
    axis.set_ylabel("y, m")
