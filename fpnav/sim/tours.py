"""Ways through a building: a backbone along the corridors and visits to the rooms beside it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fpnav.sim.world import Point

ENTRY_M = 1.25
"""How far past the door's middle the first point inside a room lies."""


@dataclass(frozen=True, slots=True)
class Stop:
    """Room beside the backbone: where its door is, and the lane inside it.

    ``at_m`` counts along the backbone to the foot of the door; ``inward`` is the unit vector
    through the door; ``lane`` is (x0, y0, x1, y1).
    """

    name: str
    at_m: float
    door: Point
    inward: Point
    lane: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Backbone:
    """Polyline along the middle of corridors; consecutive pieces are straight or at right angles.

    ``reach_m`` (left, right): how far from the middle the robot's centre may be.
    """

    points: tuple[Point, ...]
    reach_m: tuple[float, float] = (0.25, 0.25)

    @property
    def length_m(self) -> float:
        """Length of the whole polyline."""
        return float(self._marks()[-1])

    def _marks(self) -> np.ndarray:
        steps = np.hypot(*np.diff(np.array(self.points), axis=0).T)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def point(self, at_m: float, offset_m: float = 0.0) -> Point:
        """Point ``at_m`` along, ``offset_m`` to the left of the backbone's own direction."""
        marks = self._marks()
        at_m = min(max(at_m, 0.0), marks[-1])
        i = min(int(np.searchsorted(marks, at_m, side="right")) - 1, len(marks) - 2)
        (ax, ay), (ux, uy) = self.points[i], self._direction(i)
        along = at_m - marks[i]
        return ax + along * ux - offset_m * uy, ay + along * uy + offset_m * ux

    def foot(self, x: float, y: float) -> float:
        """Distance along the backbone to its point nearest to (x, y)."""
        best, found = math.inf, 0.0
        for i, mark in enumerate(self._marks()[:-1]):
            (ax, ay), (ux, uy) = self.points[i], self._direction(i)
            length = math.dist(self.points[i], self.points[i + 1])
            along = min(max((x - ax) * ux + (y - ay) * uy, 0.0), length)
            away = math.hypot(ax + along * ux - x, ay + along * uy - y)
            if away < best - 1e-9:
                best, found = away, mark + along
        return float(found)

    def _direction(self, i: int) -> Point:
        (ax, ay), (bx, by) = self.points[i], self.points[i + 1]
        length = math.dist((ax, ay), (bx, by))
        return (bx - ax) / length, (by - ay) / length

    def between(self, start_m: float, end_m: float, offset_m: float = 0.0) -> list[Point]:
        """Way from ``start_m`` to ``end_m`` (either direction), its corners included."""
        marks = self._marks()
        low, high = min(start_m, end_m), max(start_m, end_m)
        inner = [i for i in range(1, len(marks) - 1) if low < marks[i] < high]
        way = [self.point(low, offset_m)]
        way += [self._corner(i, offset_m) for i in inner]
        way.append(self.point(high, offset_m))
        return way if start_m <= end_m else way[::-1]

    def _corner(self, i: int, offset_m: float) -> Point:
        (ax, ay), (bx, by), (x, y) = self._direction(i - 1), self._direction(i), self.points[i]
        turning = abs(ax * by - ay * bx) > 1e-6
        dx, dy = (-ay - by, ax + bx) if turning else (-ay, ax)
        return x + offset_m * dx, y + offset_m * dy


def visit(
    backbone: Backbone, stop: Stop, rng: np.random.Generator, *, points: int, offset_m: float
) -> list[Point]:
    """From the corridor into the room, about its lane, and back to the corridor."""
    foot = backbone.point(stop.at_m, offset_m)
    (dx, dy), (ix, iy) = stop.door, stop.inward
    outside = (dx - 0.45 * ix, dy - 0.45 * iy)
    inside = (dx + ENTRY_M * ix, dy + ENTRY_M * iy)
    x0, y0, x1, y1 = stop.lane
    beside = (min(max(inside[0], x0), x1), min(max(inside[1], y0), y1))
    inner = spread_points(stop.lane, rng, points)
    return [foot, outside, inside, beside, *inner, beside, inside, outside, foot]


def spread_points(
    lane: tuple[float, float, float, float], rng: np.random.Generator, count: int
) -> list[Point]:
    """Points about the lane's middle, turning one way round, each at its own distance."""
    x0, y0, x1, y1 = lane
    cx, cy = (x0 + x1) / 2, (y0 + y1) / 2
    start, sense = float(rng.uniform(0.0, 2.0 * math.pi)), float(rng.choice([-1.0, 1.0]))
    made = []
    for k in range(count):
        angle = start + sense * 2.0 * math.pi * k / max(count, 1)
        out = float(rng.uniform(0.55, 1.0))
        x, y = out * math.cos(angle) * 1.2, out * math.sin(angle) * 1.2
        made.append(
            (
                cx + min(max(x, -1.0), 1.0) * (x1 - x0) / 2,
                cy + min(max(y, -1.0), 1.0) * (y1 - y0) / 2,
            )
        )
    return made


def length(points: Sequence[Point]) -> float:
    """Length of a way."""
    return float(sum(math.dist(a, b) for a, b in itertools.pairwise(points)))


def mapping_way(
    backbone: Backbone, stops: Sequence[Stop], rng: np.random.Generator, target_m: float
) -> tuple[list[Point], list[Stop], float]:
    """First visit of a building: along the backbone, into the rooms, until ``target_m``.

    Returns the way, the rooms visited to the end, and how far along the backbone it came.
    """
    way = [backbone.point(0.0)]
    at = 0.0
    seen: list[Stop] = []
    for stop in sorted(stops, key=lambda stop: stop.at_m):
        inside = visit(backbone, stop, rng, points=3, offset_m=0.0)
        leg = [*backbone.between(at, stop.at_m)[1:], *inside[1:]]
        if length([*way, *leg]) > target_m:
            break
        way += leg
        at, seen = stop.at_m, [*seen, stop]
    left = max(0.0, target_m - length(way))
    way += backbone.between(at, at + 1.1 * left + 8.0)[1:]
    return way, seen, min(backbone.length_m, at + left)


def wandering_way(
    backbone: Backbone,
    stops: Sequence[Stop],
    rng: np.random.Generator,
    target_m: float,
    reach_m: float,
) -> list[Point]:
    """Another way through what is known: rooms in any order, either direction, other sides.

    Where no room is known it goes to and fro along the backbone.
    """
    at = float(rng.uniform(0.2, 0.8)) * reach_m
    way = [backbone.point(at)]
    queue: list[Stop] = []
    while length(way) < 1.08 * target_m:
        if not queue:
            queue = [stops[int(i)] for i in rng.permutation(len(stops))]
        stop = queue.pop() if queue else None
        offset = _offset(backbone, rng)
        if stop is None or rng.random() < 0.3:
            turn = float(rng.uniform(0.3, reach_m))
            way += backbone.between(at, turn, offset)[1:]
            at = turn
        if stop is None:
            continue
        way += backbone.between(at, stop.at_m, offset)[1:]
        way += visit(
            backbone, stop, rng, points=int(rng.integers(2, 5)), offset_m=_offset(backbone, rng)
        )
        at = stop.at_m
    return way


def _offset(backbone: Backbone, rng: np.random.Generator) -> float:
    """Side of the corridor to travel on, away from its middle."""
    left, right = backbone.reach_m
    side = left if rng.random() < 0.5 else -right
    return side * float(rng.uniform(0.5, 1.0))
