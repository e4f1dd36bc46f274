"""What the place cells learned of one map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.matching.patches import Patches
from fpnav.matching.ranking import ranked
from fpnav.systems.base import Recall, State, Trace
from fpnav.systems.placecell.answer import (
    CellAnswer,
    Excitation,
    answer,
    at_best_heading,
    by_place,
    excite,
)
from fpnav.systems.placecell.frames import (
    cell_headings,
    learning_heading,
    query_headings,
    turn_of_place,
)
from fpnav.systems.placecell.growing import Growing
from fpnav.systems.placecell.landmarks import reusable
from fpnav.systems.placecell.neurons import TRIPLET, Neurons, Views, neuron_azimuth
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.systems.placecell.selection import EVIDENCE, select, worth_of
from fpnav.systems.placecell.stream import Stream, explorations, lasts, remembered, resumed
from fpnav.values import FloatArray, Reference, Signature

STATE = ("pixels", "triplets", "cells", "evidence", "current")


class PlacecellMemory:
    """Place cells by place, recruited in one shot."""

    def __init__(self, params: PlacecellParams) -> None:
        self._params = params
        self._neurons = Neurons(params)
        self._evidence = Growing(EVIDENCE)
        self._observations = 0
        self._current = -1
        self._began_m = math.nan

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, increasing."""
        return np.unique(self._neurons.cells["place"]).astype(np.int64)

    @property
    def landmarks(self) -> int:
        """Number of stored views."""
        return len(self._neurons.landmarks)

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Nothing: cells learn in one shot, from one panorama each."""

    def learn(self, place: int, signature: Signature) -> None:
        """Recruit a cell for a new place; see a known one again.

        A known place recruits a further cell where the parameters allow more and its own are less
        active than ``cell_vigilance``.
        """
        views, own = views_of(signature, self._params), self._neurons.cells["place"] == place
        if self._current != place:
            self._current, self._began_m = place, signature.reference.travelled_m
        if own.any():
            active = self._seen_again(own, signature.reference, views)
            full = 0 < self._params.cells <= np.count_nonzero(own)
            if full or active >= self._params.cell_vigilance:
                return
        self._recruit(place, signature.reference, views)

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """1 - activity of the cell that founded the present place.

        With ``spacing_m`` 1 after every so many metres of travel and 0 between.
        Within ``refractory`` signatures of the last new place it stays below the threshold.
        """
        places = self.places
        stream = self._resumed(trace)
        if len(places) == 0:
            return 1.0, stream
        if self._params.spacing_m > 0.0:
            gone = signature.reference.travelled_m - self._began_m
            return float(gone >= self._params.spacing_m), stream
        since = 0 if stream.places != len(places) else stream.since + 1
        found, stream = self._asked(signature, None, stream)
        stream = replace(stream, places=len(places), since=since)
        founder = np.argmax(self._neurons.cells["place"] == self._current)
        novelty = 1.0 - float(found.activity[found.cells == founder].sum())
        if since < self._params.refractory:
            novelty = min(novelty, math.nextafter(1.0 - self._params.vigilance, 0.0))
        return max(novelty, 0.0), stream

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places whose cells are most active."""
        places, stream = self.places, self._resumed(trace)
        scores = np.zeros((len(signatures), len(places)))
        headings = np.full(scores.shape, np.nan)
        for row, signature in enumerate(signatures):
            mask = None if allowed is None else allowed[row]
            found, stream = self._asked(signature, mask, stream)
            scores[row], headings[row] = by_place(self._neurons, found)
        columns, values = ranked(scores, k, allowed)
        named = np.where(columns >= 0, np.append(places, -1)[columns], -1)
        turns = np.take_along_axis(np.pad(headings, ((0, 0), (0, 1))), columns, axis=1)
        return Recall(named, values, np.where(columns >= 0, turns, np.nan)), stream

    def merge(self, keep: int, drop: int) -> None:
        """Give the cells of ``drop`` to ``keep``, whose activity is that of its best cell."""
        turn = turn_of_place(keep, drop, self._neurons, self._params)
        self._neurons.fuse(keep, drop, turn)
        self._current = keep if self._current == drop else self._current

    def shrink(self, budget: int) -> None:
        """Keep at most ``budget`` triplets a place: those that tell it best from the others."""
        if budget <= 0:
            return
        owner = self._neurons.cells["place"][self._neurons.triplets["cell"]]
        kept = np.ones(len(owner), bool)
        evidence, elsewhere = self._evidence.rows, None
        for place in self.places:
            own = np.flatnonzero(owner == place)
            if len(own) > budget:
                elsewhere = self._elsewhere() if elsewhere is None else elsewhere
                kept[own] = False
                kept[own[select(worth_of(evidence, own, elsewhere[own]), budget)]] = True
        if not kept.all():
            number = np.cumsum(kept) - 1
            rows = evidence[kept[evidence["triplet"]]].copy()
            rows["triplet"] = number[rows["triplet"]]
            self._evidence.replace(rows)
            self._neurons.keep_triplets(kept)

    def save(self) -> State:
        """Landmarks, triplets, cells, and what selecting them needs."""
        return {
            **self._neurons.save(),
            "evidence": self._evidence.rows,
            "current": np.array([self._current, self._observations], np.int64),
        }

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved.

        Raises
        ------
        StoreError
            An array is missing, or they do not fit together.
        """
        missing = [name for name in STATE if name not in state]
        if missing:
            raise StoreError(
                f"the place cell memory lacks {', '.join(missing)}; found {', '.join(state)}; "
                "build the map again"
            )
        self._neurons.load(state)
        self._evidence.replace(state["evidence"])
        self._current, self._observations = (int(value) for value in state["current"])

    def _recruit(self, place: int, reference: Reference, views: Views) -> None:
        params, cells = self._params, self._neurons.cells
        heading = learning_heading(place, reference, views, self._neurons, params)
        own = cells["place"] == place
        origin = float(cells["origin_rad"][own][0]) if own.any() else heading
        rows = np.zeros(len(views.rows), TRIPLET)
        rows["azimuth_rad"] = neuron_azimuth(
            views.rows["bearing_rad"].astype(np.float64) + heading, params.azimuth_bins
        )
        rows["elevation_rad"] = views.rows["elevation_rad"]
        patches = Patches.of(views.pixels, params.patch_rows, params.patch_columns)
        rows["landmark"] = reusable(patches, self._neurons.landmarks, params)
        odometry = math.nan if reference.odometry is None else reference.odometry.heading_rad
        cell = (place, origin, heading, odometry, reference.heading_rad, reference.session, 0)
        first = len(self._neurons.triplets)
        self._neurons.recruit(cell, rows, views.pixels[rows["landmark"] < 0])
        self._noted(np.arange(first, first + len(rows)), np.ones(len(rows)))

    def _seen_again(self, own: NDArray[np.bool_], reference: Reference, views: Views) -> float:
        """Note which triplets of a place a panorama of it excites; its activity."""
        neurons = self._neurons
        headings = query_headings(reference, neurons, self._params)
        excitation = excite(neurons, views, headings, self._params, own)
        activity = at_best_heading(neurons, excitation)[excitation.neurons]
        self._noted(excitation.neurons, activity)
        neurons.visited(own, excitation.neurons[activity > 0.0])
        return float(answer(neurons, excitation).activity.max(initial=0.0))

    def _noted(self, triplets: NDArray[np.int64], activity: FloatArray) -> None:
        rows = np.zeros(len(triplets), EVIDENCE)
        rows["observation"], rows["triplet"] = self._observations, triplets
        rows["activity"] = activity
        self._evidence.extend(rows[activity > 0.0])
        self._observations += 1

    def _elsewhere(self) -> FloatArray:
        """Best activity (M,) of each triplet at a panorama learned for another place."""
        neurons, place = self._neurons, self._neurons.cells["place"]
        best = np.zeros(len(neurons.triplets))
        for cell in range(len(place)):
            headings = cell_headings(cell, neurons, self._params)
            found = excite(neurons, neurons.views_of(cell), headings, self._params)
            other = place[neurons.triplets["cell"][found.neurons]] != place[cell]
            strongest = found.activity[other].max(axis=1, initial=0.0)
            best[found.neurons[other]] = np.maximum(best[found.neurons[other]], strongest)
        return best

    def _resumed(self, trace: Trace) -> Stream:
        neurons = self._neurons
        return resumed(trace, neurons.version, len(neurons.triplets), self._params.qmax)

    def _asked(
        self, signature: Signature, allowed: NDArray[np.bool_] | None, stream: Stream
    ) -> tuple[CellAnswer, Stream]:
        """Activity of the cells of the allowed places after one more signature."""
        neurons, params = self._neurons, self._params
        cells = None if allowed is None else allowed[neurons.wiring.column]
        headings = query_headings(signature.reference, neurons, params)
        views = views_of(signature, params)
        if not lasts(params):
            return answer(neurons, excite(neurons, views, headings, params, cells)), stream
        if params.stm == "literal":
            headings = _one_heading(
                answer(neurons, excite(neurons, views, headings, params, cells))
            )
        for part, fires in explorations(views, params, begun=stream.begun):
            now = excite(neurons, part, headings, params, cells)
            seen = at_best_heading(neurons, now)
            stream = remembered(stream, seen, fires=fires, params=params)
        heading = float(headings[0]) if headings is not None and len(headings) == 1 else math.nan
        return _held(neurons, stream, answer(neurons, now), cells, heading), stream


def views_of(signature: Signature, params: PlacecellParams) -> Views:
    """Local views of a signature."""
    pixels = signature.parts["pixels"].reshape(-1, params.pixels)
    return Views(signature.parts["views"], pixels)


def _one_heading(found: CellAnswer) -> FloatArray:
    """Heading of the most active cell; 0 where none is active."""
    if len(found.cells) == 0:
        return np.zeros(1)
    return np.array([found.headings_rad[np.argmax(found.activity)]])


def _held(
    neurons: Neurons,
    stream: Stream,
    now: CellAnswer,
    cells: NDArray[np.bool_] | None,
    heading_rad: float,
) -> CellAnswer:
    """Activity of the cells from what the merging neurons hold; headings as seen now.

    ``heading_rad`` : that of the robot where it is known, for cells that nothing seen now excites
    """
    m = stream.held.m
    if cells is not None:
        m = np.where(cells[neurons.triplets["cell"]], m, 0.0)
    active = np.flatnonzero(m)
    found = answer(neurons, Excitation(active, m[active, None], np.full(1, np.nan)))
    headings = np.full(len(neurons.cells), heading_rad)
    headings[now.cells] = now.headings_rad
    return CellAnswer(found.cells, found.activity, headings[found.cells])
