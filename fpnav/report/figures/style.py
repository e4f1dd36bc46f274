"""How every figure looks, and the one way from a figure to bytes: same input, same bytes."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import matplotlib as mpl
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

INK, MUTED, FAINT, PAPER = "#22262b", "#6b7280", "#d9dce1", "#ffffff"
RIGHT, WRONG, WITHHELD, TRUTH = "#0b66a8", "#d1540c", "#8b929b", "#b9bec6"
SERIES = ("#0b66a8", "#d1540c", "#2f8f6b", "#8a5bb0", "#b58a00", "#c2457a", "#4a90a4", "#6f6f6f")
"""Told apart with any colour vision as far as eight lines can be (after Okabe and Ito)."""

WIDTH, WIDE = 5.4, 10.8
"""Widths in inches: half the page of a laptop and the whole of a phone; the whole of a laptop."""

_RC: Any = {
    "svg.hashsalt": "fpnav",
    "svg.fonttype": "path",
    "text.parse_math": False,
    "axes.formatter.use_mathtext": False,
    "axes.unicode_minus": True,
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.labelsize": 9.5,
    "axes.labelcolor": MUTED,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#eceef1",
    "grid.linewidth": 0.8,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.size": 0,
    "ytick.major.size": 0,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "legend.handlelength": 1.4,
    "lines.solid_capstyle": "round",
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "figure.dpi": 100,
    "image.cmap": "Blues",
}


@dataclass(frozen=True, slots=True)
class Drawing:
    """A finished figure and what it shows in words, for those who cannot see it.

    ``wide`` : it takes the whole width of the page, and is moved sideways on a phone; ``whole`` :
    it is made smaller there than other wide ones, to be seen nearly as a whole. ``note`` stands
    under it after the caption.
    """

    figure: Figure
    alt: str
    wide: bool = False
    whole: bool = False
    note: str = ""


@contextmanager
def styled() -> Iterator[None]:
    """Context in which figures are drawn and saved; the user's own settings do not count."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_RC)
        yield


def new_figure(width: float = WIDTH, height: float = 3.6) -> tuple[Figure, Axes]:
    """A figure of the given size in inches with one axis."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.add_subplot()


def as_svg(figure: Figure) -> bytes:
    """SVG of a figure, without a date."""
    buffer = io.BytesIO()
    with styled():
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": "fpnav"}, dpi=160)
        figure.set_layout_engine("none")  # laid out once; the PNG takes the places found
    return buffer.getvalue()


def as_png(figure: Figure, dpi: float = 160.0) -> bytes:
    """PNG of a figure, by default fit for a screen of high resolution."""
    buffer = io.BytesIO()
    with styled():
        figure.savefig(buffer, format="png", metadata={"Software": "fpnav"}, dpi=dpi)
    return buffer.getvalue()


def shown(text: str, longest: int = 40) -> str:
    """A name from a log or file as it may stand in a figure.

    Characters the font lacks become a box, a leading underscore would hide a legend entry, long
    names lose their middle.
    """
    known = _glyphs()
    visible = "".join(c if ord(c) in known and c.isprintable() else "\u25a1" for c in text)
    if len(visible) > longest:
        half = (longest - 1) // 2
        visible = f"{visible[:half]}\u2026{visible[-half:]}"
    return f" {visible}" if visible.startswith("_") else visible


@cache
def _glyphs() -> frozenset[int]:
    path = font_manager.findfont("DejaVu Sans")
    return frozenset(font_manager.get_font(path).get_charmap())


def legend_below(figure: Figure, axis: Axes, columns: int = 3, **options: Any) -> None:
    """Legend under the figure, where it hides nothing."""
    handles, labels = axis.get_legend_handles_labels()
    if handles:
        figure.legend(
            handles,
            labels,
            loc="outside lower left",
            ncols=columns,
            columnspacing=1.4,
            borderaxespad=0.2,
            **options,
        )


def percent(axis: Axis) -> None:
    """Show an axis of shares as whole percent."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:.0f} %"))
