"""Floor plans: spaces that tile the floor, the walls that follow from them, holes in the walls."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fpnav.sim.solids import Material
from fpnav.sim.world import Door, Space
from fpnav.values import FloatArray

THICKNESS_M = 0.12
PAINT = Material()
OPEN_KINDS = frozenset({"corridor", "lobby"})
"""Spaces of these kinds have no wall between each other."""


@dataclass(frozen=True, slots=True)
class Opening:
    """Hole in the wall between spaces ``a`` and ``b`` (b empty: outside), ``at`` its middle.

    ``at`` counts along the wall's line, x (``along`` 0) or y (1). ``kind``: door, window, passage.
    ``leaf_rad``: NaN for none, else the angle the leaf is open by; it swings into ``a``.
    """

    a: str
    b: str
    at: float
    width_m: float
    kind: str = "door"
    along: int = 0
    sill_m: float = 0.0
    head_m: float = 2.05
    leaf_rad: float = math.nan
    hinge: int = 1
    colour: Material = PAINT
    frame: Material = PAINT


@dataclass(frozen=True, slots=True)
class Run:
    """Straight piece of wall along x (``along`` 0) or y (1) between two spaces or outside.

    It lies at ``at`` across, from ``start`` to ``end``; ``low`` is the space on the smaller side.
    """

    along: int
    at: float
    start: float
    end: float
    low: Space | None
    high: Space | None


def wall_runs(spaces: Sequence[Space]) -> list[Run]:
    """Walls of the plan: every edge between different spaces that is not open by kind."""
    runs: list[Run] = []
    for along in (0, 1):
        for at in sorted({_r(v) for s in spaces for v in _across(s, along)}):
            runs += _runs_on(spaces, along, at)
    return runs


def _across(space: Space, along: int) -> tuple[float, float]:
    return (space.y0, space.y1) if along == 0 else (space.x0, space.x1)


def _extent(space: Space, along: int) -> tuple[float, float]:
    return (space.x0, space.x1) if along == 0 else (space.y0, space.y1)


def _r(value: float) -> float:
    return round(value, 6)


def _runs_on(spaces: Sequence[Space], along: int, at: float) -> list[Run]:
    low = [s for s in spaces if _r(_across(s, along)[1]) == at]
    high = [s for s in spaces if _r(_across(s, along)[0]) == at]
    cuts = sorted({_r(v) for s in low + high for v in _extent(s, along)})
    runs = []
    for start, end in itertools.pairwise(cuts):
        middle = (start + end) / 2
        below, above = _covering(low, along, middle), _covering(high, along, middle)
        if _walled(below, above):
            runs.append(Run(along, at, start, end, below, above))
    return runs


def _covering(spaces: Iterable[Space], along: int, value: float) -> Space | None:
    for space in spaces:
        start, end = _extent(space, along)
        if start < value < end:
            return space
    return None


def _walled(low: Space | None, high: Space | None) -> bool:
    if low is None and high is None:
        return False
    both_open = low and high and low.kind in OPEN_KINDS and high.kind in OPEN_KINDS
    return not both_open


def belongs(hole: Opening, run: Run) -> bool:
    """Whether the opening is in that wall."""
    names = {run.low.name if run.low else "", run.high.name if run.high else ""}
    inside = run.along == hole.along and run.start <= hole.at <= run.end
    return inside and names == {hole.a, hole.b}


def place(run: Run, along: float, across: float, z: float) -> FloatArray:
    """Point of a wall: ``along`` it, ``across`` from its middle, at height ``z``."""
    if run.along == 0:
        return np.array([along, run.at + across, z])
    return np.array([run.at + across, along, z])


def doors_of(runs: Sequence[Run], openings: Sequence[Opening]) -> list[Door]:
    """Doors and passages of the plan as truth, named by their spaces."""
    doors = []
    for hole in openings:
        if hole.kind == "window":
            continue
        run = next(run for run in runs if belongs(hole, run))
        x, y, _ = place(run, hole.at, 0.0, 0.0)
        axis = math.pi / 2 if run.along == 0 else 0.0
        is_open = math.isnan(hole.leaf_rad) or hole.leaf_rad > math.radians(45)
        name = f"{hole.a}|{hole.b}"
        doors.append(Door(name, float(x), float(y), axis, hole.width_m, is_open, (hole.a, hole.b)))
    return doors


def segments(runs: Sequence[Run]) -> list[tuple[float, float, float, float]]:
    """Middle lines of the walls, (x0, y0, x1, y1)."""
    return [
        (run.start, run.at, run.end, run.at)
        if run.along == 0
        else (run.at, run.start, run.at, run.end)
        for run in runs
    ]
