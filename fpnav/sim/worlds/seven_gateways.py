"""The building of seven gateways, A to G, of which B, C and D look alike to sonar.

Going east on the southern hallway the robot meets B, C, D (RIGHT OPENING), E (RIGHT ROOM) and at
its end A (T-SHAPE); north of A the hallway bends to the west at F (LEFT TURN), and G (CROSS) lies
on the northern one. Other routes meet the same places from other sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fpnav.sim.world import Gateway, Point, Space
from fpnav.sim.worlds.hall_layout import (
    EAST,
    NORTH,
    PAST_M,
    SOUTH,
    WEST,
    GatewaysParams,
    Layout,
    past_middle,
)

ROUTES = {
    "route-1": "B:E C:E D:E E:E A:E F:N G:W",
    "route-2": "G:S G:E F:E A:S",
    "route-3": "A:N E:W D:W C:W B:W",
}
"""Gateways of a route in order, each with the way the robot goes when it comes to it."""

TYPES = {
    "A:E": "T-SHAPE",
    "A:N": "LEFT OPENING",
    "A:S": "RIGHT OPENING",
    "E:E": "RIGHT ROOM",
    "E:W": "LEFT ROOM",
    "F:N": "LEFT TURN",
    "F:E": "RIGHT TURN",
    "G:E": "CROSS",
    "G:W": "CROSS",
    "G:S": "CROSS",
    **{f"{name}:E": "RIGHT OPENING" for name in "BCD"},
    **{f"{name}:W": "LEFT OPENING" for name in "BCD"},
}


@dataclass(frozen=True, slots=True)
class Halls:
    """Sizes of the building: x and y of what the halls and openings begin and end at."""

    wide: float
    openings: dict[str, tuple[float, float]]
    depths: dict[str, float]
    east: float
    top: float
    south: float

    @property
    def middle(self) -> tuple[float, float, float]:
        """Middles: y of the southern hall, x of the eastern one, y of the northern one."""
        half = self.wide / 2
        return half, self.east + half, self.top + half


def seven_gateways(params: GatewaysParams, rng: np.random.Generator) -> Layout:
    """One such building."""
    halls = draw_halls(params, rng)
    there = tuple(one for one in gateways_of(halls) if one.name not in params.closed)
    return Layout(_spaces(params, halls), there, _ways(halls), halls.wide)


def draw_halls(params: GatewaysParams, rng: np.random.Generator) -> Halls:
    """Sizes of one building; B, C and D have nearly the same width."""
    wide, common = float(rng.uniform(*params.hall_m)), float(rng.uniform(*params.opening_m))
    x = 2.6 + float(rng.uniform(*params.gap_m))
    openings: dict[str, tuple[float, float]] = {}
    for name in "BCD":
        width = common + params.alike_m * float(rng.uniform(-0.5, 0.5))
        openings[name] = (x, x + width)
        x += width + float(rng.uniform(*params.gap_m))
    openings["E"] = (x, x + float(rng.uniform(*params.room_m)))
    east = openings["E"][1] + float(rng.uniform(*params.gap_m))
    cross = float(rng.uniform(0.3, 0.5)) * east + 2.0
    openings["G"] = (cross, cross + float(rng.uniform(*params.opening_m)))
    depths = {name: float(rng.uniform(*params.depth_m)) for name in "BCDEGH"}
    top = wide + float(rng.uniform(9.5, 12.0))
    return Halls(wide, openings, depths, east, top, -float(rng.uniform(6.0, 8.0)))


def _spaces(params: GatewaysParams, halls: Halls) -> tuple[Space, ...]:
    w, east, top = halls.wide, halls.east, halls.top
    made = [
        Space("hall-south", "corridor", 0.0, 0.0, east, w),
        Space("hall-east", "corridor", east, halls.south, east + w, top),
        Space("hall-north", "corridor", 2.0, top, east + w, top + w),
    ]
    for name in "BCD":
        x0, x1 = halls.openings[name]
        kind = "closed" if name in params.closed else "corridor"
        made.append(Space(f"side-{name}", kind, x0, -halls.depths[name], x1, 0.0))
    x0, x1 = halls.openings["E"]
    made.append(Space("room-E", "lobby", x0, -halls.depths["E"], x1, 0.0))
    x0, x1 = halls.openings["G"]
    made.append(Space("side-G-south", "corridor", x0, top - 3.2, x1, top))
    made.append(Space("side-G-north", "corridor", x0, top + w, x1, top + w + halls.depths["H"]))
    return tuple(made)


def gateways_of(halls: Halls) -> list[Gateway]:
    """Every gateway of every route, as the robot meets it."""
    made = []
    for route, line in ROUTES.items():
        for met in line.split():
            made.append(_gateway(halls, route, met))
    return made


def _gateway(halls: Halls, route: str, met: str) -> Gateway:
    """One gateway met by going ``NAME:WAY``."""
    name, _, way = met.partition(":")
    axis = {"E": EAST, "N": NORTH, "W": WEST, "S": SOUTH}[way]
    south, east, north = halls.middle
    half = halls.wide / 2
    if name == "E":
        edge = halls.openings["E"][0 if way == "E" else 1]
        x = edge + math.copysign(PAST_M, math.cos(axis))
        width = halls.openings["E"][1] - halls.openings["E"][0]
        return Gateway(name, route, x, south, axis, TYPES[met], -PAST_M, width - PAST_M)
    if name in "BCD":
        x0, x1 = halls.openings[name]
        place, reach = ((x0 + x1) / 2, south), (x1 - x0) / 2
    elif name == "G":
        x0, x1 = halls.openings["G"]
        place, reach = ((x0 + x1) / 2, north), (half if way == "S" else (x1 - x0) / 2)
    else:
        place, reach = ((east, south) if name == "A" else (east, north)), half
    return Gateway(name, route, *place, axis, TYPES[met], -reach, reach)


def _ways(halls: Halls) -> dict[str, list[Point]]:
    south, east, north = halls.middle
    cross = sum(halls.openings["G"]) / 2
    # The robot turns where the wall in front is near enough to be noticed, past the middle.
    past = past_middle(halls.wide)
    turn = [(east + past, south), (east, south + 1.5), (east, north + past)]
    bend = [(east + past, north), (east, north - 1.5)]
    return {
        "route-1": [(1.2, south), *turn, (east - 1.5, north), (cross - 3.2, north)],
        "route-2": [
            (cross, halls.top + halls.wide + halls.depths["H"] - 1.2),
            (cross, north),
            (cross - 3.4, north),
            *bend,
            (east, halls.south + 1.4),
        ],
        "route-3": [(east, halls.south + 1.2), (east, south), (1.4, south)],
    }
