"""Office floor: a ring of corridors, rooms on both sides, some of them behind closed doors."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from fpnav.params import Params
from fpnav.sim import rooms, scenery
from fpnav.sim.building import Finish, Floor
from fpnav.sim.decor import (
    ROOM_KINDS,
    ROOM_SHARES,
    Style,
    corridor_finish,
    house_style,
    room_finish,
    room_palette,
)
from fpnav.sim.lighting import ceiling_lamps, weather
from fpnav.sim.plan import (
    OPEN_KINDS,
    THICKNESS_M,
    Opening,
    Run,
    doors_of,
    segments,
    wall_runs,
)
from fpnav.sim.rooms import Furnished
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Face, Material
from fpnav.sim.tours import Backbone
from fpnav.sim.world import Change, Point, Space, Visuals, World
from fpnav.sim.worlds.office_ways import routes_of, stops_of, walks_of

Range = tuple[float, float]
ROUTES = ("map", "test", "loop-1", "loop-2", "loop-3", "loop-4", "loop-5")
DOOR_M = 0.92
CORRIDOR_KINDS = ("radiator", "extinguisher", "radiator", "bin")
LOBBY_KINDS = ("vending", "bench", "plant", "lockers", "copier", "plant", "bin")


class OfficeParams(Params, frozen=True):
    """Ranges are drawn from once per seed; shares are probabilities (office.toml says which)."""

    length_m: Range
    corridor_m: Range
    outer_depth_m: Range
    core_depth_m: Range
    room_m: Range
    height_m: Range
    similarity: float
    saturation: float
    clutter: float
    posters: float
    lobbies: float
    through_rooms: float
    closed_share: float
    moved_share: float
    people: int
    lamps_off: float
    lamp_spread: float
    warmth_spread: float
    blinds: float
    map_m: float
    test_m: float


@dataclass(frozen=True, slots=True)
class Plan:
    """Spaces of the floor, and the ring its corridors make."""

    spaces: tuple[Space, ...]
    ring: tuple[Point, ...]
    half_m: float

    @property
    def corridors(self) -> list[Space]:
        """Pieces of corridor."""
        return [space for space in self.spaces if space.kind == "corridor"]

    @property
    def rooms(self) -> list[Space]:
        """Everything that is not corridor."""
        return [space for space in self.spaces if space.kind != "corridor"]


def make(params: OfficeParams, seed: int, run: int) -> World:
    """The building of ``seed`` as it is on ``run``."""
    plan = draw_plan(params, generator(seed, "plan"))
    style = house_style(generator(seed, "style"), _draw(generator(seed, "height"), params.height_m))
    floor, moved = _floor(params, plan, style, seed, run)
    backbone = Backbone(plan.ring, _reach(plan, floor))
    stops = stops_of(floor, backbone)
    lamps, panels = ceiling_lamps(
        plan.spaces,
        style.height_m,
        generator(seed, run, "lamps"),
        off_share=params.lamps_off,
        spread=params.lamp_spread,
        warmth_spread=params.warmth_spread,
    )
    return World(
        name="office",
        seed=seed,
        run=run,
        faces=(*floor.faces(), *panels, *_outside(plan, seed)),
        lamps=lamps,
        daylight=weather(seed, run),
        visuals=Visuals(),
        spaces=plan.spaces,
        doors=tuple(doors_of(floor.runs, floor.openings)),
        changes=(*_changes(plan, floor), *moved),
        walls=tuple(segments(floor.runs)),
        routes=routes_of(backbone, stops, seed, params.map_m, params.test_m),
        walks=walks_of(backbone, params.people, seed, run),
    )


def _floor(
    params: OfficeParams, plan: Plan, style: Style, seed: int, run: int
) -> tuple[Floor, list[Change]]:
    runs = tuple(wall_runs(plan.spaces))
    openings = tuple(_openings(params, plan, style, seed, run))
    finishes = {space.name: _finish(params, space, style, seed) for space in plan.spaces}
    furnished, moved = _furnish_all(params, plan, style, runs, openings, seed, run)
    outside = Material("brick", repeat_m=(1.2, 1.2))
    return Floor(plan.spaces, runs, openings, finishes, furnished, outside), moved


def _reach(plan: Plan, floor: Floor) -> tuple[float, float]:
    """How far the robot may be to each side of the middle of any corridor."""
    deepest = max(max(floor.furnished[c.name].inset_m) for c in plan.corridors)
    free = plan.half_m - THICKNESS_M / 2 - deepest - 0.3
    return (max(0.05, min(free, 0.5)),) * 2


def _draw(rng: np.random.Generator, low_high: Range) -> float:
    return float(rng.uniform(*low_high))


def draw_plan(params: OfficeParams, rng: np.random.Generator) -> Plan:
    """Bands of rooms south, inside and north of a ring of corridors."""
    long, wide = _draw(rng, params.length_m), _draw(rng, params.corridor_m)
    south, north = _draw(rng, params.outer_depth_m), _draw(rng, params.outer_depth_m)
    core = _draw(rng, params.core_depth_m)
    y = np.cumsum([0.0, south, wide, core, wide, north]).tolist()
    spaces = _row(params, rng, "s", 0.0, long, y[0], y[1], outer=True)
    spaces += _row(params, rng, "n", 0.0, long, y[4], y[5], outer=True)
    if core > 6.4 and rng.random() > params.through_rooms:
        middle = y[2] + core * float(rng.uniform(0.45, 0.55))
        spaces += _row(params, rng, "c", wide, long - wide, y[2], middle)
        spaces += _row(params, rng, "d", wide, long - wide, middle, y[3])
    else:
        spaces += _row(params, rng, "c", wide, long - wide, y[2], y[3])
    spaces += _corridor(rng, "corridor-south", 0.0, long, y[1], y[2])
    spaces += _corridor(rng, "corridor-north", 0.0, long, y[3], y[4])
    spaces.append(Space("corridor-west", "corridor", 0.0, y[2], wide, y[3]))
    spaces.append(Space("corridor-east", "corridor", long - wide, y[2], long, y[3]))
    half = wide / 2
    ys, yn = y[1] + half, y[3] + half
    ring = ((half, ys), (long - half, ys), (long - half, yn), (half, yn), (half, ys))
    return Plan(tuple(spaces), ring, half)


def _row(
    params: OfficeParams,
    rng: np.random.Generator,
    name: str,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    outer: bool = False,
) -> list[Space]:
    """Rooms side by side from x0 to x1."""
    widths: list[float] = []
    while sum(widths) < x1 - x0:
        widths.append(_draw(rng, params.room_m))
    if len(widths) > 1 and sum(widths) - (x1 - x0) > widths[-1] / 2:
        widths.pop()
    cuts = x0 + np.concatenate([[0.0], np.cumsum(widths)]) * (x1 - x0) / sum(widths)
    made = []
    for i, (a, b) in enumerate(itertools.pairwise(cuts)):
        kind = str(rng.choice(list(ROOM_KINDS), p=ROOM_SHARES))
        if outer and 0 < i < len(widths) - 1 and rng.random() < params.lobbies:
            kind = "lobby"
        made.append(Space(f"room-{name}{i + 1}", kind, float(a), y0, float(b), y1))
    return made


def _corridor(
    rng: np.random.Generator, name: str, x0: float, x1: float, y0: float, y1: float
) -> list[Space]:
    """Two or three pieces of corridor that look different."""
    count = int(rng.integers(2, 4))
    inner = np.sort(rng.uniform(-0.12, 0.12, count - 1) + np.arange(1, count) / count)
    cuts = x0 + np.concatenate([[0.0], inner, [1.0]]) * (x1 - x0)
    return [
        Space(f"{name}-{i + 1}", "corridor", float(a), y0, float(b), y1)
        for i, (a, b) in enumerate(itertools.pairwise(cuts))
    ]


def _openings(params: OfficeParams, plan: Plan, style: Style, seed: int, run: int) -> list[Opening]:
    """Doors from rooms to corridors, windows to the outside."""
    made = []
    for room in plan.rooms:
        rng = generator(seed, "openings", room.name)
        if room.kind != "lobby":
            made += _doors(params, plan, room, style, rng)
        made += _windows(params, plan, room, rng, generator(seed, run, "blinds", room.name))
    return made


def _doors(
    params: OfficeParams, plan: Plan, room: Space, style: Style, rng: np.random.Generator
) -> list[Opening]:
    """One door to each corridor the room touches; a room is closed or open for good."""
    closed = rng.random() < params.closed_share
    own = rng.random() > params.similarity
    tone = style.door if not own else room_palette(style, rng, True, params.saturation).accent
    leaf = Material(f"panel:{int(rng.integers(4))}", tone)
    frame = Material("wood", (0.5 * tone[0] + 0.3, 0.5 * tone[1] + 0.3, 0.5 * tone[2] + 0.3))
    made = []
    for above in (False, True):
        touching = [c for c in plan.corridors if _touches(room, c, above)]
        at, corridor = _spot(rng, room, touching)
        angle = 0.0 if closed else math.radians(float(rng.uniform(82, 105)))
        hinge = 1 if at > (room.x0 + room.x1) / 2 else -1
        if corridor is not None:
            made.append(
                Opening(
                    room.name,
                    corridor.name,
                    at,
                    DOOR_M,
                    leaf_rad=angle,
                    hinge=hinge,
                    colour=leaf,
                    frame=frame,
                )
            )
    return made


def _touches(room: Space, corridor: Space, above: bool) -> bool:
    edge = math.isclose(room.y1, corridor.y0) if above else math.isclose(room.y0, corridor.y1)
    return edge and min(room.x1, corridor.x1) - max(room.x0, corridor.x0) > DOOR_M + 0.5


def _spot(
    rng: np.random.Generator, room: Space, corridors: list[Space]
) -> tuple[float, Space | None]:
    """Where the door goes: anywhere along the widest common stretch, clear of its ends."""
    best, found = 0.0, None
    for corridor in corridors:
        common = min(room.x1, corridor.x1) - max(room.x0, corridor.x0)
        if common > best:
            best, found = common, corridor
    if found is None:
        return 0.0, None
    low, high = max(room.x0, found.x0), min(room.x1, found.x1)
    margin = DOOR_M / 2 + 0.2
    return float(rng.uniform(low + margin, high - margin)), found


def _windows(
    params: OfficeParams,
    plan: Plan,
    room: Space,
    rng: np.random.Generator,
    run_rng: np.random.Generator,
) -> list[Opening]:
    """A window or two in the outer wall; on some runs the blinds are down."""
    top = max(space.y1 for space in plan.spaces)
    if room.y0 > 0.0 and room.y1 < top:
        return []
    width = float(rng.uniform(1.1, 1.7))
    count = 2 if room.x1 - room.x0 > 2 * width + 1.2 else 1
    white = Material(colour=(0.9, 0.9, 0.88))
    made = []
    for i in range(count):
        at = room.x0 + (room.x1 - room.x0) * (i + 1) / (count + 1)
        down = run_rng.random() < params.blinds
        leaf = 0.0 if down else math.nan
        cloth = Material("grille", (0.9, 0.9, 0.85), (0.6, 0.6))
        hole = Opening(room.name, "", at, width, "window", 0, 0.9, 2.15, leaf, 1, cloth, white)
        made.append(hole)
    return made


def _finish(params: OfficeParams, space: Space, style: Style, seed: int) -> Finish:
    rng = generator(seed, "finish", space.name)
    if space.kind in OPEN_KINDS:
        return corridor_finish(style, rng, params.saturation)
    return room_finish(style, rng, bool(rng.random() > params.similarity), params.saturation)


def _furnish_all(
    params: OfficeParams,
    plan: Plan,
    style: Style,
    runs: tuple[Run, ...],
    openings: tuple[Opening, ...],
    seed: int,
    run: int,
) -> tuple[dict[str, Furnished], list[Change]]:
    """Furniture of every space, and what was taken away or left there since."""
    rooms_made: dict[str, Furnished] = {}
    moved: list[Change] = []
    for space in plan.spaces:
        room = Furnished(space)
        rooms.reserve_openings(room, runs, openings)
        rooms.reserve_open_sides(room, plan.spaces)
        _fill(params, room, style, generator(seed, "furniture", space.name))
        chance = generator(seed, run, "moved", space.name)
        moved += rooms.rearranged(room, chance, params.moved_share)
        rooms_made[space.name] = room
    return rooms_made, moved


def _fill(params: OfficeParams, room: Furnished, style: Style, rng: np.random.Generator) -> None:
    own = bool(rng.random() > params.similarity)
    palette = room_palette(style, rng, own, params.saturation)
    if room.space.kind == "corridor":
        rooms.furnish(
            room,
            rng,
            palette,
            CORRIDOR_KINDS,
            clutter=params.clutter,
            posters=params.posters,
            deepest_m=0.35,
            least_lane_m=(0.6, 0.6),
        )
        return
    kinds = LOBBY_KINDS if room.space.kind == "lobby" else ROOM_KINDS[room.space.kind]
    rooms.furnish(room, rng, palette, kinds, clutter=params.clutter, posters=params.posters)


def _changes(plan: Plan, floor: Floor) -> list[Change]:
    """Corners of the ring, borders between pieces of corridor, large things beside the way."""
    made = [Change("corner", "corridor", x, y) for x, y in plan.ring[:-1]]
    for a in plan.corridors:
        for b in plan.corridors:
            if math.isclose(a.x1, b.x0) and math.isclose(a.y0, b.y0):
                made.append(Change("colour", f"{a.name}|{b.name}", a.x1, (a.y0 + a.y1) / 2))
    for room in floor.furnished.values():
        if room.space.kind == "lobby":
            made += _lobby_edges(plan, room.space)
    return made


def _lobby_edges(plan: Plan, lobby: Space) -> list[Change]:
    """Where a lobby begins and ends, on the middle of the corridor beside it."""
    south = lobby.y0 == 0.0
    y = lobby.y1 + plan.half_m if south else lobby.y0 - plan.half_m
    return [Change("lobby", lobby.name, x, y) for x in (lobby.x0, lobby.x1)]


def _outside(plan: Plan, seed: int) -> list[Face]:
    far_x, far_y = max(s.x1 for s in plan.spaces), max(s.y1 for s in plan.spaces)
    return scenery.surroundings(generator(seed, "outside"), 0.0, 0.0, far_x, far_y)


PARAMS = OfficeParams
