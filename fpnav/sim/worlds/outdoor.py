"""Open ground among buildings and trees: a line of places through its middle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fpnav.params import Params
from fpnav.sim import scenery
from fpnav.sim.lighting import clock_sun
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Face, Material
from fpnav.sim.world import Change, Mark, Point, Route, Space, Visuals, Walk, World


class OutdoorParams(Params, frozen=True):
    """Distances in metres; outdoor.toml says what each is for."""

    scale: float
    near_m: float
    far_m: float
    blocks: int
    trees: int
    small: int
    line_m: float
    line_step_m: float
    spacing_m: float
    people: int
    moved_share: float
    haze_m: float


PARAMS = OutdoorParams


def make(params: OutdoorParams, seed: int, run: int) -> World:
    """The ground of ``seed`` on ``run``: odd runs in the afternoon, even ones in the morning."""
    faces = [*_ground(params), *_around(params, seed)]
    things, changes = _things(params, seed, run)
    half = params.scale * params.far_m
    return World(
        name="outdoor",
        seed=seed,
        run=run,
        faces=tuple(scaled([*faces, *things], params.scale)),
        lamps=(),
        daylight=clock_sun(seed, run),
        visuals=Visuals(
            light_resolution_m=0.4 * params.scale, ambient=0.2, haze_m=params.haze_m * params.scale
        ),
        spaces=(Space("ground", "open", -half, -half, half, half),),
        changes=tuple(changes),
        routes={"line": _line(params)},
        walks=_walks(params, seed, run),
    )


def scaled(faces: list[Face], factor: float) -> list[Face]:
    """The faces with every length multiplied, textures too."""
    if factor == 1.0:
        return faces
    return [
        replace(
            face,
            origin=face.origin * factor,
            triangles=face.triangles * factor,
            material=replace(
                face.material,
                repeat_m=(
                    face.material.repeat_m[0] * factor,
                    face.material.repeat_m[1] * factor,
                ),
            ),
        )
        for face in faces
    ]


def _ground(params: OutdoorParams) -> list[Face]:
    """Lawn, a paved square in its middle, a road past it."""
    far = 1.4 * params.far_m
    lawn = Material("grass", repeat_m=(3.0, 3.0), rough=1.0)
    square = Material("paving", (0.85, 0.82, 0.78), (2.4, 2.4), rough=0.8)
    road = Material("asphalt", repeat_m=(3.0, 3.0), rough=0.8)
    faces = scenery.ground(-far, -far, far, far, lawn)
    faces += scenery.strip([(-16, -2), (0, -2), (16, -2)], 4.5, -0.01, square)
    return faces + scenery.strip([(-far, 8), (0, 9), (far, 7)], 2.5, -0.005, road)


def _ring_place(params: OutdoorParams, rng: np.random.Generator, k: int, count: int) -> Point:
    """The k-th place of a ring: anywhere in its own sector, between near and far."""
    angle = 2 * math.pi * (k + float(rng.uniform(0.1, 0.9))) / count
    away = params.near_m + (params.far_m - params.near_m) * float(rng.random()) ** 0.7
    x = away * math.cos(angle) + 10.0 * math.copysign(1.0, math.cos(angle))
    return x, away * math.sin(angle) + 2.0 * math.copysign(1.0, math.sin(angle))


def _around(params: OutdoorParams, seed: int) -> list[Face]:
    """Buildings in the distance and trees before them."""
    rng = generator(seed, "around")
    faces: list[Face] = []
    for k in range(params.blocks):
        x, y = _ring_place(params, rng, k, params.blocks)
        away = math.hypot(x, y)
        x, y = (value * max(1.0, 0.6 * params.far_m / away) for value in (x, y))
        w, d = (float(v) for v in rng.uniform(7, 16, 2))
        if rng.random() < 0.5:
            low, high = (x - w / 2, y - d / 2), (x + w / 2, y + d / 2)
            faces += scenery.block(rng, low, high, float(rng.uniform(6, 18)))
        else:
            faces += scenery.cottage(rng, (x, y), (w, 0.7 * d), float(rng.uniform(0, 2 * math.pi)))
    for k in range(params.trees):
        x, y = _ring_place(params, rng, k, params.trees)
        faces += scenery.tree(rng, x, y, float(rng.uniform(4, 11)))
    return faces


def _things(params: OutdoorParams, seed: int, run: int) -> tuple[list[Face], list[Change]]:
    """Cars, lamp posts, hedges; cars are elsewhere on some runs."""
    rng, chance = generator(seed, "things"), generator(seed, run, "moved")
    faces: list[Face] = []
    changes: list[Change] = []
    for k in range(params.small):
        x, y = _ring_place(params, rng, k, params.small)
        kind = k % 4
        if kind == 0:
            faces += scenery.lamp_post(rng, x, y)
        elif kind == 1:
            turn = float(rng.uniform(0, math.pi))
            end = (x + 6 * math.cos(turn), y + 6 * math.sin(turn))
            faces += scenery.hedge(rng, (x, y), end, float(rng.uniform(0.8, 1.6)))
        elif chance.random() < params.moved_share:
            changes.append(Change("removed", "car", x * params.scale, y * params.scale))
        else:
            faces += scenery.car(rng, x, y, float(rng.uniform(0, math.pi)))
    return faces, changes


def _line(params: OutdoorParams) -> Route:
    half = params.line_m / 2
    count = math.floor(params.line_m / params.spacing_m + 1e-6) + 1
    marks = tuple(
        Mark(f"place-{k + 1}", -half + k * params.spacing_m, 0.0, params.line_step_m / 2)
        for k in range(count)
    )
    return Route(
        "line",
        ((-half, 0.0), (half + 1.0, 0.0)),
        length_m=params.line_m + params.line_step_m / 2,
        speed_mps=5.0 * params.line_step_m,
        step_m=params.line_step_m,
        marks=marks,
    )


def _walks(params: OutdoorParams, seed: int, run: int) -> tuple[Walk, ...]:
    """People crossing the ground."""
    rng = generator(seed, run, "people")
    return tuple(
        Walk(
            tuple((float(x), float(y)) for x, y in rng.uniform((-18, -12), (18, 12), (4, 2))),
            float(rng.uniform(0.8, 1.5)),
            float(rng.uniform(0, 40)),
        )
        for _ in range(params.people)
    )
