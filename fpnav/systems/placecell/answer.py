"""From the views of a panorama to the activity of every place: eq. 1 to 4 in a row."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU, angular_distance
from fpnav.matching.patches import Patches
from fpnav.systems.placecell.compass import search_grid, visual_heading
from fpnav.systems.placecell.landmarks import recognise
from fpnav.systems.placecell.merging import cell_activity, diffusion, merge
from fpnav.systems.placecell.neurons import Neurons, Views
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Excitation:
    """Merging neurons excited, (m,) ascending, at each heading tried, (m, O)."""

    neurons: NDArray[np.int64]
    activity: FloatArray
    headings_rad: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CellAnswer:
    """Cells excited, (c,) ascending, their activity and the heading at which each is highest."""

    cells: NDArray[np.int64]
    activity: FloatArray
    headings_rad: FloatArray


def excite(
    neurons: Neurons,
    views: Views,
    headings_rad: FloatArray | None,
    params: PlacecellParams,
    cells: NDArray[np.bool_] | None = None,
) -> Excitation:
    """Merging neurons that views excite (eq. 1 and 2).

    Parameters
    ----------
    headings_rad : (O,) headings of the robot to try; None = what the landmarks vote for, and all
        around where none is recognised
    cells : (C,) cells whose landmarks take part in the competition; None = all
    """
    wiring, triplets = neurons.wiring, neurons.triplets
    allowed = None if cells is None else cells[triplets["cell"]]
    found = recognise(
        Patches.of(views.pixels, params.patch_rows, params.patch_columns),
        wiring.landmarks,
        params,
        None if allowed is None else _landmarks_of(triplets[allowed], len(wiring.landmarks)),
    )
    at, triplet = _expanded(found.landmark, wiring.order, wiring.first)
    if allowed is not None:
        at, triplet = at[allowed[triplet]], triplet[allowed[triplet]]
    rows = views.rows[found.view[at]]
    bearing, azimuth = rows["bearing_rad"].astype(np.float64), triplets["azimuth_rad"][triplet]
    rise = angular_distance(rows["elevation_rad"], triplets["elevation_rad"][triplet])
    level = found.level[at] * diffusion(rise, params.rho_el, params.diffusion)
    if headings_rad is None:
        headings_rad = _voted(level, bearing, azimuth, params)
    excited, activity = merge(
        triplet, level, bearing, azimuth, headings_rad, params.rho_az, params.diffusion
    )
    return Excitation(excited, activity, headings_rad)


def answer(neurons: Neurons, excitation: Excitation) -> CellAnswer:
    """Place cells' activity at the heading that suits each best (eq. 3 and 4)."""
    wiring = neurons.wiring
    weighted = excitation.activity * wiring.weight[excitation.neurons, None]
    cells, activity = cell_activity(
        excitation.neurons, weighted, neurons.triplets["cell"], wiring.keep, wiring.norm
    )
    best = np.argmax(activity, axis=1)
    headings = _refined(activity, best, excitation.headings_rad)
    return CellAnswer(cells, activity[np.arange(len(cells)), best], headings)


def at_best_heading(neurons: Neurons, excitation: Excitation) -> FloatArray:
    """Activity (M,) of every merging neuron at the heading that suits its cell best."""
    wiring = neurons.wiring
    seen = np.zeros(len(neurons.triplets))
    cells, activity = cell_activity(
        excitation.neurons,
        excitation.activity * wiring.weight[excitation.neurons, None],
        neurons.triplets["cell"],
        wiring.keep,
        wiring.norm,
    )
    best = np.zeros(len(neurons.cells), np.int64)
    best[cells] = np.argmax(activity, axis=1)
    column = best[neurons.triplets["cell"][excitation.neurons]]
    seen[excitation.neurons] = excitation.activity[np.arange(len(column)), column]
    return seen


def by_place(neurons: Neurons, found: CellAnswer) -> tuple[FloatArray, FloatArray]:
    """Activity (P,) of each place, that of its best cell, and the turn (P,) since its frame's.

    The turn is the query's heading minus that of the place's first observation, in [-pi, pi), NaN
    where no cell of the place answers.
    """
    wiring = neurons.wiring
    score = np.zeros(len(wiring.places))
    turn = np.full(len(wiring.places), np.nan)
    order = np.argsort(found.activity, kind="stable")
    cells = found.cells[order]
    score[wiring.column[cells]] = found.activity[order]
    origin = neurons.cells["origin_rad"][cells]
    relative = (found.headings_rad[order] - origin + math.pi) % TAU - math.pi
    turn[wiring.column[cells]] = relative
    return score, turn


def _landmarks_of(triplets: NDArray[Any], count: int) -> NDArray[np.bool_]:
    wanted = np.zeros(count, np.bool_)
    wanted[triplets["landmark"]] = True
    return wanted


def _expanded(
    landmark: NDArray[np.int64], order: NDArray[np.int64], first: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Every triplet of every recognised landmark: row of the recognition, and triplet."""
    counts = first[landmark + 1] - first[landmark]
    at = np.repeat(np.arange(len(landmark)), counts)
    within = np.arange(len(at)) - np.repeat(np.cumsum(counts) - counts, counts)
    return at, order[first[landmark[at]] + within]


def _voted(
    level: FloatArray, bearing: FloatArray, azimuth: FloatArray, params: PlacecellParams
) -> FloatArray:
    heading = visual_heading(level, bearing, azimuth)
    if math.isnan(heading):
        return search_grid(math.radians(params.search_deg))
    return np.array([heading])


def _refined(activity: FloatArray, best: NDArray[np.int64], headings_rad: FloatArray) -> FloatArray:
    """Headings between those tried, by a parabola through the best and its neighbours."""
    tried = len(headings_rad)
    if tried < 3:
        return np.asarray(headings_rad[best], dtype=np.float64)
    rows = np.arange(len(best))
    before, after = activity[rows, best - 1], activity[rows, (best + 1) % tried]
    bend = before - 2.0 * activity[rows, best] + after
    shift = np.where(bend < 0.0, 0.5 * (before - after) / np.where(bend < 0.0, bend, 1.0), 0.0)
    return np.asarray(headings_rad[best] + np.clip(shift, -0.5, 0.5) * TAU / tried)
