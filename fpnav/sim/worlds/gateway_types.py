"""One small building for every type of gateway, each with a route that meets it and no other.

Hallways that open to either side, that end, or both; rooms that the robot leaves through an exit
beside it or ahead (systems.md 3.4). A building has coordinates of its own: the robot goes along x,
the hallway's middle is y = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fpnav.params import Params
from fpnav.sim.building import Finish, Floor
from fpnav.sim.decor import corridor_finish, house_style
from fpnav.sim.lighting import ceiling_lamps, weather
from fpnav.sim.plan import THICKNESS_M, segments, wall_runs
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Material
from fpnav.sim.world import Gateway, Point, Route, Space, Visuals, World
from fpnav.sim.worlds.hall_layout import EAST, PAST_M, Range

LEFT, RIGHT = 1.0, -1.0
BLOCKED_M = 0.8
"""A hallway is at its end where the wall ahead is this near."""

STOP_M = 0.35
"""A way into a blockage ends this near; the robot stops up to its look ahead before that."""

ASIDE = {"O": "corridor", "B": "corridor", "N": "lobby"}
"""What lies behind an opening that closes, goes on to the wall ahead, or does not close."""


@dataclass(frozen=True, slots=True)
class Plot:
    """One building: its spaces, the robot's way, where along x the gateway has its centre and
    its edges. ``half_width_m`` of the hallway, 0 in a room."""

    spaces: tuple[Space, ...]
    way: tuple[Point, ...]
    centre_m: float
    edges_m: tuple[float, float]
    half_width_m: float = 0.0

    def moved(self, dx: float, dy: float, name: str) -> Plot:
        """The same elsewhere, its spaces named after it."""
        spaces = tuple(
            Space(f"{name}-{s.name}", s.kind, s.x0 + dx, s.y0 + dy, s.x1 + dx, s.y1 + dy)
            for s in self.spaces
        )
        way = tuple((x + dx, y + dy) for x, y in self.way)
        edges = self.edges_m[0] + dx, self.edges_m[1] + dx
        return replace(self, spaces=spaces, way=way, centre_m=self.centre_m + dx, edges_m=edges)


class GatewayTypesParams(Params, frozen=True):
    """Ranges are drawn from once per building; gateway_types.toml says what each is for."""

    hall_m: Range
    height_m: Range
    opening_m: Range
    exit_m: Range
    wide_m: Range
    depth_m: Range
    gap_m: Range
    room_m: Range
    beside_m: Range
    lateral_m: float
    pitch_m: float
    speed_mps: float


PARAMS = GatewayTypesParams
Draw = Callable[[GatewayTypesParams, np.random.Generator], Plot]


def hall(left: str, right: str, *, blocked: bool = False) -> Draw:
    """A hallway: W wall, O opening, N no closing, B to the blockage ahead."""

    def draw(params: GatewayTypesParams, rng: np.random.Generator) -> Plot:
        wide, start = _one(params.hall_m, rng), 3.0 + _one(params.gap_m, rng)
        opening, room = _one(params.opening_m, rng), _one(params.room_m, rng)
        end = start + _blocked_after(left, right, opening, rng) if blocked else start + room + 9.0
        sides: list[Space] = []
        spans: list[tuple[str, float, float]] = []
        for state, side in ((left, LEFT), (right, RIGHT)):
            if state == "W":
                continue
            first = start + 0.9 if state == "B" and "N" in (left, right) else start
            width = {"O": opening, "N": room, "B": end - first}[state]
            last = min(first + width, end)
            near, far = side * wide / 2, side * (wide / 2 + _one(params.depth_m, rng))
            name = "left" if side == LEFT else "right"
            low, high = min(near, far), max(near, far)
            sides.append(Space(name, ASIDE[state], first, low, last, high))
            spans.append((state, first, last))
        centre, edges = _middle(spans, end)
        stop = end - STOP_M if blocked else start + (3.8 if "N" in (left, right) else opening + 2.4)
        whole = Space("hall", "corridor", 0.0, -wide / 2, end, wide / 2)
        half = (wide - THICKNESS_M) / 2
        return Plot((whole, *sides), ((1.2, 0.0), (stop, 0.0)), centre, edges, half)

    return draw


def _blocked_after(left: str, right: str, opening: float, rng: np.random.Generator) -> float:
    """How far beyond where the openings start the hallway is at its end."""
    if "N" in (left, right):
        return 4.3
    if "O" in (left, right):
        return opening + float(rng.uniform(1.1, 1.3))
    return opening if "B" in (left, right) else 0.0


def _middle(spans: list[tuple[str, float, float]], end: float) -> tuple[float, tuple[float, float]]:
    """Centre and edges of a gateway: the mean of the middles of what closes."""
    closed = [(first, last) for state, first, last in spans if state != "N"]
    if closed:
        middle = sum(first + last for first, last in closed) / 2 / len(closed)
        return middle, (min(first for first, _ in closed), max(last for _, last in closed))
    if spans:
        first = spans[0][1]
        return first + PAST_M, (first, spans[0][2])
    wall = end - THICKNESS_M / 2
    return wall - BLOCKED_M, (wall - BLOCKED_M, wall)


def beside(side: float, shape: str) -> Draw:
    """A room whose wall the robot follows, with an exit in that wall."""

    def draw(params: GatewayTypesParams, rng: np.random.Generator) -> Plot:
        away, length = _one(params.beside_m, rng), float(rng.uniform(10.5, 12.0))
        width = _one(params.wide_m if shape == "WIDE" else params.exit_m, rng)
        first = float(rng.uniform(6.0, 6.6)) - (0.6 if shape == "WIDE" else 0.0)
        if shape == "CORNER":
            first = length - width - float(rng.uniform(0.1, 0.25))
        deep, depth = float(rng.uniform(7.0, 8.0)), _one(params.depth_m, rng)
        room = Space("room", "lobby", 0.0, -side * away, length, side * (deep - away))
        out = Space("exit", "corridor", first, -side * away, first + width, -side * (away + depth))
        stop = length - STOP_M if shape == "CORNER" else first + width + 2.2
        turn = float(rng.uniform(3.1, 3.5))
        way = ((turn, side * 4.0), (turn, 0.0), (stop, params.lateral_m * rng.uniform(-1, 1)))
        centre, edges = first + width / 2, (first, first + width)
        # A room on the left of the exit's wall has the exit on the robot's right.
        return Plot((_upright(room), _upright(out)), _points(way), centre, edges)

    return draw


def ahead(shape: str) -> Draw:
    """A room that the robot leaves through an exit in the wall ahead."""

    def draw(params: GatewayTypesParams, rng: np.random.Generator) -> Plot:
        length, deep = float(rng.uniform(8.5, 10.0)), float(rng.uniform(6.4, 7.5))
        width = _one(params.wide_m if shape == "WIDE" else params.exit_m, rng)
        left = width / 2 + 0.35 if shape == "CORNER" else deep / 2
        through, depth = float(rng.uniform(0.45, 0.55)), _one(params.depth_m, rng)
        room = Space("room", "lobby", 0.0, left - deep, length, left)
        end = length + through
        door = Space("exit", "corridor", length, -width / 2, end, width / 2)
        beyond = Space("beyond", "lobby", end, -4.0, end + depth, 4.0)
        start = (3.2, left - deep / 2) if shape == "CORNER" else (2.9, 0.0)
        lateral = 0.5 * params.lateral_m * rng.uniform(-1, 1)
        way = (start, (3.2, lateral), (end + 2.2, lateral))
        return Plot((room, door, beyond), _points(way), length + through / 2, (length, end))

    return draw


def _upright(space: Space) -> Space:
    low, high = sorted((space.y0, space.y1))
    return replace(space, y0=low, y1=high)


def _points(way: tuple[tuple[float, float], ...]) -> tuple[Point, ...]:
    return tuple((float(x), float(y)) for x, y in way)


def _one(range_m: Range, rng: np.random.Generator) -> float:
    return float(rng.uniform(*range_m))


TYPES: dict[str, Draw] = {
    "LEFT OPENING": hall("O", "W"),
    "RIGHT OPENING": hall("W", "O"),
    "LEFT ROOM": hall("N", "W"),
    "RIGHT ROOM": hall("W", "N"),
    "CROSS": hall("O", "O"),
    "LEFT OPENING RIGHT ROOM": hall("O", "N"),
    "LEFT ROOM RIGHT OPENING": hall("N", "O"),
    "BOTH ROOM": hall("N", "N"),
    "DEAD END": hall("W", "W", blocked=True),
    "LEFT TURN": hall("B", "W", blocked=True),
    "RIGHT TURN": hall("W", "B", blocked=True),
    "T-SHAPE": hall("B", "B", blocked=True),
    "LEFT OPENING RIGHT TURN": hall("O", "B", blocked=True),
    "LEFT ROOM RIGHT TURN": hall("N", "B", blocked=True),
    "RIGHT OPENING LEFT TURN": hall("B", "O", blocked=True),
    "RIGHT ROOM LEFT TURN": hall("B", "N", blocked=True),
    "LEFT CORNER EXIT": beside(RIGHT, "CORNER"),
    "RIGHT CORNER EXIT": beside(LEFT, "CORNER"),
    "FRONT CORNER EXIT": ahead("CORNER"),
    "LEFT MID EXIT": beside(RIGHT, "MID"),
    "RIGHT MID EXIT": beside(LEFT, "MID"),
    "FRONT MID EXIT": ahead("MID"),
    "LEFT WIDE EXIT": beside(RIGHT, "WIDE"),
    "RIGHT WIDE EXIT": beside(LEFT, "WIDE"),
    "FRONT WIDE EXIT": ahead("WIDE"),
}
"""Name of every type in the order of systems.md 3.4, and what draws a building for it; of the
exits beside, the side is that of the wall the room lies on."""

ROUTES = tuple(f"type-{number:02d}" for number in range(1, len(TYPES) + 1))
COLUMNS = 5


def make(params: GatewayTypesParams, seed: int, run: int) -> World:
    """The buildings of ``seed`` on a grid."""
    height = float(generator(seed, "height").uniform(*params.height_m))
    style = house_style(generator(seed, "style"), height)
    plots = {route: _plot(params, seed, number, route) for number, route in enumerate(ROUTES)}
    spaces = tuple(space for plot in plots.values() for space in plot.spaces)
    runs = tuple(wall_runs(spaces))
    finish: Finish = corridor_finish(style, generator(seed, "finish"), 0.5)
    floor = Floor(spaces, runs, (), {s.name: finish for s in spaces}, {}, Material("brick"))
    lamps, panels = ceiling_lamps(
        spaces, height, generator(seed, run, "lamps"), off_share=0.05, spread=0.2,
        warmth_spread=0.05,
    )  # fmt: skip
    kinds = dict(zip(ROUTES, TYPES, strict=True))
    return World(
        name="gateway_types",
        seed=seed,
        run=run,
        faces=(*floor.faces(), *panels),
        lamps=lamps,
        daylight=weather(seed, run),
        visuals=Visuals(light_resolution_m=0.25),
        spaces=spaces,
        gateways=tuple(_gateway(route, kinds[route], plot) for route, plot in plots.items()),
        walls=tuple(segments(runs)),
        routes={route: _route(params, route, plot) for route, plot in plots.items()},
    )


def _plot(params: GatewayTypesParams, seed: int, number: int, route: str) -> Plot:
    draw = list(TYPES.values())[number]
    drawn = draw(params, generator(seed, "plot", route))
    row, column = divmod(number, COLUMNS)
    return drawn.moved(column * params.pitch_m, row * params.pitch_m, route)


def _gateway(route: str, kind: str, plot: Plot) -> Gateway:
    opens, closes = (edge - plot.centre_m for edge in plot.edges_m)
    y = plot.way[-1][1]
    return Gateway(route[-2:], route, plot.centre_m, y, EAST, kind, opens, closes)


def _route(params: GatewayTypesParams, name: str, plot: Plot) -> Route:
    return Route(
        name,
        plot.way,
        speed_mps=params.speed_mps,
        step_m=0.05,
        lookahead_m=0.25,
        half_width_m=plot.half_width_m,
        stops=(name[-2:],),
    )
