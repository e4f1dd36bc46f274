"""Any number of gateways on one route: rows of hallway, joined at alternate ends."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from fpnav.sim.world import Gateway, Point, Space
from fpnav.sim.worlds.hall_layout import (
    EAST,
    NORTH,
    PAST_M,
    WEST,
    GatewaysParams,
    Layout,
    past_middle,
)

ROW = 6
"""Gateways along one row; two more are the corners at its end."""

ALIKE = "RIGHT OPENING"
OTHERS = ("LEFT OPENING", "CROSS", "RIGHT ROOM", "LEFT ROOM", "BOTH ROOM")
SIDES = {
    "RIGHT OPENING": "R",
    "LEFT OPENING": "L",
    "CROSS": "LR",
    "RIGHT ROOM": "R",
    "LEFT ROOM": "L",
    "BOTH ROOM": "LR",
}
"""Sides, seen along the way, on which each type is open."""


@dataclass(slots=True)
class _Row:
    """One hallway under construction, travelled eastward or westward."""

    number: int
    y: float
    eastward: bool
    spaces: list[Space] = field(default_factory=list)
    gateways: list[Gateway] = field(default_factory=list)


def serpentine(params: GatewaysParams, rng: np.random.Generator) -> Layout:
    """``params.gateways`` gateways, ``params.alike`` of them alike, on one route."""
    wide, common = float(rng.uniform(*params.hall_m)), float(rng.uniform(*params.opening_m))
    counts = _row_counts(params.gateways)
    types = _types(params, sum(counts), rng)
    pitch = wide + 2 * params.depth_m[1] + 1.0
    length = ROW * (params.room_m[1] + params.gap_m[1]) + params.gap_m[1] + 3.0
    rows = []
    for number, count in enumerate(counts):
        row = _Row(number, number * pitch, number % 2 == 0)
        _fill(row, [types.pop() for _ in range(count)], params, rng, wide, common, length)
        rows.append(row)
    spaces = [space for row in rows for space in row.spaces]
    for row in rows[:-1]:
        spaces.append(_connection(row, pitch, wide, length))
    gateways = _named(rows, pitch, wide, length, params.gateways)
    return Layout(tuple(spaces), tuple(gateways), {"route-1": _way(rows, wide, length)}, wide)


def _row_counts(total: int) -> list[int]:
    """Gateways along each row, so that with two corners between rows there are enough."""
    counts = []
    left = total
    while left > 0:
        here = min(ROW, left)
        counts.append(here)
        left -= here + 2
    return counts


def _types(params: GatewaysParams, count: int, rng: np.random.Generator) -> list[str]:
    """Types of the gateways along rows, in random order."""
    alike = min(params.alike, count)
    others = [OTHERS[int(k)] for k in rng.integers(0, len(OTHERS), count - alike)]
    types = [ALIKE] * alike + others
    return [types[int(k)] for k in rng.permutation(count)]


def _fill(
    row: _Row,
    types: list[str],
    params: GatewaysParams,
    rng: np.random.Generator,
    wide: float,
    common: float,
    length: float,
) -> None:
    """The hallway of a row with what opens off it, in the order of travel."""
    row.spaces.append(Space(f"hall-{row.number}", "corridor", 0.0, row.y, length, row.y + wide))
    along = 3.0 + float(rng.uniform(*params.gap_m))
    for number, kind in enumerate(types):
        room = kind.endswith("ROOM")
        width = float(rng.uniform(*(params.room_m if room else params.opening_m)))
        if kind == ALIKE:
            width = common + params.alike_m * float(rng.uniform(-0.5, 0.5))
        _open(row, number, kind, along, width, params, rng, wide, length)
        along += width + float(rng.uniform(*params.gap_m))


def _open(
    row: _Row,
    number: int,
    kind: str,
    along: float,
    width: float,
    params: GatewaysParams,
    rng: np.random.Generator,
    wide: float,
    length: float,
) -> None:
    """One gateway: its spaces, and its truth. ``along`` counts from where the row is entered."""
    start, end = (
        (along, along + width) if row.eastward else (length - along, length - along - width)
    )
    x0, x1 = min(start, end), max(start, end)
    look = "lobby" if kind.endswith("ROOM") else "corridor"
    for side in SIDES[kind]:
        depth = float(rng.uniform(*params.depth_m))
        north = (side == "L") == row.eastward
        y0, y1 = (row.y + wide, row.y + wide + depth) if north else (row.y - depth, row.y)
        row.spaces.append(Space(f"side-{row.number}-{number}{side}", look, x0, y0, x1, y1))
    axis, ahead = (EAST, 1.0) if row.eastward else (WEST, -1.0)
    opens = -PAST_M if look == "lobby" else -width / 2
    x = start - ahead * opens
    gateway = Gateway("", "route-1", x, row.y + wide / 2, axis, kind, opens, opens + width)
    row.gateways.append(gateway)


def _connection(row: _Row, pitch: float, wide: float, length: float) -> Space:
    """Hallway from the end of a row to the beginning of the next."""
    x = length if row.eastward else -wide
    return Space(f"join-{row.number}", "corridor", x, row.y, x + wide, row.y + pitch + wide)


def _corners(row: _Row, pitch: float, wide: float, length: float) -> list[Gateway]:
    """The two turns between a row and the next."""
    x = length + wide / 2 if row.eastward else -wide / 2
    kind = "LEFT TURN" if row.eastward else "RIGHT TURN"
    axis = EAST if row.eastward else WEST
    half, low, high = wide / 2, row.y + wide / 2, row.y + pitch + wide / 2
    return [
        Gateway("", "route-1", x, low, axis, kind, -half, half),
        Gateway("", "route-1", x, high, NORTH, kind, -half, half),
    ]


def _named(rows: list[_Row], pitch: float, wide: float, length: float, total: int) -> list[Gateway]:
    """All gateways in the order of travel, named by their number."""
    made: list[Gateway] = []
    for row in rows:
        made += row.gateways
        made += _corners(row, pitch, wide, length) if row is not rows[-1] else []
    return [
        Gateway(f"{k + 1:02d}", g.route, g.x_m, g.y_m, g.axis_rad, g.type, g.opens_m, g.closes_m)
        for k, g in enumerate(made[:total])
    ]


def _way(rows: list[_Row], wide: float, length: float) -> list[Point]:
    """Along every row and up its connection; at corners past the middle, then back to it."""
    past, half = past_middle(wide), wide / 2
    way: list[Point] = [(1.2, rows[0].y + half)]
    for row, after in itertools.pairwise(rows):
        ahead = 1.0 if row.eastward else -1.0
        x = length + half if row.eastward else -half
        low, high = row.y + half, after.y + half
        way += [(x + ahead * past, low), (x, low + 1.5), (x, high + past), (x - ahead * 1.5, high)]
    last = rows[-1]
    end = last.gateways[-1]
    way.append((end.x_m + 3.6 * math.cos(end.axis_rad), last.y + half))
    return way
