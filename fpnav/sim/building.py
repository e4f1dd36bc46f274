"""Floors built from their plan: walls with thickness, reveals, doors, windows, ceilings.

What is built follows from the plan alone, so plan, doors and what sensors see cannot disagree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fpnav.sim.plan import THICKNESS_M, Opening, Run, belongs, place
from fpnav.sim.rooms import Furnished
from fpnav.sim.solids import Face, Material, box, picture, rectangles, sheet
from fpnav.sim.world import Space
from fpnav.values import FloatArray

FRAME_M = 0.07


@dataclass(frozen=True, slots=True)
class Finish:
    """Surfaces of a space."""

    wall: Material
    floor: Material
    ceiling: Material
    height_m: float = 2.7
    dado: Material | None = None
    dado_m: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """One floor, ready to be built; ``furnished`` and ``finishes`` go by the space's name."""

    spaces: tuple[Space, ...]
    runs: tuple[Run, ...]
    openings: tuple[Opening, ...]
    finishes: dict[str, Finish]
    furnished: dict[str, Furnished]
    outside: Material

    def faces(self) -> list[Face]:
        """Everything that stands."""
        return [
            *wall_faces(self.runs, self.openings, self.finishes, self.outside),
            *floor_faces(self.spaces, self.finishes),
            *(face for hole in self.openings for face in door_faces(self.runs, hole)),
            *(face for room in self.furnished.values() for face in room.faces()),
        ]


def wall_faces(
    runs: Sequence[Run],
    openings: Sequence[Opening],
    finishes: dict[str, Finish],
    outside: Material,
) -> list[Face]:
    """Both sides of every wall, its ends, and the reveals of its openings."""
    faces: list[Face] = []
    for run in runs:
        holes = [hole for hole in openings if belongs(hole, run)]
        height = max(finishes[s.name].height_m for s in (run.low, run.high) if s is not None)
        before, after = _caps(run, runs)
        for side, space in ((-1, run.low), (1, run.high)):
            finish = finishes[space.name] if space else None
            faces += _side(run, side, finish, outside, holes, height, before, after)
        faces += _ends(run, runs, height, _paint(run, finishes, outside))
        for hole in holes:
            faces += _reveal(run, hole)
    return faces


def _caps(run: Run, runs: Sequence[Run]) -> tuple[float, float]:
    """How far the wall reaches past its ends: half a thickness at a corner, nothing at a tee."""
    return tuple(_cap(run, runs, end) for end in (run.start, run.end))  # type: ignore[return-value]


def _cap(run: Run, runs: Sequence[Run], end: float) -> float:
    goes_on = any(
        r.along == run.along and r.at == run.at and end in (r.start, r.end) and r is not run
        for r in runs
    )
    crossing = [r for r in runs if r.along != run.along and r.at == end]
    tee = any(r.start < run.at < r.end for r in crossing) or (
        any(r.end == run.at for r in crossing) and any(r.start == run.at for r in crossing)
    )
    return 0.0 if goes_on or tee else THICKNESS_M / 2


def _open_end(run: Run, runs: Sequence[Run], end: float) -> bool:
    """Whether the wall stops with no other wall at its end."""
    touching = (
        r is not run
        and (
            (r.along == run.along and r.at == run.at and end in (r.start, r.end))
            or (r.along != run.along and r.at == end and r.start <= run.at <= r.end)
        )
        for r in runs
    )
    return not any(touching)


def _paint(run: Run, finishes: dict[str, Finish], outside: Material) -> Material:
    space = run.low or run.high
    return finishes[space.name].wall if space else outside


