"""Precision and recall, recall over ranks, calibration: one or several results on one axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, MaxNLocator, NullLocator

from fpnav.evaluation import curve
from fpnav.evaluation.calibration import BINS, bins_of
from fpnav.evaluation.evaluate import Evaluation
from fpnav.evaluation.measure import Absent
from fpnav.evaluation.tolerance import Tolerance, tolerance_sweep
from fpnav.evaluation.transfer import Carried, carry
from fpnav.report.entry import Entry
from fpnav.report.figures.style import (
    FAINT,
    INK,
    MUTED,
    PAPER,
    SERIES,
    Drawing,
    legend_below,
    new_figure,
    percent,
    shown,
)
from fpnav.values import FloatArray

_RANKS = 25

_MARKS = {100: "s", 99: "^"}
"""Marks of the thresholds chosen on another run, by the precision they reached there in percent."""

Found = TypeVar("Found")


def precision_recall(entries: Sequence[Entry]) -> Drawing | None:
    """Curves of the best match per query, with the point each run chose for itself."""
    drawn = _drawn(entries, _curve)
    if not drawn:
        return None
    figure, axis = new_figure(height=4.3 if len(drawn) > 1 or drawn[0][1].chosen_on else 3.9)
    words: list[str] = []
    notes: list[str] = []
    for color, entry, evaluation in drawn:
        recall, precision = _points(evaluation)
        axis.step(recall, precision, where="post", color=color, lw=1.7, label=shown(entry.name))
        words.append(f"{entry.name}: {_operating_point(axis, evaluation, color)}")
        notes += _carried(axis, entry, evaluation, color)
    axis.plot([], [], "o", mfc=PAPER, mec=INK, label="threshold the run used")
    carried = _carried_legend(axis, [entry for _, entry, _ in drawn])
    if len(drawn) == 1:
        _perfect_point(axis, drawn[0][2])
    axis.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.04))
    axis.set_xlabel("recall, of queries with a match")
    axis.set_ylabel("precision")
    percent(axis.xaxis)
    percent(axis.yaxis)
    legend_below(figure, axis, columns=1 if carried or len(drawn) > 2 else 2)
    alt = f"Precision over recall. {'; '.join([*words, *notes])}."
    return Drawing(figure, alt, note="".join(f"{line}. " for line in notes))


def recall_at_n(entries: Sequence[Entry]) -> Drawing | None:
    """Share of queries with a match that find one among the first N."""
    drawn = _drawn(entries, _ranks)
    if not drawn:
        return None
    figure, axis = new_figure(height=4.3 if len(drawn) > 1 else 3.9)
    words = []
    for color, entry, found in drawn:
        ranks = np.arange(1, len(found) + 1)
        axis.plot(ranks, found, "o-", color=color, lw=1.7, ms=3.5, label=shown(entry.name))
        words.append(f"{entry.name}: {100 * found[0]:.0f} % at 1, {100 * found[-1]:.0f} % at "
                     f"{len(found)}")  # fmt: skip
    axis.set(ylim=(-0.02, 1.04), xlim=(0.5, None))
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.set_xlabel("answers looked at, N")
    axis.set_ylabel("queries that find a match")
    percent(axis.yaxis)
    if len(drawn) > 1:
        legend_below(figure, axis, columns=1 if len(drawn) > 2 else 2)
    return Drawing(figure, f"Recall over the first N answers. {'; '.join(words)}.")


def tolerance(entries: Sequence[Entry]) -> Drawing | None:
    """Recall at 1 over the radius within which a match counts."""
    drawn = _drawn(entries, _swept)
    if not drawn:
        return None
    figure, axis = new_figure(height=4.3 if len(drawn) > 1 else 3.9)
    words = [f"{entry.name}: {_line(axis, color, entry, s)}" for color, entry, s in drawn]
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator([0.25, 0.5, 1, 2, 5, 10]))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set(ylim=(-0.02, 1.04))
    axis.set_xlabel("radius that counts as the same place, m")
    axis.set_ylabel("recall at 1")
    percent(axis.yaxis)
    if len(drawn) > 1:
        legend_below(figure, axis, columns=1 if len(drawn) > 2 else 2)
    return Drawing(figure, f"Recall at 1 over the radius. {'; '.join(words)}.")


def _line(axis: Axes, color: str, entry: Entry, sweep: Tolerance) -> str:
    """Draw one sweep; its values in words."""
    known = sweep.base > 0
    radii, base = sweep.radii_m[known], sweep.base[known]
    share = sweep.right[known] / base
    axis.plot(radii, share, "o-", color=color, lw=1.7, ms=3.5, label=shown(entry.name))
    points = zip(share, base, radii, strict=True)
    return ", ".join(f"{100 * part:.0f} % of {of} at {radius:g} m" for part, of, radius in points)


def calibration(entry: Entry) -> Drawing | None:
    """Share right over stated probability, in ten bins, with their counts."""
    evaluation = entry.evaluation
    if evaluation is None or "ece" not in entry.metrics:
        return None
    used = evaluation.case.judged & np.isfinite(evaluation.table["stated"])
    used &= evaluation.case.answered
    stated = evaluation.table["stated"][used]
    right = evaluation.case.best_right[used].astype(float)
    bins = bins_of(stated)
    count = np.bincount(bins, minlength=BINS)
    held = count > 0
    figure, axis = new_figure(height=3.9)
    axis.plot([0, 1], [0, 1], color=FAINT, lw=1.4, zorder=1, label="perfectly calibrated")
    mean = np.bincount(bins, stated, BINS)[held] / count[held]
    share = np.bincount(bins, right, BINS)[held] / count[held]
    axis.vlines(mean, mean, share, color=SERIES[1], lw=1.2, alpha=0.6, zorder=2)
    sizes = 18 + 260 * count[held] / count.sum()
    axis.scatter(mean, share, s=sizes, color=SERIES[0], zorder=3, label="bin, area = queries")
    axis.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.05))
    axis.set_xlabel("probability stated")
    axis.set_ylabel("share right")
    percent(axis.xaxis)
    percent(axis.yaxis)
    legend_below(figure, axis, columns=2, markerscale=0.5)
    error = entry.metrics["ece"].value
    return Drawing(figure, f"Stated probability against share right; mean gap {error:.3f}.")


def _drawn(
    entries: Sequence[Entry], find: Callable[[Evaluation], Found | None]
) -> list[tuple[str, Entry, Found]]:
    """What is found to draw of the entries, each in the colour of its place in the report; nothing
    where several are to be compared and fewer than two have it."""
    found = [(e, find(e.evaluation) if e.evaluation is not None else None) for e in entries]
    drawn = [
        (SERIES[row % len(SERIES)], entry, thing)
        for row, (entry, thing) in enumerate(found)
        if thing is not None
    ]
    return drawn if len(drawn) >= min(2, len(entries)) else []


def _curve(evaluation: Evaluation) -> Evaluation | None:
    return evaluation if "average_precision" in evaluation.metrics else None


def _ranks(evaluation: Evaluation) -> FloatArray | None:
    """Share found among the first 1, 2, ... answers."""
    case = evaluation.case
    if "recall_at_1" not in evaluation.metrics or case.right.shape[1] < 2:
        return None
    found = np.maximum.accumulate(case.right[case.has_match][:, :_RANKS], axis=1)
    return np.asarray(found.mean(axis=0))


def _swept(evaluation: Evaluation) -> Tolerance | None:
    sweep = tolerance_sweep(evaluation.case)
    return sweep if sweep is not None and sweep.base[-1] else None


def _points(evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
    counts = curve.plain(curve.sweep(evaluation.case))
    recall, precision = counts.recall(counts.base)[0], counts.precision[0]
    return np.append(0.0, recall), np.append(precision, precision[-1])


def _operating_point(axis: Axes, evaluation: Evaluation, color: str) -> str:
    """Mark the precision and recall of the decisions the run really made."""
    case = evaluation.case
    made = case.judged & case.decided
    if not made.any():
        return "every decision withheld"
    right = int((case.decided_right & made).sum())
    precision, recall = right / int(made.sum()), right / int(case.has_match.sum())
    axis.plot(recall, precision, "o", mfc=PAPER, mec=color, mew=1.8, ms=7, zorder=5)
    return f"decided with precision {100 * precision:.0f} % at recall {100 * recall:.0f} %"


def _carried(axis: Axes, entry: Entry, evaluation: Evaluation, color: str) -> list[str]:
    """Mark precision and recall at thresholds carried over; what each says, or why not."""
    if not entry.chosen_on:
        return []
    said = []
    for reached, marker in _MARKS.items():
        carried = carry(evaluation.case, reached / 100)
        told = _told(entry, reached, carried)
        said.append(f"{entry.name}, threshold for {reached} % on {entry.chosen_on}: {told}")
        names = _carried_names(reached)
        if all(name in entry.metrics for name in names):
            precision, recall = (entry.metrics[name].value for name in names)
            axis.plot(recall, precision, marker, mfc=color, mec=PAPER, ms=7.5, zorder=6)
    return said


def _told(entry: Entry, reached: int, carried: Carried | Absent) -> str:
    """A carried threshold in words, with the counts that precision and recall are made of."""
    if isinstance(carried, Absent):
        return carried.reason
    parts = [
        f"score {carried.chosen:.3g} there, which {100 * carried.accepted:.1f} % of its best "
        f"matches reach; {carried.here:.3g} here"
    ]
    for name, word in zip(_carried_names(reached), ("precision", "recall"), strict=True):
        if name in entry.metrics:
            found = entry.metrics[name]
            parts.append(f"{word} {100 * found.value:.1f} % ({found.n} of {found.of})")
        else:
            parts.append(f"no {word}: {entry.absent[name]}")
    return ", ".join(parts)


def _carried_names(reached: int) -> tuple[str, str]:
    return f"precision_at_carried_{reached}", f"recall_at_carried_{reached}"


def _carried_legend(axis: Axes, entries: Sequence[Entry]) -> bool:
    """Explain the marks that some entry has; whether there is one."""
    any_marked = False
    for reached, marker in _MARKS.items():
        if any(_carried_names(reached)[0] in entry.metrics for entry in entries):
            label = f"threshold for {reached} % on {shown(entries[0].chosen_on, 24)}"
            axis.plot([], [], marker, mfc=INK, mec=PAPER, ms=7.5, label=label)
            any_marked = True
    return any_marked


def _perfect_point(axis: Axes, evaluation: Evaluation) -> None:
    """Mark the largest recall at full precision, a threshold nobody could have known."""
    best = evaluation.metrics["recall_at_100_precision"].value
    if best == 0.0:
        return
    label = f"100 % precision, picked afterwards ({100 * best:.1f} %)"
    axis.plot(best, 1.0, "D", color=MUTED, ms=5, zorder=5, label=label)
