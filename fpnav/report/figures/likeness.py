"""Likeness over how far landmarks moved, and stated certainty against what came of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.calibration import BINS, bins_of
from fpnav.report.figures.style import FAINT, INK, MUTED, RIGHT, WRONG, Drawing, new_figure
from fpnav.values import FloatArray


def over_moves(moved_deg: FloatArray, alike: FloatArray, unlike: float) -> Drawing:
    """prob_matching (moves, samples) over the moves, and the level of different places."""
    figure, axis = new_figure(height=3.2)
    low, middle, high = np.quantile(alike, [0.25, 0.5, 0.75], axis=1)
    axis.fill_between(moved_deg, low, high, color=RIGHT, alpha=0.2, lw=0)
    axis.plot(moved_deg, middle, "o-", color=RIGHT, ms=3.5)
    axis.axhline(unlike, color=WRONG, lw=1.2, ls=(0, (5, 3)))
    axis.text(moved_deg[-1], unlike, "different places ", color=WRONG, fontsize=8.5,
              ha="right", va="bottom")  # fmt: skip
    axis.set(ylim=(0.0, 1.02))
    axis.set_xlabel("every second feature moved by, \u00b0")
    axis.set_ylabel("prob_matching")
    words = f"Matching falls from {middle[0]:.2f} to {middle[-1]:.2f}; others reach {unlike:.2f}."
    return Drawing(figure, words)


def reliability(stated: FloatArray, again: NDArray[np.bool_]) -> Drawing:
    """Share seen again in each bin of stated certainty; bars below tell how many there are."""
    bins = bins_of(stated)
    counts = np.bincount(bins, minlength=BINS)
    used = counts >= max(20, len(stated) // 1000)
    share = np.bincount(bins, weights=again, minlength=BINS) / np.maximum(counts, 1)
    said = np.bincount(bins, weights=stated, minlength=BINS) / np.maximum(counts, 1)
    figure, axis = new_figure(height=3.6)
    centres = (np.arange(BINS) + 0.5) / BINS
    axis.bar(centres, 0.25 * counts / counts.max(), width=0.09, color=FAINT, zorder=1)
    axis.plot([0, 1], [0, 1], color=MUTED, lw=1.0, ls=(0, (4, 3)), zorder=2)
    axis.plot(said[used], share[used], "o-", color=INK, ms=4.5, zorder=3)
    axis.set(xlim=(0, 1), ylim=(0, 1.02))
    axis.set_xlabel("stated certainty")
    axis.set_ylabel("seen again")
    return Drawing(figure, f"Reliability of the certainty of {len(stated)} features.")