def _side(
    run: Run,
    side: int,
    finish: Finish | None,
    outside: Material,
    holes: Sequence[Opening],
    height: float,
    before: float,
    after: float,
) -> list[Face]:
    """The wall's face towards one side, in bands (dado), with holes cut out."""
    bands = [(0.0, height, finish.wall if finish else outside)]
    if finish and finish.dado:
        bands = [(0.0, finish.dado_m, finish.dado), (finish.dado_m, height, finish.wall)]
    length = run.end - run.start + before + after
    holes_st = [_hole(run, side, hole, before, length) for hole in holes]
    faces = []
    for low, high, material in bands:
        pieces = _cut((0.0, low, length, high), holes_st)
        face = sheet((0, 0, 0), (1, 0, 0), (0, 0, 1), material)
        start = run.start - before if side < 0 else run.end + after
        origin = place(run, start, side * THICKNESS_M / 2, 0.0)
        u = np.array(_vector(run, 1.0 if side < 0 else -1.0))
        if run.along == 1:
            origin, u = _mirror(run, side, before, after)
        faces.append(replace(face, origin=origin, u=u, triangles=pieces))
    return [face for face in faces if len(face.triangles)]


def _mirror(run: Run, side: int, before: float, after: float) -> tuple[FloatArray, FloatArray]:
    """A wall along y shows its -x side when read from high y to low y."""
    start = run.end + after if side < 0 else run.start - before
    u = np.array([0.0, -1.0, 0.0]) if side < 0 else np.array([0.0, 1.0, 0.0])
    return place(run, start, side * THICKNESS_M / 2, 0.0), u


def _hole(
    run: Run, side: int, hole: Opening, before: float, length: float
) -> tuple[float, float, float, float]:
    """The opening in the face's own coordinates (s0, t0, s1, t1)."""
    start = hole.at - hole.width_m / 2 - run.start + before
    forward = (side < 0) == (run.along == 0)
    s0 = start if forward else length - start - hole.width_m
    return s0, hole.sill_m, s0 + hole.width_m, hole.head_m


def _cut(
    area: tuple[float, float, float, float], holes: Sequence[tuple[float, float, float, float]]
) -> FloatArray:
    """Triangles of a rectangle without the holes."""
    s0, t0, s1, t1 = area
    pieces, s = [], s0
    for h0, low, h1, high in sorted(holes):
        pieces.append((s, t0, h0, t1))
        pieces.append((h0, t0, h1, min(max(low, t0), t1)))
        pieces.append((h0, max(min(high, t1), t0), h1, t1))
        s = h1
    pieces.append((s, t0, s1, t1))
    return rectangles([p for p in pieces if p[2] - p[0] > 1e-6 and p[3] - p[1] > 1e-6])


def _vector(run: Run, length: float) -> tuple[float, float, float]:
    return (length, 0.0, 0.0) if run.along == 0 else (0.0, length, 0.0)


def _ends(run: Run, runs: Sequence[Run], height: float, paint: Material) -> list[Face]:
    """Narrow ends of a wall that stops in the open."""
    half = THICKNESS_M / 2
    faces = []
    for end, facing in ((run.start, -1), (run.end, 1)):
        if _open_end(run, runs, end):
            at = end + facing * half
            faces.append(_strip(run, at, -half, half, 0.0, height, facing, paint))
    return faces


def _strip(
    run: Run,
    along: float,
    across0: float,
    across1: float,
    z0: float,
    z1: float,
    facing: int,
    paint: Material,
) -> Face:
    """Upright strip across the wall, facing the wall's positive (1) or negative (-1) direction."""
    low, high = place(run, along, across0, z0), place(run, along, across1, z0)
    start, end = (low, high) if (facing > 0) == (run.along == 0) else (high, low)
    return sheet(start, end - start, (0.0, 0.0, z1 - z0), paint)


def _reveal(run: Run, hole: Opening) -> list[Face]:
    """Inner sides, head and sill of an opening."""
    half = THICKNESS_M / 2
    left, right = hole.at - hole.width_m / 2, hole.at + hole.width_m / 2
    faces = [
        _strip(run, left, -half, half, hole.sill_m, hole.head_m, 1, hole.frame),
        _strip(run, right, -half, half, hole.sill_m, hole.head_m, -1, hole.frame),
    ]
    a, b = place(run, left, -half, hole.head_m), place(run, right, half, hole.head_m)
    x, y = np.array([b[0] - a[0], 0.0, 0.0]), np.array([0.0, b[1] - a[1], 0.0])
    faces.append(sheet(a, y, x, hole.frame))
    if hole.sill_m > 0.0:
        faces.append(sheet(place(run, left, -half, hole.sill_m), x, y, hole.frame))
    return faces


