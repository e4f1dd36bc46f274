"""One working room: a line of places through its middle, and a goal to come home to."""

from __future__ import annotations

import math

import numpy as np

from fpnav.params import Params
from fpnav.sim import rooms, scenery
from fpnav.sim.building import Floor
from fpnav.sim.decor import ROOM_KINDS, Style, house_style, room_finish, room_palette
from fpnav.sim.lighting import ceiling_lamps, weather
from fpnav.sim.plan import Opening, Run, doors_of, segments, wall_runs
from fpnav.sim.rooms import Furnished
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Material
from fpnav.sim.world import Change, Mark, Point, Route, Space, Visuals, Walk, World

WHITE = Material(colour=(0.9, 0.9, 0.88))
HALL_M = 2.0


class RoomParams(Params, frozen=True):
    """Sizes in metres; room.toml says what each is for."""

    width_m: float
    depth_m: float
    height_m: float
    saturation: float
    clutter: float
    posters: float
    line_m: float
    line_step_m: float
    places: int
    spacing_m: float
    ring: int
    ring_m: float
    grid_m: float
    grid_step_m: float
    moved_share: float
    people: int
    lamps_off: float
    lamp_spread: float
    warmth_spread: float


PARAMS = RoomParams


def make(params: RoomParams, seed: int, run: int) -> World:
    """The room of ``seed`` as it is on ``run``; a hall lies behind its open door."""
    room = Space("room", "office", 0.0, 0.0, params.width_m, params.depth_m)
    hall = Space("hall", "corridor", 0.0, params.depth_m, params.width_m, params.depth_m + HALL_M)
    style = house_style(generator(seed, "style"), params.height_m)
    floor, moved = _floor(params, (room, hall), style, seed, run)
    lamps, panels = ceiling_lamps(
        (room, hall),
        params.height_m,
        generator(seed, run, "lamps"),
        off_share=params.lamps_off,
        spread=params.lamp_spread,
        warmth_spread=params.warmth_spread,
    )
    outside = scenery.surroundings(generator(seed, "outside"), 0.0, 0.0, hall.x1, hall.y1)
    return World(
        name="room",
        seed=seed,
        run=run,
        faces=(*floor.faces(), *panels, *outside),
        lamps=lamps,
        daylight=weather(seed, run),
        visuals=Visuals(light_resolution_m=0.2, light_rays=32),
        spaces=(room, hall),
        doors=tuple(doors_of(floor.runs, floor.openings)),
        changes=tuple(moved),
        walls=tuple(segments(floor.runs)),
        routes={"line": _line(params, room), "homing": _homing(params, room)},
        walks=_walks(params, seed, run),
    )


def _floor(
    params: RoomParams, spaces: tuple[Space, Space], style: Style, seed: int, run: int
) -> tuple[Floor, list[Change]]:
    room, hall = spaces
    runs = tuple(wall_runs(spaces))
    openings = tuple(_openings(params, style, seed))
    furnished = _furnish(params, room, runs, openings, style, seed)
    moved = rooms.rearranged(furnished, generator(seed, run, "moved"), params.moved_share)
    finishes = {
        space.name: room_finish(
            style, generator(seed, "finish", space.name), space is room, params.saturation
        )
        for space in spaces
    }
    inside = {room.name: furnished, hall.name: Furnished(hall)}
    return Floor(spaces, runs, openings, finishes, inside, Material("brick")), moved


def _openings(params: RoomParams, style: Style, seed: int) -> list[Opening]:
    """A door to the hall, two windows opposite, one on a side."""
    rng = generator(seed, "openings")
    leaf = Material(f"panel:{int(rng.integers(4))}", style.door)
    at = float(rng.uniform(0.8, params.width_m - 0.8))
    hinge = 1 if at > params.width_m / 2 else -1
    angle = math.radians(float(rng.uniform(85, 105)))
    made = [Opening("room", "hall", at, 0.92, leaf_rad=angle, hinge=hinge, colour=leaf)]
    for share in (0.28, 0.72):
        width = float(rng.uniform(1.1, 1.6))
        made.append(_window(share * params.width_m, width, 0))
    if rng.random() < 0.6:
        made.append(_window(float(rng.uniform(1.5, params.depth_m - 2.5)), 1.3, 1))
    return made


