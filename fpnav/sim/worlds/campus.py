"""Campus: plain buildings without number, each built by itself when the robot is in it."""

from __future__ import annotations

import math

import numpy as np

from fpnav.params import Params
from fpnav.sim import rooms
from fpnav.sim.building import Finish, Floor
from fpnav.sim.decor import house_style, room_finish, room_palette
from fpnav.sim.lighting import ceiling_lamps, weather
from fpnav.sim.plan import Opening, doors_of, segments, wall_runs
from fpnav.sim.rooms import Furnished
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Material
from fpnav.sim.world import Blocks, Point, Route, Space, Visuals, World

DOOR_M = 0.92
MARGIN_M = 8.0
KINDS = ("bookcase", "cupboard", "lockers", "cartons", "radiator", "copier", "vending")


class CampusParams(Params, frozen=True):
    """Sizes in metres; ``part`` is the building to make, -1 the plan of all of them."""

    places: int
    samples: int
    rooms_a_side: int
    room_m: tuple[float, float]
    depth_m: tuple[float, float]
    corridor_m: float
    height_m: float
    furniture: int
    saturation: float
    posters: float
    part: int = -1


PARAMS = CampusParams


def make(params: CampusParams, seed: int, run: int) -> World:
    """The plan of the whole campus, or one building of it with all that stands in it."""
    blocks = _blocks(params)
    if params.part >= 0:
        return _building(params, blocks, seed, run)
    count = math.ceil(params.places / (2 * params.rooms_a_side))
    spaces = [space for part in range(count) for space in plan_of(params, blocks, seed, part)]
    places = [space for space in spaces if space.kind != "corridor"][: params.places]
    return World(
        name="campus",
        seed=seed,
        run=run,
        faces=(),
        lamps=(),
        daylight=weather(seed, run),
        visuals=Visuals(),
        spaces=tuple(spaces),
        routes={"tour": _tour(params, places, seed, run)},
        blocks=blocks,
    )


def _blocks(params: CampusParams) -> Blocks:
    """Grid that holds the largest building there can be."""
    count = math.ceil(params.places / (2 * params.rooms_a_side))
    long = params.rooms_a_side * params.room_m[1] + MARGIN_M
    deep = 2 * params.depth_m[1] + params.corridor_m + MARGIN_M
    return Blocks(long, deep, max(1, math.ceil(math.sqrt(count))))


def plan_of(params: CampusParams, blocks: Blocks, seed: int, part: int) -> list[Space]:
    """Rooms, in the order of the tour, and the corridor of one building."""
    rng = generator(seed, "plan", part)
    x0, y0 = blocks.corner(part)
    widths = rng.uniform(*params.room_m, (2, params.rooms_a_side))
    widths[1] *= widths[0].sum() / widths[1].sum()
    south, north = (float(depth) for depth in rng.uniform(*params.depth_m, 2))
    low, high = y0 + south, y0 + south + params.corridor_m
    cuts = x0 + np.concatenate([np.zeros((2, 1)), np.cumsum(widths, axis=1)], axis=1)
    cuts[1, -1] = cuts[0, -1]
    made = []
    for i in range(params.rooms_a_side):
        a, b = cuts[0, i : i + 2].tolist()
        c, d = cuts[1, i : i + 2].tolist()
        made.append(Space(f"{part}-s{i}", "room", a, y0, b, low))
        made.append(Space(f"{part}-n{i}", "room", c, high, d, high + north))
    return [*made, Space(f"{part}-hall", "corridor", x0, low, float(cuts[0, -1]), high)]


def _building(params: CampusParams, blocks: Blocks, seed: int, run: int) -> World:
    part = params.part
    spaces = tuple(plan_of(params, blocks, seed, part))
    style = house_style(generator(seed, "style", part), params.height_m)
    runs = tuple(wall_runs(spaces))
    openings = tuple(_doors(spaces, seed, part))
    finishes: dict[str, Finish] = {}
    furnished: dict[str, Furnished] = {}
    for space in spaces:
        rng = generator(seed, "room", space.name)
        finishes[space.name] = room_finish(style, rng, True, params.saturation)
        room = furnished[space.name] = Furnished(space)
        rooms.reserve_openings(room, runs, openings)
        rooms.reserve_open_sides(room, spaces)
        count = params.furniture if space.kind == "room" else 0
        kinds = [str(kind) for kind in rng.choice(KINDS, count)]
        palette = room_palette(style, rng, True, params.saturation)
        rooms.furnish(room, rng, palette, kinds, clutter=1.0, posters=params.posters)
    floor = Floor(spaces, runs, openings, finishes, furnished, Material("brick"))
    lamps, panels = ceiling_lamps(
        spaces,
        params.height_m,
        generator(seed, run, "lamps", part),
        off_share=0.05,
        spread=0.2,
        warmth_spread=0.05,
    )
    return World(
        name="campus",
        seed=seed,
        run=run,
        faces=(*floor.faces(), *panels),
        lamps=lamps,
        daylight=weather(seed, run),
        visuals=Visuals(light_resolution_m=0.5, light_rays=12),
        spaces=spaces,
        doors=tuple(doors_of(runs, openings)),
        walls=tuple(segments(runs)),
        blocks=blocks,
    )


def _doors(spaces: tuple[Space, ...], seed: int, part: int) -> list[Opening]:
    """One open doorway from each room to the corridor."""
    hall = spaces[-1]
    made = []
    for room in spaces[:-1]:
        rng = generator(seed, "door", room.name)
        margin = DOOR_M / 2 + 0.25
        at = float(rng.uniform(room.x0 + margin, room.x1 - margin))
        leaf = math.radians(float(rng.uniform(82, 105)))
        hinge = 1 if at > room.centre[0] else -1
        colour = Material(f"panel:{part % 4}", (0.6, 0.5, 0.4))
        made.append(
            Opening(room.name, hall.name, at, DOOR_M, leaf_rad=leaf, hinge=hinge, colour=colour)
        )
    return made


def _tour(params: CampusParams, places: list[Space], seed: int, run: int) -> Route:
    """A point or more in the middle of every room, elsewhere on every run."""
    rng = generator(seed, run, "tour")
    reach = np.array([0.12, 0.1])
    points: list[Point] = []
    for space in places:
        size = np.array([space.x1 - space.x0, space.y1 - space.y0])
        shifts = rng.uniform(-reach, reach, (params.samples, 2)) * size
        x, y = space.centre
        points += [(x + float(dx), y + float(dy)) for dx, dy in shifts]
    if run % 2 == 0:
        points.reverse()
    if len(points) == 1:
        points.append((points[0][0] + 0.1, points[0][1]))
    return Route("tour", tuple(points), carried=True)
