"""Suburb: a loop of streets, or one street with two bends, between houses and gardens."""

from __future__ import annotations

import math

import numpy as np

from fpnav.params import Params
from fpnav.sim import scenery
from fpnav.sim.lighting import clock_sun
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Face, Material
from fpnav.sim.world import Change, Mark, Point, Route, Space, Visuals, Walk, World
from fpnav.values import FloatArray

STEP_M = 1.0
"""Distance between the points of a way."""

BEYOND_M = 25.0
STREET_AT = (-60.0, -150.0)
"""Where the street begins; the loop is about the origin."""


class SuburbParams(Params, frozen=True):
    """Distances in metres; suburb.toml says what each is for."""

    loop_m: float
    ratio: float
    overlap_m: float
    street_m: float
    bend_m: float
    bend_deg: float
    half_road_m: float
    setback_m: tuple[float, float]
    plot_m: tuple[float, float]
    trees: float
    cars: float
    people: int
    moved_share: float
    haze_m: float
    speed_mps: float


PARAMS = SuburbParams


def make(params: SuburbParams, seed: int, run: int) -> World:
    """The suburb of ``seed`` as it is on ``run``."""
    ring, street = loop_way(params), street_way(params, seed)
    faces = _ground(params, ring, street)
    changes: list[Change] = []
    for name, way, closed in (("loop", ring, True), ("street", street, False)):
        built, moved = _along(params, name, way, closed, seed, run)
        faces += built
        changes += moved
    far = params.loop_m
    low = STREET_AT[1] - params.street_m
    return World(
        name="suburb",
        seed=seed,
        run=run,
        faces=tuple(faces),
        lamps=(),
        daylight=clock_sun(seed, run),
        visuals=Visuals(light_resolution_m=0.4, ambient=0.2, haze_m=params.haze_m),
        spaces=(
            Space("loop", "street", -far, -far, far, far),
            Space("street", "street", -2 * far, low, 2 * far, -far),
        ),
        changes=tuple(changes),
        routes={
            "loop": _loop_route(params, ring),
            "street": _street_route(params, street),
        },
        walks=_walks(params, ring, street, seed, run),
    )


def loop_way(params: SuburbParams) -> FloatArray:
    """Rounded rectangle of the circumference asked for, (n, 2), counter-clockwise, not closed."""
    radius = 0.06 * params.loop_m
    straight = (params.loop_m - 2 * math.pi * radius) / 2
    w = straight * params.ratio / (1 + params.ratio)
    h = straight - w
    turns = [
        (w / 2, h / 2, 0.0),
        (-w / 2, h / 2, 90.0),
        (-w / 2, -h / 2, 180.0),
        (w / 2, -h / 2, 270.0),
    ]
    corners = []
    for x, y, first in turns:
        angle = np.radians(first + np.linspace(0.0, 90.0, 9))
        corners.append(np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)]))
    way = np.vstack(corners)
    return resampled(np.vstack([way, way[:1]]))[:-1]


def street_way(params: SuburbParams, seed: int) -> FloatArray:
    """An S: straight, a bend one way, straight, a bend the other way, straight.

    The street goes on for BEYOND_M past both ends of the route.
    """
    bend = math.radians(params.bend_deg) * float(generator(seed, "bends").choice([-1.0, 1.0]))
    arc = abs(bend) * params.bend_m
    straight = (params.street_m - 2 * arc) / 3
    count = max(2, round(arc / STEP_M))
    pieces = [(straight + BEYOND_M, 0.0)]
    pieces += [(arc / count, bend / count)] * count + [(straight, 0.0)]
    pieces += [(arc / count, -bend / count)] * count + [(straight + BEYOND_M, 0.0)]
    heading, point, points = 0.0, np.array(STREET_AT), [np.array(STREET_AT)]
    for length, turn in pieces:
        heading += turn
        point = point + length * np.array([math.cos(heading), math.sin(heading)])
        points.append(point)
    return resampled(np.array(points))


def resampled(way: FloatArray) -> FloatArray:
    """The way (n, 2) with points STEP_M apart."""
    marks = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    at = np.linspace(0.0, marks[-1], max(2, round(marks[-1] / STEP_M)) + 1)
    return np.column_stack([np.interp(at, marks, way[:, k]) for k in (0, 1)])


def _points(way: FloatArray) -> tuple[Point, ...]:
    return tuple((float(x), float(y)) for x, y in way)


