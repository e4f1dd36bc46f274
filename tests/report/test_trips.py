"""Ways that a policy drove are drawn with their outcome in words."""

from __future__ import annotations

import numpy as np

from fpnav.report.figures.style import as_png, styled
from fpnav.report.figures.trips import draw_home, draw_way
from fpnav.store.tables import ACTION

PLACES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def two_trips() -> np.ndarray:
    rows = np.zeros(6, ACTION)
    rows["trip"] = [0, 0, 0, 1, 1, 1]
    rows["truth"][:, 0] = [1.4, 0.7, 0.1, 1.2, 1.1, 1.0]
    return rows


def test_trips_home_say_how_many_came_home() -> None:
    with styled():
        drawing = draw_home(two_trips(), np.zeros(2), PLACES)
    assert drawing.alt == "Ways of 2 trips to a goal: 1 end at it."
    assert as_png(drawing.figure).startswith(b"\x89PNG")


def test_a_way_is_drawn_as_taught_and_as_driven() -> None:
    way = np.column_stack([np.linspace(0.0, 2.0, 21), np.zeros(21)])
    with styled():
        drawing = draw_way(two_trips(), way, PLACES)
    labels = drawing.figure.axes[0].get_legend_handles_labels()[1]
    assert labels == ["taught", "driven", "places"]
