"""Place fields along a line, as Giovannangeli et al. draw them."""

from __future__ import annotations

import math

import numpy as np

from fpnav.evaluation.fields import Fields
from fpnav.report.figures.style import FAINT, INK, MUTED, SERIES, Drawing, new_figure


def draw(fields: Fields, hidden_from_m: float = math.nan) -> Drawing:
    """Activity of every place over position; ticks below are where places were learned.

    ``hidden_from_m`` : beyond it half of the view is hidden, which is shaded.
    """
    figure, axis = new_figure(height=3.2)
    x = fields.position_m
    if math.isfinite(hidden_from_m):
        axis.axvspan(hidden_from_m, float(x[-1]), color=FAINT, alpha=0.6, lw=0)
        axis.text(hidden_from_m, 1.03, " half of the view is hidden", color=MUTED, fontsize=8)
    for place, learned in enumerate(fields.learned_m):
        color = SERIES[place % len(SERIES)]
        axis.plot(x, fields.activity[:, place], color=color, lw=1.2)
        axis.plot([learned], [0.012], "^", color=color, ms=6, mec=INK, mew=0.6, zorder=4)
    axis.set(ylim=(0.0, 1.05), xlim=(float(x[0]), float(x[-1])))
    axis.set_xlabel("position on the line, m")
    axis.set_ylabel("activity of the place cells")
    return Drawing(figure, _words(fields))


def _words(fields: Fields) -> str:
    peaks = fields.activity.max(axis=0)
    at = fields.position_m[np.argmax(fields.activity, axis=0)]
    told = ", ".join(
        f"{learned:.1f} m: highest {peak:.2f} at {where:.1f} m"
        for learned, peak, where in zip(fields.learned_m, peaks, at, strict=True)
    )
    return f"Activity of {len(peaks)} place cells along a line. Places learned at {told}."
