"""What was recruited: landmarks, merging neurons (triplets) and place cells, as growing columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.geometry import TAU
from fpnav.matching.patches import Patches
from fpnav.systems.base import State
from fpnav.systems.placecell.extract import VIEW
from fpnav.systems.placecell.growing import Growing
from fpnav.systems.placecell.merging import counted
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.values import FloatArray

TRIPLET = np.dtype(
    [
        ("landmark", "<i4"),
        ("cell", "<i4"),
        ("azimuth_rad", "<f8"),
        ("elevation_rad", "<f8"),
        ("seen", "<i4"),
    ]
)
"""A merging neuron: landmark, direction, the cell it belongs to, times it was seen again there."""

CELL = np.dtype(
    [
        ("place", "<i8"),
        ("origin_rad", "<f8"),
        ("heading_rad", "<f8"),
        ("odometry_rad", "<f8"),
        ("compass_rad", "<f8"),
        ("session", "<i4"),
        ("visits", "<i4"),
    ]
)
"""A place cell. Its azimuths are in a frame in which the robot's heading was ``heading_rad`` when
it was learned, and ``origin_rad`` when its place was; ``visits`` counts observations after."""


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """Local views of one exploration: rows of VIEW (n,) and pixels (n, D)."""

    rows: NDArray[Any]
    pixels: NDArray[np.uint8]

    def take(self, which: NDArray[np.int64]) -> Views:
        """Some of the views, in the order given."""
        return Views(self.rows[which], self.pixels[which])


@dataclass(frozen=True, slots=True, eq=False)
class Wiring:
    """What recall needs of the neurons, made once per state of the memory.

    ``order``, ``first`` : triplets by landmark, and where each landmark's begin (L + 1,);
    ``keep``, ``norm`` : (C,) triplets that count and the sum they may reach; ``weight`` (M,);
    ``places`` (P,) ids ascending, ``column`` (C,) of each cell's place.
    """

    landmarks: Patches
    order: NDArray[np.int64]
    first: NDArray[np.int64]
    keep: NDArray[np.int64]
    norm: FloatArray
    weight: FloatArray
    places: NDArray[np.int64]
    column: NDArray[np.int64]


class Neurons:
    """Growing columns of landmarks, triplets and cells; a cell's triplets follow one another."""

    def __init__(self, params: PlacecellParams) -> None:
        self._params = params
        self._pixels = Growing(np.uint8, params.pixels)
        self._means = Growing(np.uint8, len(self._patches_of_none().means[0]))
        self._triplets = Growing(TRIPLET)
        self._cells = Growing(CELL)
        self._wiring: Wiring | None = None
        self.version = 0

    @property
    def triplets(self) -> NDArray[Any]:
        """(M,) TRIPLET, by cell."""
        return self._triplets.rows

    @property
    def cells(self) -> NDArray[Any]:
        """(C,) CELL, in the order of learning."""
        return self._cells.rows

    @property
    def landmarks(self) -> Patches:
        """The stored views, (L,)."""
        return Patches(self._pixels.rows, self._means.rows, self._per_block)

    @property
    def wiring(self) -> Wiring:
        """Derived columns of the present state."""
        if self._wiring is None:
            self._wiring = self._wired()
        return self._wiring

    def recruit(self, cell: tuple[Any, ...], triplets: NDArray[Any], pixels: Any) -> None:
        """Add a cell with its triplets, and the landmarks ``pixels`` (n, D) they need anew.

        A triplet with landmark -1 takes the next new landmark.
        """
        rows = triplets.copy()
        new = rows["landmark"] < 0
        rows["landmark"][new] = len(self._pixels) + np.arange(np.count_nonzero(new))
        rows["cell"] = len(self._cells)
        self._pixels.extend(pixels)
        self._means.extend(self._patches(pixels).means)
        self._triplets.extend(rows)
        self._cells.extend(np.array([cell], CELL))
        self._wiring = None

    def visited(self, cells: NDArray[np.bool_], triplets: NDArray[np.int64]) -> None:
        """Count an observation of the given cells, and the triplets it showed."""
        self.cells["visits"][cells] += 1
        self.triplets["seen"][triplets] += 1
        if self._params.weights != "equal":
            self._wiring = None

    def span(self, cell: int) -> tuple[int, int]:
        """First triplet of a cell, and the one after its last."""
        first, last = np.searchsorted(self.triplets["cell"], [cell, cell + 1])
        return int(first), int(last)

    def views_of(self, cell: int) -> Views:
        """The views a cell was learned from, as the robot saw them."""
        first, last = self.span(cell)
        own = self.triplets[first:last]
        rows = np.zeros(len(own), VIEW)
        rows["bearing_rad"] = own["azimuth_rad"] - self.cells["heading_rad"][cell]
        rows["elevation_rad"] = own["elevation_rad"]
        return Views(rows, self._pixels.rows[own["landmark"]])

    def fuse(self, keep: int, drop: int, turn_rad: float) -> None:
        """Give the cells of one place to another, their azimuths turned."""
        cells, triplets = self.cells, self.triplets
        origin = cells["origin_rad"][np.argmax(cells["place"] == keep)]
        moved = cells["place"] == drop
        turned = moved[triplets["cell"]]
        triplets["azimuth_rad"][turned] = np.mod(triplets["azimuth_rad"][turned] + turn_rad, TAU)
        cells["heading_rad"][moved] += turn_rad
        cells["origin_rad"][moved] = origin
        cells["place"][moved] = keep
        self._changed()

    def keep_triplets(self, rows: NDArray[np.bool_]) -> None:
        """Forget all other triplets, and the landmarks no triplet needs any more."""
        triplets = self.triplets[rows]
        needed, named = np.unique(triplets["landmark"], return_inverse=True)
        triplets["landmark"] = named
        self._triplets.replace(triplets)
        self._pixels.replace(self._pixels.rows[needed])
        self._means.replace(self._means.rows[needed])
        self._changed()

    def save(self) -> State:
        """All columns."""
        return {
            "pixels": self._pixels.rows.ravel(),
            "triplets": self.triplets,
            "cells": self.cells,
        }

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the columns that were saved; raises StoreError where they do not fit together."""
        pixels, triplets, cells = (
            np.asarray(state[name]) for name in ("pixels", "triplets", "cells")
        )
        size = self._params.pixels
        sound = len(pixels) % size == 0
        for column, count in (("landmark", len(pixels) // size), ("cell", len(cells))):
            sound = sound and bool(np.all((triplets[column] >= 0) & (triplets[column] < count)))
        if not sound or np.any(np.diff(triplets["cell"]) < 0):
            raise StoreError(
                f"the place cell memory holds {len(pixels)} pixels, {len(triplets)} triplets and "
                f"{len(cells)} cells that do not fit together for views of {size} pixels; "
                "build the map again"
            )
        views = pixels.reshape(-1, size)
        self._pixels.replace(views)
        self._means.replace(self._patches(views).means)
        self._triplets.replace(triplets)
        self._cells.replace(cells)
        self._changed()

    def _changed(self) -> None:
        """Triplets were renumbered or moved: what streams remember of them is void."""
        self._wiring = None
        self.version += 1

    @property
    def _per_block(self) -> int:
        return self._patches_of_none().per_block

    def _patches_of_none(self) -> Patches:
        return self._patches(np.zeros((1, self._params.pixels), np.uint8))

    def _patches(self, pixels: Any) -> Patches:
        return Patches.of(pixels, self._params.patch_rows, self._params.patch_columns)

    def _wired(self) -> Wiring:
        triplets, cells = self.triplets, self.cells
        order = np.argsort(triplets["landmark"], kind="stable")
        landmarks = np.arange(len(self._pixels) + 1)
        first = np.searchsorted(triplets["landmark"][order], landmarks)
        weight = self._weights()
        keep = counted(np.bincount(triplets["cell"], minlength=len(cells)), self._params.rho_l)
        places, column = np.unique(cells["place"], return_inverse=True)
        return Wiring(
            self.landmarks,
            order,
            first,
            keep,
            _attainable(triplets["cell"], weight, keep),
            weight,
            places.astype(np.int64),
            column.astype(np.int64),
        )

    def _weights(self) -> FloatArray:
        """1 each, or the mean of the Beta posterior of being seen again, 1 before any visit."""
        triplets = self.triplets
        if self._params.weights == "equal":
            return np.ones(len(triplets))
        visits = self.cells["visits"][triplets["cell"]]
        return np.asarray(2.0 * (1.0 + triplets["seen"]) / (2.0 + visits))


def _attainable(cell: NDArray[Any], weight: FloatArray, keep: NDArray[np.int64]) -> FloatArray:
    """Sum of each cell's ``keep`` largest weights; 1 for a cell without triplets."""
    order = np.lexsort((-weight, cell))
    first = np.searchsorted(cell, np.arange(len(keep)))
    rank = np.empty(len(cell), np.int64)
    rank[order] = np.arange(len(cell)) - first[cell[order]]
    counts = rank < keep[cell] if len(cell) else np.zeros(0, bool)
    total = np.bincount(cell[counts], weights=weight[counts], minlength=len(keep))
    return np.asarray(np.where(total > 0.0, total, 1.0))


def neuron_azimuth(azimuth_rad: FloatArray, bins: int) -> FloatArray:
    """Preferred azimuth of the most active neuron in [0, 2 pi); the azimuth itself for 0 bins."""
    if bins == 0:
        return np.mod(azimuth_rad, TAU)
    width = TAU / bins
    nearest = np.floor(np.mod(azimuth_rad, TAU) / width + 0.5) % bins
    return np.asarray(nearest * width)