def _window(at: float, width: float, along: int) -> Opening:
    return Opening("room", "", at, width, "window", along, 0.9, 2.15, frame=WHITE)


def _furnish(
    params: RoomParams,
    room: Space,
    runs: tuple[Run, ...],
    openings: tuple[Opening, ...],
    style: Style,
    seed: int,
) -> Furnished:
    """Furniture that leaves the line and the ring free."""
    rng = generator(seed, "furniture")
    made = Furnished(room)
    rooms.reserve_openings(made, runs, openings)
    palette = room_palette(style, rng, True, params.saturation)
    kinds = [*ROOM_KINDS["office"], *ROOM_KINDS["study"], "radiator", "plant", "lockers"]
    lane = (2.0 * params.ring_m + 0.2, params.line_m + 0.1)
    rooms.furnish(
        made,
        rng,
        palette,
        kinds,
        clutter=params.clutter,
        posters=params.posters,
        deepest_m=1.2,
        least_lane_m=lane,
    )
    return made


def _line(params: RoomParams, room: Space) -> Route:
    """Straight up the middle of the room, the places about the middle of the line."""
    x, y = room.centre
    half = params.line_m / 2
    first = y - (params.places - 1) / 2 * params.spacing_m
    marks = tuple(
        Mark(f"place-{k + 1}", x, first + k * params.spacing_m, params.line_step_m / 2)
        for k in range(params.places)
    )
    return Route(
        "line",
        ((x, y - half), (x, y + half + 0.5)),
        length_m=params.line_m + params.line_step_m / 2,
        speed_mps=0.1,
        step_m=params.line_step_m,
        marks=marks,
    )


def _homing(params: RoomParams, room: Space) -> Route:
    """Goal, the ring of places around it, then line by line over the disc."""
    x, y = room.centre
    ring = [
        (x + params.ring_m * math.cos(angle), y + params.ring_m * math.sin(angle))
        for angle in np.arange(params.ring) * 2 * math.pi / params.ring
    ]
    marks = [Mark("goal", x, y, 0.06)]
    marks += [Mark(f"place-{k + 1}", px, py, 0.06) for k, (px, py) in enumerate(ring)]
    circle = np.radians(np.arange(0.0, 361.0, 9.0))
    way = [(x, y)]
    way += [(x + params.ring_m * math.cos(a), y + params.ring_m * math.sin(a)) for a in circle]
    way += _grid(x, y, params.grid_m, params.grid_step_m)
    return Route(
        "homing", tuple(way), speed_mps=0.2, step_m=0.1, lookahead_m=0.08, marks=tuple(marks)
    )


def _grid(x: float, y: float, radius: float, step: float) -> list[Point]:
    """Lines across a disc, there and back."""
    count = math.floor(radius / step)
    points: list[Point] = []
    for k in range(-count, count + 1):
        across = k * step
        half = math.sqrt(max(radius**2 - across**2, 0.0))
        ends = [(x + across, y - half), (x + across, y + half)]
        points += ends if k % 2 == 0 else ends[::-1]
    return points


def _walks(params: RoomParams, seed: int, run: int) -> tuple[Walk, ...]:
    """People who cross the room."""
    rng = generator(seed, run, "people")
    low, high = (0.7, 0.7), (params.width_m - 0.7, params.depth_m - 0.7)
    return tuple(
        Walk(
            tuple((float(x), float(y)) for x, y in rng.uniform(low, high, (3, 2))),
            float(rng.uniform(0.4, 0.9)),
            float(rng.uniform(0, 20)),
        )
        for _ in range(params.people)
    )
