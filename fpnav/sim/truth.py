"""What is true of a world and cannot be read from poses: the attachment ``world.json``.

The types below are its schema: docs/world.schema.json is generated from them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec

from fpnav.sim.world import Point, Route, Space, World

VERSION = 1
CELL_M = 8.0


class RoomFacts(msgspec.Struct, frozen=True):
    """A space: its name is the label while the robot is in it."""

    name: str
    kind: str
    polygon: tuple[Point, ...]


class DoorFacts(msgspec.Struct, frozen=True):
    """An opening between two rooms; ``x_m, y_m`` its middle, ``axis_rad`` the way through."""

    name: str
    x_m: float
    y_m: float
    axis_rad: float
    width_m: float
    open: bool
    spaces: tuple[str, str]


class GatewayFacts(msgspec.Struct, frozen=True):
    """A gateway as one route meets it; edges count along the axis from the centre."""

    name: str
    route: str
    x_m: float
    y_m: float
    axis_rad: float
    type: str
    opens_m: float
    closes_m: float


class ChangeFacts(msgspec.Struct, frozen=True):
    """Something of note: corner, colour, lobby (places), added, removed (since the last run)."""

    kind: str
    what: str
    x_m: float
    y_m: float


class MarkFacts(msgspec.Struct, frozen=True):
    """A named place on a route; its name is the label within the radius."""

    name: str
    x_m: float
    y_m: float
    radius_m: float


class RouteFacts(msgspec.Struct, frozen=True):
    """A way: the points aimed at, the rooms or gateways passed in order, named places."""

    points: tuple[Point, ...]
    stops: tuple[str, ...]
    marks: tuple[MarkFacts, ...]


class WorldFacts(msgspec.Struct, frozen=True):
    """The attachment: lengths in metres, angles in radians, all to the millimetre."""

    version: int
    world: str
    seed: int
    run: int
    route: str
    rooms: tuple[RoomFacts, ...]
    doors: tuple[DoorFacts, ...]
    gateways: tuple[GatewayFacts, ...]
    changes: tuple[ChangeFacts, ...]
    walls: tuple[tuple[float, float, float, float], ...]
    routes: dict[str, RouteFacts]


def world_json(world: World, route: str) -> bytes:
    """The attachment, UTF-8 JSON with sorted keys."""
    facts = _rounded(msgspec.to_builtins(world_facts(world, route), enc_hook=float))
    return msgspec.json.format(msgspec.json.encode(facts, order="sorted"), indent=1) + b"\n"


def world_facts(world: World, route: str) -> WorldFacts:
    """The attachment as values."""
    return WorldFacts(
        VERSION,
        world.name,
        world.seed,
        world.run,
        route,
        tuple(RoomFacts(s.name, s.kind, _polygon(s)) for s in world.spaces),
        _as(world.doors, DoorFacts),
        _as(world.gateways, GatewayFacts),
        _as(world.changes, ChangeFacts),
        world.walls,
        {
            name: RouteFacts(way.points, way.stops, _as(way.marks, MarkFacts))
            for name, way in world.routes.items()
        },
    )


def schema() -> bytes:
    """JSON schema of the attachment."""
    made = msgspec.json.schema(WorldFacts)
    made["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return msgspec.json.format(msgspec.json.encode(made, order="sorted"), indent=2) + b"\n"


def _as(items: tuple[Any, ...], kind: Any) -> tuple[Any, ...]:
    """The world's own values as facts of the same fields."""
    return tuple(msgspec.convert(item, kind, from_attributes=True) for item in items)


def _polygon(space: Space) -> tuple[Point, ...]:
    low, high = (space.x0, space.y0), (space.x1, space.y1)
    return low, (high[0], low[1]), high, (low[0], high[1])


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 3) + 0.0
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value


class Labels:
    """Names of places: of the route's mark near by, else of the space a point lies in."""

    def __init__(self, world: World, route: Route) -> None:
        self._marks = route.marks
        self._cells: dict[tuple[int, int], list[Space]] = {}
        for space in world.spaces:
            for cell in _cells_of(space):
                self._cells.setdefault(cell, []).append(space)

    def at(self, x_m: float, y_m: float) -> str:
        """Name of the place a point lies in; empty where it lies in none."""
        for mark in self._marks:
            if mark.near(x_m, y_m):
                return mark.name
        for space in self._cells.get((int(x_m // CELL_M), int(y_m // CELL_M)), ()):
            if space.contains(x_m, y_m):
                return space.name
        return ""


def _cells_of(space: Space) -> Iterator[tuple[int, int]]:
    for x in range(int(space.x0 // CELL_M), int(space.x1 // CELL_M) + 1):
        for y in range(int(space.y0 // CELL_M), int(space.y1 // CELL_M) + 1):
            yield x, y
