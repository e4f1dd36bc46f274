"""Ways through the office: mapping, testing, loops, and those of the people in it."""

from __future__ import annotations

import numpy as np

from fpnav.sim import tours
from fpnav.sim.building import Floor
from fpnav.sim.plan import doors_of
from fpnav.sim.seeds import generator
from fpnav.sim.tours import Backbone, Stop
from fpnav.sim.world import Point, Route, Walk


def stops_of(floor: Floor, backbone: Backbone) -> list[Stop]:
    """Rooms with an open door, along the ring."""
    made = []
    doors = [hole for hole in floor.openings if hole.kind == "door"]
    for hole, door in zip(doors, doors_of(floor.runs, doors), strict=True):
        if not door.open:
            continue
        room = floor.furnished[hole.a]
        up = 1.0 if room.space.centre[1] > door.y_m else -1.0
        foot = backbone.foot(door.x_m, door.y_m)
        made.append(Stop(hole.a, foot, (door.x_m, door.y_m), (0.0, up), room.lane()))
    return sorted(made, key=lambda stop: stop.at_m)


def routes_of(
    backbone: Backbone, stops: list[Stop], seed: int, map_m: float, test_m: float
) -> dict[str, Route]:
    """Mapping run, test run on another way, five ways that come back to where they were."""
    rng = generator(seed, "routes")
    chosen = _chosen(stops, rng)
    way, seen, reach = tours.mapping_way(backbone, chosen, rng, map_m)
    names = tuple(stop.name for stop in seen)
    test = tours.wandering_way(backbone, seen, rng, test_m, reach)
    routes = {
        "map": Route("map", tuple(way), map_m, stops=names),
        "test": Route("test", tuple(test), test_m, stops=names),
    }
    for k in range(1, 6):
        routes[f"loop-{k}"] = _loop(backbone, stops, generator(seed, "loop", k), k)
    return routes


def _chosen(stops: list[Stop], rng: np.random.Generator) -> list[Stop]:
    """One door of each room, and about two rooms in three."""
    once: dict[str, Stop] = {}
    for stop in stops:
        once.setdefault(stop.name, stop)
    return [stop for stop in once.values() if rng.random() < 0.7]


def _loop(backbone: Backbone, stops: list[Stop], rng: np.random.Generator, k: int) -> Route:
    """Once around the ring and some metres on, with a visit on the way; odd ones clockwise."""
    total = backbone.length_m
    start = float(rng.uniform(0.0, total))
    ring = Backbone(_rolled(backbone, start), backbone.reach_m)
    ahead = [s for s in stops if 6.0 < (s.at_m - start) % total < total - 10.0]
    stop = ahead[int(rng.integers(len(ahead)))] if ahead and k % 2 == 0 else None
    overlap = float(rng.uniform(8.0, 14.0))
    way = ring.between(0.0, total)
    if stop is not None:
        foot = (stop.at_m - start) % total
        moved = Stop(stop.name, foot, stop.door, stop.inward, stop.lane)
        way = [
            *ring.between(0.0, foot),
            *tours.visit(ring, moved, rng, points=2, offset_m=0.0)[1:],
            *ring.between(foot, total)[1:],
        ]
    way += ring.between(0.0, overlap)[1:]
    if k % 2 == 1:
        way = [*ring.between(0.0, total)[::-1], *ring.between(total - overlap, total)[::-1][1:]]
    return Route(f"loop-{k}", tuple(way), stops=(stop.name,) if stop else ())


def _rolled(backbone: Backbone, start: float) -> tuple[Point, ...]:
    """The closed backbone, begun at ``start``."""
    total = backbone.length_m
    first = backbone.between(start, total)
    second = backbone.between(0.0, start)
    return (*first, *second[1:])


def walks_of(backbone: Backbone, people: int, seed: int, run: int) -> tuple[Walk, ...]:
    """People on the corridors of this run."""
    rng = generator(seed, run, "people")
    made = []
    for _ in range(people):
        a = float(rng.uniform(0.0, backbone.length_m))
        b = min(a + float(rng.uniform(6.0, 20.0)), backbone.length_m)
        side = float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.3, 0.5))
        way = tuple(backbone.between(a, b, side))
        made.append(Walk(way, float(rng.uniform(0.7, 1.4)), float(rng.uniform(0.0, 30.0))))
    return tuple(made)
