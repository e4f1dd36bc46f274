"""Accuracy over the number of landmarks that are kept, world by world."""

from __future__ import annotations

from dataclasses import dataclass

from fpnav.report.figures.style import INK, MUTED, Drawing, new_figure, percent
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Budgets:
    """``landmarks`` and ``accuracy`` (W, B): a row a world, a column a budget."""

    landmarks: FloatArray
    accuracy: FloatArray


def draw(found: Budgets) -> Drawing:
    """A thin line a world, a bold one for their mean."""
    figure, axis = new_figure(height=3.2)
    for landmarks, accuracy in zip(found.landmarks, found.accuracy, strict=True):
        axis.plot(landmarks, accuracy, color=MUTED, lw=0.8, marker=".", ms=4)
    landmarks, accuracy = found.landmarks.mean(axis=0), found.accuracy.mean(axis=0)
    axis.plot(landmarks, accuracy, color=INK, lw=2.0, marker="o", ms=5)
    axis.set(xlim=(0.0, None), ylim=(min(0.5, float(found.accuracy.min())), 1.0))
    axis.set_xlabel("landmarks in memory")
    axis.set_ylabel("nearest place wins")
    percent(axis.yaxis)
    told = ", ".join(
        f"{count:.0f} landmarks {100 * share:.0f} %"
        for count, share in zip(landmarks, accuracy, strict=True)
    )
    return Drawing(figure, f"Share of samples at which the nearest place wins, mean: {told}.")