def _loop_route(params: SuburbParams, ring: FloatArray) -> Route:
    again = ring[: math.ceil(params.overlap_m / STEP_M) + 1]
    (x, y), (u, v) = ring[0].tolist(), ring[len(ring) // 2].tolist()
    marks = (Mark("start", x, y, 1.0), Mark("half-way", u, v, 1.0))
    way = _points(np.vstack([ring, again]))
    return Route("loop", way, speed_mps=params.speed_mps, step_m=0.6, marks=marks)


def _street_route(params: SuburbParams, street: FloatArray) -> Route:
    beyond = round(BEYOND_M / STEP_M)
    way = _points(street[beyond:-beyond])
    return Route("street", way, speed_mps=params.speed_mps, step_m=0.6)


def _ground(params: SuburbParams, ring: FloatArray, street: FloatArray) -> list[Face]:
    lawn = Material("grass", repeat_m=(3.0, 3.0), rough=1.0)
    road = Material("asphalt", repeat_m=(3.0, 3.0), rough=0.8)
    walk = Material("paving", (0.8, 0.78, 0.75), (1.6, 1.6), rough=0.8)
    faces: list[Face] = []
    for way, closed in ((ring, True), (street, False)):
        points = _points(way)
        (x0, y0), (x1, y1) = (way.min(axis=0) - 45).tolist(), (way.max(axis=0) + 45).tolist()
        faces += scenery.ground(x0, y0, x1, y1, lawn)
        faces += scenery.strip(points, params.half_road_m + 1.4, -0.012, walk, closed)
        faces += scenery.strip(points, params.half_road_m, -0.006, road, closed)
    return faces


def _along(
    params: SuburbParams, name: str, way: FloatArray, closed: bool, seed: int, run: int
) -> tuple[list[Face], list[Change]]:
    """Plots on both sides of a way; inside the loop only what leaves room for the other side."""
    faces: list[Face] = []
    changes: list[Change] = []
    for side in (-1.0, 1.0):
        rng = generator(seed, name, "left" if side > 0 else "right")
        chance = generator(seed, run, name, "cars", 0 if side > 0 else 1)
        inside = closed and side > 0
        at = float(rng.uniform(0.0, 5.0))
        while at < (len(way) - 1) * STEP_M - 2.0:
            plot = float(rng.uniform(*params.plot_m))
            faces += _plot(params, way, at, plot, side, rng, inside)
            if rng.random() < params.cars:
                faces += _car(params, way, at, side, rng, chance, changes)
            at += plot
    return faces, changes


def _plot(
    params: SuburbParams,
    way: FloatArray,
    at: float,
    plot: float,
    side: float,
    rng: np.random.Generator,
    inside: bool,
) -> list[Face]:
    """One garden: a border towards the street, a house behind it, a tree or two."""
    border = side * (params.half_road_m + 1.9)
    start, end = _beside(way, at + 0.5, border), _beside(way, at + plot - 3.5, border)
    make = scenery.hedge if rng.random() < 0.55 else scenery.fence
    faces = make(rng, start, end, float(rng.uniform(0.6, 1.5)))
    setback = float(rng.uniform(*params.setback_m))
    w, d = float(rng.uniform(0.55, 0.75)) * plot, float(rng.uniform(5.5, 7.5))
    if not inside:
        centre = _beside(way, at + plot / 2, border + side * (setback + d / 2))
        along = _heading(way, at + plot / 2)
        faces += scenery.cottage(rng, centre, (w, d), along + (0.0 if side > 0 else math.pi))
    for _ in range(int(rng.poisson(params.trees))):
        away = border + side * float(rng.uniform(1.0, 2.5 if inside else 3.0))
        x, y = _beside(way, at + float(rng.uniform(0.0, plot)), away)
        faces += scenery.tree(rng, x, y, float(rng.uniform(3.0, 8.0)))
    if rng.random() < 0.4:
        x, y = _beside(way, at, side * (params.half_road_m + 0.9))
        faces += scenery.lamp_post(rng, x, y)
    return faces


def _car(
    params: SuburbParams,
    way: FloatArray,
    at: float,
    side: float,
    rng: np.random.Generator,
    chance: np.random.Generator,
    changes: list[Change],
) -> list[Face]:
    """A car at the kerb; on some runs it is gone, on others it is another one."""
    x, y = _beside(way, at + 4.0, side * (params.half_road_m - 0.95))
    turn = _heading(way, at + 4.0)
    if chance.random() < params.moved_share:
        changes.append(Change("removed", "car", x, y))
        return []
    return scenery.car(chance if chance.random() < params.moved_share else rng, x, y, turn)


def _beside(way: FloatArray, at: float, offset_m: float) -> Point:
    """Point ``at`` metres along the way, ``offset_m`` to its left."""
    heading = _heading(way, at)
    i = min(max(at / STEP_M, 0.0), len(way) - 1.0)
    x, y = (float(np.interp(i, np.arange(len(way)), way[:, k])) for k in (0, 1))
    return x - offset_m * math.sin(heading), y + offset_m * math.cos(heading)


def _heading(way: FloatArray, at: float) -> float:
    i = min(max(int(at / STEP_M), 0), len(way) - 2)
    dx, dy = (way[i + 1] - way[i]).tolist()
    return math.atan2(dy, dx)


def _walks(
    params: SuburbParams, ring: FloatArray, street: FloatArray, seed: int, run: int
) -> tuple[Walk, ...]:
    """People on the pavements."""
    rng = generator(seed, run, "people")
    made = []
    for k in range(params.people):
        way = ring if k % 2 == 0 else street
        side = float(rng.choice([-1.0, 1.0])) * (params.half_road_m + 0.7)
        path = scenery.offset_way(way, side, closed=way is ring)
        start = int(rng.integers(0, len(path) - 20))
        points = _points(path[start : start + int(rng.integers(12, 40))])
        made.append(Walk(points, float(rng.uniform(0.8, 1.5)), float(rng.uniform(0, 40))))
    return tuple(made)
