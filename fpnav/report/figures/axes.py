"""What several figures share: where a query stands along the run, how an outcome is marked."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from fpnav.evaluation.evaluate import Evaluation
from fpnav.report.figures.style import INK, PAPER, RIGHT, WITHHELD, WRONG
from fpnav.store.tables import Result
from fpnav.values import FloatArray

OUTCOME_MARKS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "s": 11, "color": RIGHT, "linewidths": 0.0, "zorder": 4},
    {"marker": "X", "s": 24, "color": WRONG, "linewidths": 0.4, "edgecolors": PAPER, "zorder": 6},
    {"marker": "o", "s": 13, "facecolors": PAPER, "edgecolors": WITHHELD, "linewidths": 0.9,
     "zorder": 3},
    {"marker": "o", "s": 9, "color": INK, "linewidths": 0.0, "zorder": 3},
)  # fmt: skip
OUTCOME_WORDS = ("right", "wrong", "not localized", "not judged")


def along(evaluation: Evaluation) -> tuple[FloatArray, str]:
    """Position of each query along the run, (Q,), never decreasing, and the name of the axis."""
    return along_rows(evaluation.table["travelled_m"], "query")


def along_rows(travelled_m: FloatArray, unit: str) -> tuple[FloatArray, str]:
    """Travelled metres where they are known for all and never run back, else the count."""
    known = np.isfinite(travelled_m).all() and len(travelled_m) > 0
    if known and (np.diff(travelled_m) >= 0).all() and np.ptp(travelled_m) > 0:
        return np.asarray(travelled_m, dtype=np.float64), "travelled, m"
    return np.arange(len(travelled_m), dtype=np.float64), f"{unit} number"


def drawn_poses(result: Result) -> tuple[FloatArray, FloatArray, str]:
    """Where queries and references are drawn, (Q, 2) and (R, 2), and by what; empty word = nowhere.

    Truth where both runs have it; odometry where one run is matched with itself.
    """
    queries, references = result.queries["truth"], result.references["truth"]
    if np.isfinite(queries).all(axis=1).any() and np.isfinite(references).all(axis=1).any():
        return queries[:, :2], references[:, :2], "truth"
    own_past = (result.candidates < len(result.references)).any()
    odometry = result.queries["odometry"]
    if own_past and np.isfinite(odometry).all(axis=1).any():
        return odometry[:, :2], result.references["odometry"][:, :2], "odometry"
    return queries[:, :2], references[:, :2], ""


def scatter_outcomes(
    axis: Axes, x: FloatArray, y: FloatArray, outcome: NDArray[np.int8], scale: float = 1.0
) -> None:
    """Points marked by outcome, in shape as well as in colour."""
    for code, (mark, word) in enumerate(zip(OUTCOME_MARKS, OUTCOME_WORDS, strict=True)):
        rows = (outcome == code) & np.isfinite(x) & np.isfinite(y)
        if rows.any():
            style = {**mark, "s": mark["s"] * scale}
            axis.scatter(
                x[rows], y[rows], label=f"{word} ({int((outcome == code).sum())})", **style
            )


def outcome_counts(outcome: NDArray[np.int8]) -> str:
    """The outcomes in words: ``12 right, 3 wrong``."""
    counts = [(int((outcome == code).sum()), word) for code, word in enumerate(OUTCOME_WORDS)]
    return ", ".join(f"{count} {word}" for count, word in counts if count)
