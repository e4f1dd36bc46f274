"""The figures of a report: name of the file, title, caption. A new figure is one line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fpnav.report.entry import Entry
from fpnav.report.figures import curves, runs, strips, trajectory
from fpnav.report.figures.style import Drawing


@dataclass(frozen=True, slots=True)
class Plot:
    """One figure of one result; drawing None means the result has nothing for it."""

    draw: Callable[[Entry], Drawing | None]
    title: str
    caption: str


@dataclass(frozen=True, slots=True)
class Comparison:
    """One figure over several results."""

    draw: Callable[[Sequence[Entry]], Drawing | None]
    title: str
    caption: str


_PRECISION = (
    "Each query has one best match; the curve sweeps the score it must reach. Hollow circle: what "
    "the run decided with the threshold it had, knowable as no truth went into it. Square and "
    "triangle, where another run was named: thresholds chosen there, knowable without any truth of "
    "this run once its scores are in. Every other point of the curve, and the diamond, is a "
    "threshold picked on this very run with its truth: knowable to nobody."
)
_TOLERANCE = (
    "Recall at 1 had a match counted within another radius. The number of queries that have a "
    "match grows with it."
)
_RECALL = "Share of the queries with a match that find one among the first N answers."

PLOTS: dict[str, Plot] = {
    "map": Plot(
        trajectory.draw,
        "The run from above",
        "Thick grey: the path that was mapped or matched against; numbered discs: the places found "
        "on it, joined where the robot went from one to the other. Each mark is a query at its "
        "true position: right, wrong, or not localized. Without a map of places, thin lines lead "
        "from wrong answers (at most 150) to where the robot was thought to be.",
    ),
    "matches": Plot(
        runs.matches,
        "What each query was matched with",
        "Grey squares: the true matches. A mark off the squares is a wrong match; a band of marks "
        "is a stretch of path driven again.",
    ),
    "precision-recall": Plot(
        lambda entry: curves.precision_recall([entry]), "Precision and recall", _PRECISION
    ),
    "recall": Plot(lambda entry: curves.recall_at_n([entry]), "Recall at N", _RECALL),
    "tolerance": Plot(
        lambda entry: curves.tolerance([entry]), "How much hangs on the radius", _TOLERANCE
    ),
    "confusion": Plot(
        runs.confusion,
        "Which places are taken for which",
        "Rows: the true place. Columns: the place decided; the last one holds the decisions "
        "withheld. A perfect run fills the diagonal.",
    ),
    "calibration": Plot(
        curves.calibration,
        "Does the stated probability hold?",
        "Above the line the run was more often right than it said, below less often.",
    ),
    "belief": Plot(
        runs.belief,
        "Belief along the run",
        "How probable each place was held to be as the robot drove; dots are the true place.",
    ),
    "error": Plot(
        runs.error_over_distance,
        "Error along the run",
        "Distance from the true position to that of the best answer, on a logarithmic scale; "
        "below 2 cm drawn at 2 cm.",
    ),
    "novelty": Plot(
        runs.novelty,
        "How places were cut while mapping",
        "Dissimilarity of each observation to the present place; where it passes the threshold a "
        "new place begins.",
    ),
    "strips": Plot(
        strips.draw,
        "What some places look like to the system",
        "The readable signature of places spread over the map; equal symbols share a tint.",
    ),
}

COMPARISONS: dict[str, Comparison] = {
    "compare-precision-recall": Comparison(
        curves.precision_recall, "Precision and recall side by side", _PRECISION
    ),
    "compare-recall": Comparison(curves.recall_at_n, "Recall at N side by side", _RECALL),
    "compare-tolerance": Comparison(
        curves.tolerance, "How much hangs on the radius, side by side", _TOLERANCE
    ),
}
