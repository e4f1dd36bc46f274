"""In which frame azimuths are stored, and what heading a panorama is given in it.

Absolute: all cells share one frame, that of the compass, of odometry, or of the first panorama as
carried on by its landmarks (visual). Relative: every place has the frame of the robot at its first
panorama, and a query's heading is searched for; so it is, too, where the first panorama learned
had no heading of the kind asked for.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.placecell.answer import answer, excite
from fpnav.systems.placecell.compass import search_grid
from fpnav.systems.placecell.neurons import Neurons, Views
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import FloatArray, Reference


def stated(reference: Reference, source: str) -> float:
    """Heading a frame states, NaN where it has none of that source."""
    if source == "compass":
        return reference.heading_rad
    if source == "odometry" and reference.odometry is not None:
        return reference.odometry.heading_rad
    return math.nan


def is_absolute(neurons: Neurons, params: PlacecellParams) -> bool:
    """Whether the cells learned share a frame."""
    if len(neurons.cells) == 0 or params.heading in ("search", "visual"):
        return params.heading == "visual"
    return bool(np.isfinite(neurons.cells[0][f"{params.heading}_rad"]))


def query_headings(
    reference: Reference, neurons: Neurons, params: PlacecellParams
) -> FloatArray | None:
    """Headings to try for a query, (O,); None = what the landmarks vote for."""
    if params.heading == "visual":
        return None
    heading = stated(reference, params.heading)
    if is_absolute(neurons, params) and math.isfinite(heading):
        return np.array([heading])
    return search_grid(math.radians(params.search_deg))


def cell_headings(cell: int, neurons: Neurons, params: PlacecellParams) -> FloatArray:
    """Headings to try for the panorama a cell was learned from."""
    if is_absolute(neurons, params):
        return np.array([neurons.cells[cell]["heading_rad"]])
    return search_grid(math.radians(params.search_deg))


def learning_heading(
    place: int, reference: Reference, views: Views, neurons: Neurons, params: PlacecellParams
) -> float:
    """Heading, in the frame its azimuths are stored in, of a panorama about to be learned."""
    cells = neurons.cells
    if is_absolute(neurons, params) or len(cells) == 0:
        heading = stated(reference, params.heading)
        near = np.arange(len(cells))
    else:
        heading = math.nan
        near = np.flatnonzero(cells["place"] == place)
    if math.isfinite(heading):
        return heading
    if len(near) == 0:
        return 0.0
    heading = float(cells[near[-1]]["heading_rad"]) + turn_since(cells[near[-1]], reference)
    if math.isfinite(heading):
        return heading
    return _seen_heading(views, neurons, params, np.isin(np.arange(len(cells)), near))


def turn_since(cell: Any, reference: Reference) -> float:
    """Turn of the robot since a cell was learned, NaN where nothing tells.

    Odometry within a session, which drifts little between near frames, else the compass.
    """
    turn = math.nan
    if reference.session == cell["session"]:
        turn = stated(reference, "odometry") - float(cell["odometry_rad"])
    return turn if math.isfinite(turn) else reference.heading_rad - float(cell["compass_rad"])


def turn_of_place(keep: int, drop: int, neurons: Neurons, params: PlacecellParams) -> float:
    """Turn that brings azimuths of place ``drop`` into the frame of place ``keep``."""
    if is_absolute(neurons, params):
        return 0.0
    cells = neurons.cells
    first = int(np.argmax(cells["place"] == drop))
    own = cells[first]
    other = cells[cells["place"] == keep][0]
    turn = math.nan
    if own["session"] == other["session"]:
        turn = float(own["odometry_rad"] - other["odometry_rad"])
    if not math.isfinite(turn):
        turn = float(own["compass_rad"] - other["compass_rad"])
    heading = float(other["heading_rad"]) + turn
    if not math.isfinite(heading):
        views = neurons.views_of(first)
        heading = _seen_heading(views, neurons, params, cells["place"] == keep)
    return heading - float(own["heading_rad"])


def _seen_heading(
    views: Views, neurons: Neurons, params: PlacecellParams, cells: NDArray[np.bool_]
) -> float:
    """Heading at which the given cells answer a panorama best; 0 where none does."""
    grid = search_grid(math.radians(params.search_deg))
    found = answer(neurons, excite(neurons, views, grid, params, cells))
    if len(found.cells) == 0:
        return 0.0
    return float(found.headings_rad[np.argmax(found.activity)])
