"""Readable signatures of some places, one row each, one coloured cell a symbol."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from fpnav.report.entry import Entry
from fpnav.report.figures.style import INK, PAPER, WIDE, Drawing, new_figure, shown

_SHOWN = 12
_LONGEST = 60
_ALPHABET = 40
_TINTS = ("#eef0f3", "#cfe3f3", "#fbdcc6", "#cdeadd", "#e4d6f0", "#f3e6b8", "#f4cfdf", "#cfe8ec",
          "#dfe2d0", "#c9cfe8", "#f0d2cc", "#d7ecc9")  # fmt: skip


def draw(entry: Entry) -> Drawing | None:
    """Strips of places spread over the map; None where the system has no readable strip."""
    if entry.result is None or not any(entry.result.view.strips):
        return None
    view = entry.result.view
    strips = [strip[:_LONGEST] for strip in view.strips]
    if len(set("".join(strips))) > _ALPHABET:
        return None
    rows = np.unique(np.linspace(0, len(strips) - 1, min(_SHOWN, len(strips))).astype(int))
    chosen = [strips[row] for row in rows]
    longest = max(len(strip) for strip in chosen)
    figure, axis = new_figure(WIDE, 0.5 + 0.32 * len(rows))
    _cells(axis, chosen, _tints(strips))
    axis.set(xlim=(-0.2, max(longest, 20) + 0.2), ylim=(len(rows) - 0.4, -0.6))
    axis.set_yticks(range(len(rows)), [f"place {view.place_ids[row]}" for row in rows])
    axis.set_xticks([])
    axis.grid(False)
    axis.spines[:].set_visible(False)
    example = f"place {view.place_ids[rows[0]]} reads {view.strips[rows[0]][:_LONGEST]}"
    words = f"Signatures of {len(rows)} places as strings; {example}."
    summary = str(entry.result.header.get("summary", ""))
    note = f"{shown(summary[:1].upper() + summary[1:], 200)}." if summary else ""
    return Drawing(figure, words, wide=True, note=note)


def _tints(strips: Sequence[str]) -> dict[str, str]:
    """A tint for each symbol, the commonest first; ties by symbol."""
    counts = Counter("".join(strips))
    symbols = sorted(counts, key=lambda symbol: (-counts[symbol], symbol))
    return {symbol: _TINTS[i % len(_TINTS)] for i, symbol in enumerate(symbols)}


def _cells(axis: Axes, strips: Sequence[str], tint: dict[str, str]) -> None:
    for row, strip in enumerate(strips):
        for column, symbol in enumerate(strip):
            cell = Rectangle((column, row - 0.4), 0.96, 0.8, fc=tint[symbol], ec=PAPER, lw=0.6)
            cell.set_in_layout(False)
            axis.add_patch(cell)
            letter = axis.text(
                column + 0.48,
                row,
                shown(symbol),
                ha="center",
                va="center_baseline",
                fontsize=8,
                color=INK,
            )
            letter.set_in_layout(False)
