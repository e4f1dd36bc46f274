"""What stands out of doors: ground, facades, trees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fpnav.sim.furniture import hsv
from fpnav.sim.solids import (
    Face,
    Material,
    blob,
    box,
    picture,
    prism,
    quads,
    sheet,
    triangles,
    turned,
)
from fpnav.sim.world import Point
from fpnav.values import FloatArray

PIECE = 16


def ground(
    x0: float, y0: float, x1: float, y1: float, material: Material, tile_m: float = 25.0
) -> list[Face]:
    """Flat ground in tiles, so that each has light texels of its own."""
    nx, ny = max(1, round((x1 - x0) / tile_m)), max(1, round((y1 - y0) / tile_m))
    dx, dy = (x1 - x0) / nx, (y1 - y0) / ny
    return [
        sheet((x0 + i * dx, y0 + j * dy, -0.02), (dx, 0, 0), (0, dy, 0), material)
        for i in range(nx)
        for j in range(ny)
    ]


def strip(
    points: Sequence[Point], half_m: float, z: float, material: Material, closed: bool = False
) -> list[Face]:
    """Band of ground along a way, ``half_m`` to each side of it, in pieces of PIECE points.

    A piece is one face, so that its texture and its light go on across the points of the way.
    """
    way = np.array(points)
    left, right = (offset_way(way, side * half_m, closed) for side in (1.0, -1.0))
    if closed:
        left, right = np.vstack([left, left[:1]]), np.vstack([right, right[:1]])
    corners = np.stack([right[:-1], right[1:], left[1:], left[:-1]], axis=1)
    flat = corners[:, [[0, 1, 2], [0, 2, 3]]]
    x, y, _ = np.eye(3)
    return [
        Face(np.array([0.0, 0.0, z]), x, y, flat[k : k + PIECE].reshape(-1, 3, 2), material)
        for k in range(0, len(flat), PIECE)
    ]


def offset_way(way: FloatArray, offset_m: float, closed: bool = False) -> FloatArray:
    """The way (n, 2) moved to its left, along the mean normal at every point."""
    if closed:
        ahead = np.roll(way, -1, axis=0) - np.roll(way, 1, axis=0)
    else:
        ahead = np.gradient(way, axis=0)
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    return np.asarray(way + offset_m * np.column_stack([-ahead[:, 1], ahead[:, 0]]))


def block(
    rng: np.random.Generator, low: tuple[float, float], high: tuple[float, float], height_m: float
) -> list[Face]:
    """Block with windows on all sides and a flat roof."""
    skin, storey = _skin(rng)
    roof = Material("concrete", (0.5, 0.48, 0.46), (4.0, 4.0))
    storeys = max(1, round(height_m / storey))
    return box((*low, 0.0), (*high, storeys * storey), skin, top=roof)


def _skin(rng: np.random.Generator) -> tuple[Material, float]:
    """Wall with windows, and its storey's height."""
    kind = str(rng.choice(["townhouse", "facade"], p=[0.3, 0.7]))
    value = float(rng.uniform(0.6, 0.95))
    tone = hsv(float(rng.uniform(0, 60)), float(rng.uniform(0.05, 0.45)), value)
    bay = (float(rng.uniform(2.5, 3.8)), float(rng.uniform(2.7, 3.2)))
    look = Material(f"{kind}:{int(rng.integers(8))}", tone, bay, rough=0.7)
    return (look if kind == "facade" else replace(look, colour=(1, 1, 1))), bay[1]


def cottage(
    rng: np.random.Generator, centre: Point, size_m: tuple[float, float], turn_rad: float
) -> list[Face]:
    """House with a gabled roof along its longer side, a door in front (-y), a chimney."""
    (x, y), (w, d) = centre, size_m
    skin, storey = _skin(rng)
    eaves = storey * int(rng.integers(1, 3))
    ridge = eaves + 0.35 * d
    red = hsv(
        float(rng.uniform(0, 30)), float(rng.uniform(0.2, 0.7)), float(rng.uniform(0.35, 0.7))
    )
    tiles = Material("paving", red, (1.2, 1.2), rough=0.9)
    faces = box((x - w / 2, y - d / 2, 0), (x + w / 2, y + d / 2, eaves), skin)
    faces += _gable(x, y, w + 0.5, d + 0.6, eaves - 0.05, ridge, tiles, skin)
    stack = x + float(rng.uniform(-w / 3, w / 3))
    brick = Material("brick", repeat_m=(1.0, 1.0))
    faces += box((stack - 0.3, y - 0.3, eaves), (stack + 0.3, y + 0.3, ridge + 0.7), brick)
    at = x + float(rng.uniform(-w / 3, w / 3))
    leaf = Material(f"panel:{int(rng.integers(4))}", hsv(float(rng.uniform(0, 360)), 0.6, 0.6))
    faces.append(picture((at - 0.5, y - d / 2 - 0.03, 0), (1.0, 0, 0), (0, 0, 2.1), leaf))
    return turned(faces, centre, turn_rad)