def floor_faces(spaces: Sequence[Space], finishes: dict[str, Finish]) -> list[Face]:
    """Floor and ceiling of every space."""
    faces = []
    for space in spaces:
        finish = finishes[space.name]
        w, d, h = space.x1 - space.x0, space.y1 - space.y0, finish.height_m
        faces.append(sheet((space.x0, space.y0, 0), (w, 0, 0), (0, d, 0), finish.floor))
        faces.append(sheet((space.x0, space.y0, h), (0, d, 0), (w, 0, 0), finish.ceiling))
    return faces


def door_faces(runs: Sequence[Run], opening: Opening) -> list[Face]:
    """Frame and leaf of a door; glass in a window."""
    run = next(run for run in runs if belongs(opening, run))
    faces = _frame(run, opening)
    if opening.kind == "window":
        faces += _pane(run, opening)
    if not math.isnan(opening.leaf_rad):
        faces += _leaf(run, opening)
    return faces


def _frame(run: Run, hole: Opening) -> list[Face]:
    half = THICKNESS_M / 2 + 0.015
    left, right = hole.at - hole.width_m / 2, hole.at + hole.width_m / 2
    bars = [
        (left - FRAME_M, left, hole.sill_m, hole.head_m + FRAME_M),
        (right, right + FRAME_M, hole.sill_m, hole.head_m + FRAME_M),
        (left, right, hole.head_m, hole.head_m + FRAME_M),
    ]
    faces = []
    for a, b, z0, z1 in bars:
        p, q = place(run, a, -half, z0), place(run, b, half, z1)
        faces += box(np.minimum(p, q).tolist(), np.maximum(p, q).tolist(), hole.frame, bottom=True)
    return faces


def _pane(run: Run, hole: Opening) -> list[Face]:
    glass = Material(glass=True, rough=0.0)
    left = hole.at - hole.width_m / 2
    pane = sheet(
        place(run, left, 0.0, hole.sill_m),
        _vector(run, hole.width_m),
        (0, 0, hole.head_m - hole.sill_m),
        glass,
    )
    bar = 0.025
    low = place(run, hole.at - bar, -bar, hole.sill_m)
    high = place(run, hole.at + bar, bar, hole.head_m)
    return [pane, *box(low.tolist(), high.tolist(), hole.frame)]


def _leaf(run: Run, hole: Opening) -> list[Face]:
    """Door leaf hinged at the low (hinge -1) or high (1) end, swung into space ``a``."""
    into = -1 if run.low is not None and run.low.name == hole.a else 1
    hinge = hole.at + hole.hinge * hole.width_m / 2
    pivot = place(run, hinge, into * THICKNESS_M / 2 if hole.leaf_rad else 0.0, 0.0)
    shut = np.array(_vector(run, -float(hole.hinge)))
    away = np.array([0.0, into, 0.0]) if run.along == 0 else np.array([into, 0.0, 0.0])
    c, s = math.cos(hole.leaf_rad), math.sin(hole.leaf_rad)
    reach = shut * c + away * s
    return slab(pivot[:2], reach[:2], hole.width_m, 0.04, hole.head_m - 0.01, hole.colour)


def slab(
    pivot: FloatArray,
    direction: FloatArray,
    length: float,
    thickness: float,
    height: float,
    material: Material,
) -> list[Face]:
    """Upright board from ``pivot`` along ``direction``; both large sides show the whole texture."""
    x = np.array([direction[0], direction[1], 0.0]) * length
    y = np.array([-direction[1], direction[0], 0.0]) * thickness
    o = np.array([pivot[0], pivot[1], 0.005]) - y / 2
    z = np.array([0.0, 0.0, height])
    edge = replace(material, texture="plain")
    return [
        picture(o, x, z, material),
        picture(o + x + y, -x, z, material),
        sheet(o + x, y, z, edge),
        sheet(o + y, -y, z, edge),
        sheet(o + z, x, y, edge),
    ]
