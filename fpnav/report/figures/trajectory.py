"""The map over the trajectory: places, edges, the true path, and what became of each query."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from fpnav.evaluation.plan import plan_of
from fpnav.report.entry import Entry
from fpnav.report.figures.axes import drawn_poses, outcome_counts, scatter_outcomes
from fpnav.report.figures.style import (
    INK,
    MUTED,
    PAPER,
    TRUTH,
    WIDE,
    WRONG,
    Drawing,
    legend_below,
    new_figure,
)
from fpnav.store.tables import Result
from fpnav.values import FloatArray

_LABELLED = 80
_ROOMY = 25
_LINES = 150


def draw(entry: Entry) -> Drawing | None:
    """Plan view; None where the run has no poses to draw at."""
    evaluation, result = entry.evaluation, entry.result
    if evaluation is None or result is None:
        return None
    queries, references, by = drawn_poses(result)
    known = references[np.isfinite(references).all(axis=1)]
    if not by or not len(known):
        return None
    figure, axis = new_figure(
        WIDE, _height(np.vstack([known, queries[np.isfinite(queries[:, 0])]]))
    )
    axis.plot(
        references[:, 0],
        references[:, 1],
        color=TRUTH,
        lw=3.2,
        label="path of the map" if result.view.place_ids.size else "path matched with",
        zorder=1,
    )
    if by == "truth":
        _walls(axis, result)
    if not result.view.place_ids.size:
        _wrong_lines(axis, result, queries, references, evaluation.table["outcome"])
    scatter_outcomes(axis, queries[:, 0], queries[:, 1], evaluation.table["outcome"])
    _places(axis, result)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel(f"x, m (by {by})")
    axis.set_ylabel("y, m")
    legend_below(figure, axis, columns=7)
    places = f"{len(result.view.place_ids)} places, " if result.view.place_ids.size else ""
    return Drawing(
        figure,
        f"Plan of the run: {places}{outcome_counts(evaluation.table['outcome'])} queries "
        "on the true path.",
        wide=True,
        whole=True,
    )


def _walls(axis: Axes, result: Result) -> None:
    """Walls of a simulated world, open where its doors are, where the log carried its plan."""
    plan = plan_of(result.header)
    if plan is None or not len(plan.walls):
        return
    walls = LineCollection(list(plan.walls), colors=MUTED, linewidths=1.0, zorder=0.2)
    open_doors = LineCollection(list(plan.openings), colors=PAPER, linewidths=2.6, zorder=0.3)
    for lines in (walls, open_doors):
        axis.add_collection(lines, autolim=False)
    axis.plot([], [], color=MUTED, lw=1.0, label="walls")


def _height(points: FloatArray) -> float:
    """Height in inches that suits the extent of the run."""
    width, height = np.maximum(np.ptp(points, axis=0), 1e-6)
    return float(np.clip((WIDE - 1.0) * height / width + 1.1, 3.4, 7.5))


def _places(axis: Axes, result: Result) -> None:
    """Places as numbered discs, joined by their edges."""
    view = result.view
    if not len(view.place_ids):
        return
    at = dict(zip(view.place_ids.tolist(), view.place_pose[:, :2], strict=True))
    pairs = {tuple(sorted((int(e["source"]), int(e["target"])))) for e in view.edges}
    lines = [np.array([at[a], at[b]]) for a, b in sorted(pairs) if a in at and b in at]
    axis.add_collection(LineCollection(lines, colors=MUTED, linewidths=1.1, zorder=2))
    numbered = len(at) <= _LABELLED
    size, letters = (170, 7.5) if len(at) <= _ROOMY else (95, 5.8)
    axis.scatter(
        view.place_pose[:, 0],
        view.place_pose[:, 1],
        s=size if numbered else 36,
        color=PAPER,
        edgecolors=INK,
        linewidths=1.1,
        zorder=7,
        label=f"places ({len(at)})",
    )
    if numbered:
        for place, (x, y) in at.items():
            axis.text(
                x, y, str(place), ha="center", va="center_baseline", fontsize=letters, zorder=8,
                clip_on=True,
            )  # fmt: skip


def _wrong_lines(
    axis: Axes, result: Result, queries: FloatArray, references: FloatArray, outcome: FloatArray
) -> None:
    """From wrongly decided queries, at most 150 of them, to where each was thought to be."""
    rows = np.flatnonzero((outcome == 1) & (result.members[:, :1] >= 0).any(axis=1))
    ends = references[result.members[rows, 0]] if len(rows) else np.zeros((0, 2))
    lines = np.stack([queries[rows], ends], axis=1) if len(rows) else np.zeros((0, 2, 2))
    lines = lines[np.isfinite(lines).all(axis=(1, 2))]
    lines = lines[:: -(-len(lines) // _LINES)] if len(lines) else lines
    if len(lines):
        axis.add_collection(
            LineCollection(list(lines), colors=WRONG, linewidths=0.6, alpha=0.3, zorder=2)
        )
