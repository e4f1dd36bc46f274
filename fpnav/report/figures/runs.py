"""What happened along the run: newness while mapping, belief, error, the match of each query."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from fpnav.evaluation.evaluate import Evaluation
from fpnav.evaluation.places import kidnaps
from fpnav.report.entry import Entry
from fpnav.report.figures.axes import along, along_rows, outcome_counts, scatter_outcomes
from fpnav.report.figures.style import (
    FAINT,
    MUTED,
    RIGHT,
    TRUTH,
    WIDE,
    WRONG,
    Drawing,
    legend_below,
    new_figure,
    percent,
)
from fpnav.store.tables import Result
from fpnav.values import FloatArray

_LEAST_M = 0.02


def novelty(entry: Entry) -> Drawing | None:
    """Dissimilarity while the map was built, the threshold, and where places start."""
    if entry.result is None or not np.isfinite(entry.result.view.novelty).any():
        return None
    result = entry.result
    values, threshold = result.view.novelty, result.view.threshold
    at, name = along_rows(result.references["travelled_m"], "signature")
    starts = np.flatnonzero(np.diff(result.owner, prepend=result.owner[:1]))
    figure, axis = new_figure(WIDE, 2.7)
    axis.vlines(at[starts], 0, 1, color=FAINT, lw=1.0, label="another place begins", zorder=1)
    axis.plot(at, values, color=RIGHT, lw=1.0, label="dissimilarity", zorder=3)
    if np.isfinite(threshold):
        label = f"threshold \u03b8 = {threshold:.2f}"
        axis.axhline(threshold, color=WRONG, lw=1.3, ls=(0, (5, 3)), label=label, zorder=2)
    axis.set(ylim=(-0.02, 1.02), xlim=(at[0], at[-1]))
    axis.set_xlabel(name)
    axis.set_ylabel("dissimilarity")
    legend_below(figure, axis)
    words = f"at a threshold of {threshold:.2f} " if np.isfinite(threshold) else ""
    number = len(result.view.place_ids)
    return Drawing(figure, f"Newness along the mapping run; {words}{number} places.", wide=True)


def belief(entry: Entry) -> Drawing | None:
    """Probability of each place over the run, with the true place drawn over it."""
    evaluation, result = entry.evaluation, entry.result
    if evaluation is None or result is None or 0 in result.belief.shape:
        return None
    at, name = along(evaluation)
    if len(at) < 2:
        return None
    count = result.belief.shape[1]
    figure, axis = new_figure(WIDE, float(np.clip(1.4 + 0.12 * count, 2.8, 6.0)))
    edges = np.concatenate([at[:1], 0.5 * (at[1:] + at[:-1]), at[-1:]])
    shade = axis.pcolormesh(
        edges, np.arange(count + 1) - 0.5, result.belief.T, vmin=0, vmax=1, rasterized=True
    )
    _true_places(axis, evaluation, at)
    _place_ticks(axis, result.view.place_ids)
    bar = figure.colorbar(shade, ax=axis, pad=0.01, aspect=30, shrink=0.9)
    bar.outline.set_visible(False)
    bar.set_label("belief")
    percent(bar.ax.yaxis)
    axis.grid(False)
    axis.set_xlabel(name)
    axis.set_ylabel("place")
    legend_below(figure, axis)
    return Drawing(figure, f"Belief over {count} places along the run with the truth.", wide=True)


def error_over_distance(entry: Entry) -> Drawing | None:
    """Distance between truth and answer along the run, marked by outcome."""
    evaluation = entry.evaluation
    if evaluation is None:
        return None
    error = np.maximum(evaluation.table["position_error_m"], _LEAST_M)
    shown_rows = np.isfinite(error)
    if not shown_rows.any():
        return None
    at, name = along(evaluation)
    figure, axis = new_figure(WIDE, 2.9)
    _kidnap_lines(axis, evaluation.case.result, at)
    scatter_outcomes(axis, at, error, evaluation.table["outcome"])
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_xlabel(name)
    axis.set_ylabel("error, m")
    legend_below(figure, axis, columns=5)
    middle = float(np.median(error[shown_rows]))
    return Drawing(figure, f"Position error along the run, median {middle:.2f} m.", wide=True)


def matches(entry: Entry) -> Drawing | None:
    """Best match of each query against the order of the reference run; for results without map."""
    evaluation, result = entry.evaluation, entry.result
    if (
        evaluation is None
        or result is None
        or result.view.place_ids.size
        or not len(result.queries)
    ):
        return None
    case = evaluation.case
    x = evaluation.table["index"].astype(np.float64)
    best = evaluation.table["best_member"].astype(np.float64)
    best[best < 0] = np.nan
    figure, axis = new_figure(height=4.3)
    pairs = np.repeat(x, np.diff(case.accepted.offsets))
    accepted = result.references["index"][case.accepted.flat]
    axis.plot(
        pairs, accepted, "s", color=TRUTH, ms=2.2, mew=0, label="true matches", rasterized=True
    )
    scatter_outcomes(axis, x, best, evaluation.table["outcome"], scale=0.7)
    axis.set_xlabel("query, message number")
    axis.set_ylabel("best match, message number")
    legend_below(figure, axis, columns=2)
    return Drawing(figure, f"Best match per query: {outcome_counts(evaluation.table['outcome'])}.")


def confusion(entry: Entry) -> Drawing | None:
    """Which place was answered where which was true, as shares of each true place."""
    evaluation, result = entry.evaluation, entry.result
    if evaluation is None or result is None or "place_accuracy_top1" not in entry.metrics:
        return None
    table = confusion_table(evaluation.case.true_place, result.decision, result.view.place_ids)
    share = table / np.maximum(table.sum(axis=1, keepdims=True), 1)
    count = len(result.view.place_ids)
    figure, axis = new_figure(height=4.3)
    shade = axis.imshow(
        np.where(table.sum(axis=1, keepdims=True) > 0, share, np.nan),
        vmin=0,
        vmax=1,
        interpolation="none",
        aspect="auto",
    )
    axis.axvline(count - 0.5, color=MUTED, lw=0.9)
    step = max(1, -(-count // 12))
    ticks = [tick for tick in range(0, count, step) if tick == 0 or tick <= count - 0.7 * step]
    names = [str(result.view.place_ids[tick]) for tick in ticks]
    axis.set_yticks(ticks, names)
    axis.set_xticks([*ticks, count], [*names, "none"])
    axis.grid(False)
    axis.set_xlabel("place decided")
    axis.set_ylabel("true place")
    bar = figure.colorbar(shade, ax=axis, pad=0.02, aspect=30)
    bar.outline.set_visible(False)
    percent(bar.ax.yaxis)
    diagonal = int(np.trace(table[:, :count]))
    return Drawing(figure, f"Confusion of {count} places: {diagonal} of {int(table.sum())} right.")


def confusion_table(
    true_place: NDArray[np.int64], decision: NDArray[np.int64], ids: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Counts (P, P + 1): rows true, columns decided, the last column not localized."""
    column = {int(place): i for i, place in enumerate(ids)}
    table = np.zeros((len(ids), len(ids) + 1), dtype=np.int64)
    for true, decided in zip(true_place.tolist(), decision.tolist(), strict=True):
        if true in column:
            table[column[true], column.get(decided, len(ids))] += 1
    return table


def _true_places(axis: Axes, evaluation: Evaluation, at: FloatArray) -> None:
    row_of = {int(place): i for i, place in enumerate(evaluation.case.result.view.place_ids)}
    rows = np.array([row_of.get(int(p), np.nan) for p in evaluation.case.true_place], dtype=float)
    if np.isfinite(rows).any():
        axis.plot(at, rows, ".", color=WRONG, ms=3.2, mew=0, label="true place")


def _place_ticks(axis: Axes, ids: NDArray[np.int64]) -> None:
    step = max(1, -(-len(ids) // 15))
    ticks = list(range(0, len(ids), step))
    axis.set_yticks(ticks, [str(ids[tick]) for tick in ticks])


def _kidnap_lines(axis: Axes, result: Result, at: FloatArray) -> None:
    starts = kidnaps(result.queries["truth"], result.queries["session"])
    for row in starts:
        axis.axvline(at[row], color=MUTED, lw=0.9, ls=":", zorder=1)
    if len(starts):
        axis.plot([], [], color=MUTED, lw=0.9, ls=":", label="kidnapped")
