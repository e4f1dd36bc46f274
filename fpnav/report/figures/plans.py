"""Floor plans: a topological map over walls or scans, and one new node in the making."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fpnav.evaluation.plan import Plan as Building
from fpnav.report.figures.style import (
    FAINT,
    INK,
    MUTED,
    PAPER,
    RIGHT,
    SERIES,
    TRUTH,
    WIDE,
    WRONG,
    Drawing,
    legend_below,
    new_figure,
)
from fpnav.values import FloatArray

_LABELLED = 80
_NEAR_M = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A map over the building it was made in.

    ``scans`` (N, 2) laser points in the world; ``path`` (R, 2); ``place_ids`` (P,); ``places``
    (P, 2); ``edges`` (E, 2) place ids; ``starts`` (S, 2) where places start; metres throughout.
    """

    building: Building | None
    scans: FloatArray
    path: FloatArray
    place_ids: NDArray[np.int64]
    places: FloatArray
    edges: NDArray[np.int64]
    starts: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NewNode:
    """A stretch of the mapping run on which a place ends and the next begins.

    ``points`` (M, 2) where the robot stood; ``scans`` (N, 2) what its laser saw; ``novelty`` (M,)
    dissimilarity to the present place; ``owner`` (M,) place of each point; ``threshold``.
    """

    points: FloatArray
    scans: FloatArray
    novelty: FloatArray
    owner: NDArray[np.int64]
    threshold: float


def topological(plan: Plan) -> Drawing:
    """The map on the architect's plan, S and E where the run starts and ends."""
    walls = np.zeros((0, 2)) if plan.building is None else plan.building.walls.reshape(-1, 2)
    figure, axis = _sized(plan.path, walls)
    if plan.building is not None:
        _building(axis, plan.building)
    _graph(axis, plan)
    _ends(axis, plan.path)
    legend_below(figure, axis, columns=5)
    return Drawing(figure, f"Floor plan with a map of {len(plan.places)} places.", True, True)


def on_scans(plan: Plan) -> Drawing:
    """The same map on all laser points of the run, put where the robot truly was."""
    figure, axis = _sized(plan.path, plan.scans)
    axis.plot(*plan.scans.T, ",", color=TRUTH, zorder=1, rasterized=True)
    _graph(axis, plan)
    _ends(axis, plan.path)
    legend_below(figure, axis, columns=4)
    return Drawing(figure, f"Scan map with {len(plan.places)} places over it.", True, True)


def new_node(made: NewNode) -> Drawing:
    """Points of a place, points of the next one, and the dissimilarity that parted them."""
    figure, axis = new_figure(WIDE, 3.6)
    axis.remove()
    left, right = figure.subplots(1, 2, width_ratios=[1.4, 1.0])
    left.plot(*made.scans.T, ".", color=RIGHT, ms=1.0, alpha=0.35, rasterized=True, zorder=1)
    for number, place in enumerate(np.unique(made.owner)):
        rows = made.owner == place
        style = {"color": INK if number == 0 else SERIES[number % len(SERIES)], "zorder": 3}
        left.plot(*made.points[rows].T, "o", ms=4.5, label=f"node {place}", **style)
        right.plot(np.flatnonzero(rows), made.novelty[rows], "o", ms=4.5, **style)
    left.set_aspect("equal", adjustable="box")
    x, y = made.points.mean(axis=0)
    left.set(xlim=(x - _NEAR_M, x + _NEAR_M), ylim=(y - _NEAR_M, y + _NEAR_M))
    left.set_xlabel("x, m")
    left.set_ylabel("y, m")
    right.plot(made.novelty, color=FAINT, lw=1.0, zorder=1)
    right.axhline(made.threshold, color=WRONG, lw=1.2, ls=(0, (5, 3)))
    right.set(ylim=(0.0, 1.0))
    right.set_xlabel("data set")
    right.set_ylabel(f"dissimilarity, \u03b8 = {made.threshold:.2f}")
    legend_below(figure, left, columns=4)
    last = float(np.nanmax(made.novelty))
    words = f"The dissimilarity reaches {last:.2f}, past {made.threshold:.2f}: a new node."
    return Drawing(figure, words, wide=True)


def _sized(*points: FloatArray) -> tuple[Figure, Axes]:
    every = np.vstack(points)
    width, height = np.maximum(np.ptp(every, axis=0), 1e-6)
    return new_figure(WIDE, float(np.clip((WIDE - 1.0) * height / width + 1.1, 3.4, 7.5)))


def _building(axis: Axes, building: Building) -> None:
    """Walls, open where doors are, and what a place may well start at."""
    walls = LineCollection(list(building.walls), colors=MUTED, linewidths=0.8, zorder=1)
    gaps = LineCollection(list(building.openings), colors=PAPER, linewidths=2.6, zorder=1.1)
    for lines in (walls, gaps):
        axis.add_collection(lines)
    if len(building.landmarks):
        x, y = building.landmarks.T
        name = "open door or listed change"
        axis.plot(x, y, "D", color=SERIES[2], ms=4, alpha=0.8, label=name, zorder=1.2)
    if len(building.closed):
        x, y = building.closed.T
        axis.plot(x, y, "x", color=WRONG, ms=6, mew=1.4, label="door closed", zorder=4)


def _graph(axis: Axes, plan: Plan) -> None:
    """Path, edges and numbered places."""
    axis.plot(*plan.path.T, color=RIGHT, lw=0.8, alpha=0.6, label="path", zorder=2)
    at = dict(zip(plan.place_ids.tolist(), plan.places, strict=True))
    lines = [np.array([at[a], at[b]]) for a, b in plan.edges.tolist()]
    axis.add_collection(LineCollection(lines, colors=INK, linewidths=1.1, zorder=3))
    if len(plan.starts):
        axis.plot(*plan.starts.T, "|", color=INK, ms=9, label="a place starts", zorder=4)
    label = f"places ({len(at)})"
    x, y = plan.places.T
    axis.scatter(x, y, s=130, color=PAPER, edgecolors=INK, lw=1.1, zorder=7, label=label)
    for place, (x0, y0) in list(at.items())[:_LABELLED]:
        axis.text(x0, y0, str(place), ha="center", va="center_baseline", fontsize=6.5, zorder=8)


def _ends(axis: Axes, path: FloatArray) -> None:
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("x, m")
    axis.set_ylabel("y, m")
    for (x, y), name in ((path[0], "S"), (path[-1], "E")):
        axis.text(x, y, name, color=WRONG, fontsize=12, fontweight="bold", zorder=9)
