"""Gateways and the places they are, as Kortenkamp and Weymouth show them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from fpnav.evaluation.gateways import HEADING_RAD, POSITION_M, Survey
from fpnav.report.figures.style import (
    INK,
    MUTED,
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


def plan(world: Mapping[str, Any], routes: Sequence[tuple[str, Survey]]) -> Drawing:
    """Walls of a building, routes, and the gateways found on them."""
    figure, axis = new_figure(WIDE, 5.2)
    for x0, y0, x1, y1 in world["walls"]:
        axis.plot([x0, x1], [y0, y1], color=INK, lw=1.4, solid_capstyle="projecting")
    for number, (name, survey) in enumerate(routes):
        color = SERIES[number]
        points = np.array(world["routes"][name]["points"]) + 0.12 * (number - 1)
        axis.plot(points[:, 0], points[:, 1], color=color, lw=1.0, alpha=0.8, label=name)
        axis.plot(*points[0], "o", color=color, ms=7)
        poses = survey.found.poses
        x, y = poses[:, 0], poses[:, 1]
        axis.quiver(x, y, np.cos(poses[:, 2]), np.sin(poses[:, 2]), color=color,
                    scale=45, width=0.0028, zorder=3)  # fmt: skip
    _name_gateways(axis, routes)
    axis.set_aspect("equal")
    axis.grid(visible=False)
    axis.set(xlabel="x, m", ylabel="y, m")
    legend_below(figure, axis)
    found = sum(len(survey.found) for _, survey in routes)
    return Drawing(figure, f"Plan of the hallways with {found} gateways found on {len(routes)} "
                   "routes.", wide=True)  # fmt: skip


def _name_gateways(axis: Any, routes: Sequence[tuple[str, Survey]]) -> None:
    """Each name once, beside the gateway."""
    named: set[str] = set()
    for _, survey in routes:
        for pose, name in zip(survey.truth.poses, survey.truth.names, strict=True):
            if name not in named:
                named.add(name)
                at = (float(pose[0]), float(pose[1]))
                axis.annotate(name, at, (-12, 12), textcoords="offset points",
                              fontsize=11, fontweight="bold", color=INK)  # fmt: skip


def errors(along_m: FloatArray, turned_rad: FloatArray) -> Drawing:
    """Errors of the centre along the way and of its direction, with the paper's limits."""
    figure, axis = new_figure(height=3.4)
    x, y = 1000.0 * along_m, np.rad2deg(turned_rad)
    limit_mm, limit_deg = 1000.0 * POSITION_M, math.degrees(HEADING_RAD)
    inside = (np.abs(x) <= limit_mm) & (np.abs(y) <= limit_deg)
    corner, size = (-limit_mm, -limit_deg), (2 * limit_mm, 2 * limit_deg)
    axis.add_patch(Rectangle(corner, *size, fill=False, ec=MUTED, lw=1.2, ls="--"))
    axis.plot(x[inside], y[inside], ".", color=RIGHT, ms=6, alpha=0.7, label="within")
    axis.plot(x[~inside], y[~inside], ".", color=WRONG, ms=6, alpha=0.9, label="outside")
    axis.set_xlabel("error along the way, mm")
    axis.set_ylabel("error of direction, degrees")
    legend_below(figure, axis)
    alt = f"{int(inside.sum())} of {len(x)} gateways lie within 70 mm and 3.5 degrees."
    return Drawing(figure, alt)


def likelihoods(table: FloatArray, rows: Sequence[str], columns: Sequence[str]) -> Drawing:
    """A table of likelihoods, shaded; the largest of each row bold, as long as it is alone."""
    figure, axis = new_figure(height=0.62 + 0.36 * len(rows))
    axis.imshow(table, vmin=0.0, vmax=1.0, aspect="auto", alpha=0.75)
    for row, values in enumerate(table):
        best = np.flatnonzero(values == values.max())
        for column, value in enumerate(values):
            alone = len(best) == 1 and column == best[0]
            text = "0" if value == 0.0 else f"{value:.2f}"[1:] if value < 0.995 else "1"
            axis.text(column, row, text, ha="center", va="center", fontsize=9,
                      color="white" if value > 0.7 else INK,
                      fontweight="bold" if alone else "normal")  # fmt: skip
    axis.set_xticks(range(len(columns)), columns, color=INK)
    axis.set_yticks(range(len(rows)), rows, color=INK)
    axis.xaxis.tick_top()
    axis.grid(visible=False)
    told = "; ".join(
        f"{name}: " + ", ".join(f"{value:.2f}" for value in values)
        for name, values in zip(rows, table, strict=True)
    )
    return Drawing(figure, f"Likelihoods of {', '.join(columns)}. {told}.")


def matchers(here: Sequence[int], paper: Sequence[int], scenes: int) -> Drawing:
    """Scenes matched by each algorithm, the paper's beside ours."""
    figure, axis = new_figure(height=3.0)
    names = ["1 features", "2 cells,\ndistance and\ndirection", "3 cells,\ndirection", "4 cells,\n"
             "occupied", "soft"]  # fmt: skip
    place = np.arange(len(here))
    axis.bar(place[: len(paper)] - 0.2, paper, 0.38, color=TRUTH, label="paper")
    axis.bar(place + 0.2, here, 0.38, color=RIGHT, label="here")
    for x, value in [*zip(place - 0.2, paper, strict=False), *zip(place + 0.2, here, strict=True)]:
        axis.text(x, value + 0.2, str(value), ha="center", fontsize=9)
    axis.set_xticks(place, names, fontsize=8)
    axis.set(ylim=(0, scenes + 0.8), ylabel=f"scenes matched, of {scenes}")
    legend_below(figure, axis)
    told = ", ".join(f"{n.split(',')[0]}: {v}" for n, v in zip(names, here, strict=True))
    return Drawing(figure, f"Scenes matched of {scenes}. {told}.")


def confusion(table: NDArray[np.int64], types: Sequence[str]) -> Drawing:
    """How often each type (row) was classified as each (column), the last column: not at all."""
    figure, axis = new_figure(WIDE, 7.4)
    total = np.maximum(table.sum(axis=1, keepdims=True), 1)
    axis.imshow(table / total, vmin=0.0, vmax=1.0, aspect="auto", alpha=0.75)
    for row, column in zip(*np.nonzero(table), strict=True):
        dark = table[row, column] > 0.7 * total[row, 0]
        axis.text(column, row, str(table[row, column]), ha="center", va="center", fontsize=8,
                  color="white" if dark else INK)  # fmt: skip
    axis.set_xticks(range(len(types) + 1), [*types, "none"], rotation=60, ha="right", fontsize=7.5)
    axis.set_yticks(range(len(types)), types, fontsize=7.5)
    axis.grid(visible=False)
    axis.set(xlabel="classified as", ylabel="true type")
    right = int(np.trace(table))
    alt = f"{right} of {int(table.sum())} gateways classified right, {len(types)} types."
    return Drawing(figure, alt, wide=True)