def _gable(
    x: float, y: float, w: float, d: float, low: float, high: float, roof: Material, wall: Material
) -> list[Face]:
    west, east, south, north = x - w / 2, x + w / 2, y - d / 2, y + d / 2
    a, b = (west, south, low), (east, south, low)
    c, e = (east, north, low), (west, north, low)
    r, s = (west, y, high), (east, y, high)
    return [
        *quads(np.array([[a, b, s, r], [c, e, r, s]], dtype=np.float64), roof),
        *triangles(np.array([[b, c, s], [e, a, r]], dtype=np.float64), wall),
    ]


def hedge(rng: np.random.Generator, start: Point, end: Point, height_m: float) -> list[Face]:
    """Clipped hedge from one point to another."""
    green = (float(rng.uniform(0.8, 1.1)), float(rng.uniform(0.9, 1.1)), 0.9)
    leaves = Material(f"foliage:{int(rng.integers(4))}", green, (1.2, 1.2), rough=1.0)
    return _wall(start, end, 0.7, height_m, leaves)


def fence(rng: np.random.Generator, start: Point, end: Point, height_m: float) -> list[Face]:
    """Board fence from one point to another."""
    tone = hsv(float(rng.uniform(0, 360)), float(rng.uniform(0.0, 0.3)), float(rng.uniform(0.5, 1)))
    return _wall(start, end, 0.06, height_m, Material("planks", tone, (1.0, 1.2), rough=0.6))


def _wall(start: Point, end: Point, thick: float, high: float, material: Material) -> list[Face]:
    length = math.dist(start, end)
    x, y = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    turn = math.atan2(end[1] - start[1], end[0] - start[0])
    low, top = (x - length / 2, y - thick / 2, 0), (x + length / 2, y + thick / 2, high)
    return turned(box(low, top, material), (x, y), turn)


def car(rng: np.random.Generator, x: float, y: float, turn_rad: float) -> list[Face]:
    """Parked car."""
    paint = hsv(
        float(rng.uniform(0, 360)), float(rng.choice([0.05, 0.75])), float(rng.uniform(0.2, 0.9))
    )
    body, dark = Material("metal", paint, (3, 3), rough=0.2), Material(colour=(0.08, 0.09, 0.1))
    faces = box((x - 2.1, y - 0.85, 0.25), (x + 2.1, y + 0.85, 0.85), body, bottom=True)
    faces += prism((x - 0.2, y), (1.6, 1.05), 0.85, 1.42, dark, sides=8, taper=0.75)
    for dx, dy in ((-1.3, -0.8), (1.3, -0.8), (-1.3, 0.8), (1.3, 0.8)):
        faces += box((x + dx - 0.3, y + dy - 0.1, 0), (x + dx + 0.3, y + dy + 0.1, 0.55), dark)
    return turned(faces, (x, y), turn_rad)


def lamp_post(rng: np.random.Generator, x: float, y: float) -> list[Face]:
    """Street lamp."""
    grey = Material("metal", (0.4, 0.42, 0.42))
    faces = prism((x, y), 0.07, 0.0, 5.0, grey, sides=8, taper=0.6)
    return faces + prism((x, y), 0.3, 5.0, 5.3, Material(colour=(0.9, 0.9, 0.85)), sides=8)


def tree(rng: np.random.Generator, x: float, y: float, height_m: float) -> list[Face]:
    """Trunk and a crumpled crown."""
    trunk = Material("bark", (1, 1, 1), (0.8, 0.8), rough=1.0)
    tone = (
        float(rng.uniform(0.8, 1.2)),
        float(rng.uniform(0.9, 1.2)),
        float(rng.uniform(0.7, 1.1)),
    )
    leaves = Material(f"foliage:{int(rng.integers(4))}", tone, (1.6, 1.6), rough=1.0)
    stem = height_m * float(rng.uniform(0.25, 0.4))
    wide = height_m * float(rng.uniform(0.2, 0.32))
    faces = prism((x, y), 0.03 * height_m, 0.0, stem + 0.3 * wide, trunk, sides=8, taper=0.7)
    tall = (height_m - stem) / 2
    return faces + blob((x, y, stem + tall), (wide, wide, tall), leaves, rng, rough=0.3)


def surroundings(
    rng: np.random.Generator, x0: float, y0: float, x1: float, y1: float
) -> list[Face]:
    """Lawn, trees and facades seen through the windows of a building."""
    cx, cy, reach = (x0 + x1) / 2, (y0 + y1) / 2, max(x1 - x0, y1 - y0) / 2
    lawn = Material("grass", (1, 1, 1), (2.0, 2.0), rough=1.0)
    far = reach + 60.0
    faces = ground(cx - far, cy - far, cx + far, cy + far, lawn, 4.0 * far)
    for angle in np.arange(0.0, 2 * math.pi, math.pi / 6) + float(rng.uniform(0, 0.5)):
        away = reach + float(rng.uniform(22, 45))
        x, y = cx + away * math.cos(angle), cy + away * math.sin(angle)
        if rng.random() < 0.5:
            w, d = (float(v) for v in rng.uniform(8, 20, 2))
            tall = float(rng.uniform(6, 16))
            faces += block(rng, (x - w / 2, y - d / 2), (x + w / 2, y + d / 2), tall)
        else:
            faces += tree(rng, x, y, float(rng.uniform(5, 12)))
    return faces
