"""Hallways and gateways: the paper's seven with three routes, or any number on one long route."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fpnav.sim import rooms
from fpnav.sim.building import Finish, Floor
from fpnav.sim.decor import Style, corridor_finish, house_style
from fpnav.sim.furniture import Palette, doorway
from fpnav.sim.lighting import ceiling_lamps, weather
from fpnav.sim.plan import Run, segments, wall_runs
from fpnav.sim.rooms import Furnished
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Material
from fpnav.sim.world import Change, Space, Visuals, Walk, World
from fpnav.sim.worlds.hall_layout import GatewaysParams, Layout
from fpnav.sim.worlds.serpentine import serpentine
from fpnav.sim.worlds.seven_gateways import seven_gateways

PARAMS = GatewaysParams
MOUTH_M = 1.3
"""How far into a room that opens on a hall its side walls stay bare."""


def make(params: GatewaysParams, seed: int, run: int) -> World:
    """The building of ``seed`` as it is on ``run``."""
    draw = seven_gateways if params.gateways <= 7 else serpentine
    layout = draw(params, generator(seed, "halls"))
    spaces = layout.spaces
    height = float(generator(seed, "height").uniform(*params.height_m))
    style = house_style(generator(seed, "style"), height)
    floor, moved = _floor(params, spaces, style, seed, run)
    lamps, panels = ceiling_lamps(
        spaces,
        height,
        generator(seed, run, "lamps"),
        off_share=params.lamps_off,
        spread=params.lamp_spread,
        warmth_spread=params.warmth_spread,
    )
    return World(
        name="gateways",
        seed=seed,
        run=run,
        faces=(*floor.faces(), *panels),
        lamps=lamps,
        daylight=weather(seed, run),
        visuals=Visuals(light_resolution_m=0.25),
        spaces=spaces,
        gateways=layout.gateways,
        changes=tuple(moved),
        walls=tuple(segments(floor.runs)),
        routes=layout.routes(params.speed_mps),
        walks=_walks(params, layout, seed, run),
    )


def _floor(
    params: GatewaysParams, spaces: tuple[Space, ...], style: Style, seed: int, run: int
) -> tuple[Floor, list[Change]]:
    runs = tuple(wall_runs(spaces))
    finishes: dict[str, Finish] = {}
    furnished: dict[str, Furnished] = {}
    moved: list[Change] = []
    for space in spaces:
        rng = generator(seed, "finish", space.name)
        finishes[space.name] = corridor_finish(style, rng, params.saturation)
        room = _furnish(params, space, spaces, runs, style, seed)
        moved += rooms.rearranged(
            room, generator(seed, run, "moved", space.name), params.moved_share
        )
        furnished[space.name] = room
    return Floor(spaces, runs, (), finishes, furnished, Material("brick")), moved


def _furnish(
    params: GatewaysParams,
    space: Space,
    spaces: tuple[Space, ...],
    runs: tuple[Run, ...],
    style: Style,
    seed: int,
) -> Furnished:
    """Dark doorways and posters in the halls, furniture in the room.

    An opening that is walled up on this run is left bare, so that all else stays where it is.
    """
    rng = generator(seed, "furniture", space.name)
    room = Furnished(space)
    rooms.reserve_open_sides(room, [_opened(other) for other in spaces])
    if space.kind == "lobby":
        _keep_mouth_free(room, spaces)
    for wall in range(4):
        for _ in range(int(rng.poisson(params.doors * room.wall_length(wall) / 2.5))):
            rooms.hang(room, rng, doorway(rng, _dark(rng)), wall)
    kinds = ("desk", "plant", "bookcase", "bench", "cupboard") if space.kind == "lobby" else ()
    rooms.furnish(room, rng, style.palette, kinds, clutter=1.0, posters=params.posters)
    return room


def _opened(space: Space) -> Space:
    return replace(space, kind="corridor") if space.kind == "closed" else space


def _keep_mouth_free(room: Furnished, spaces: tuple[Space, ...]) -> None:
    """Nothing stands in a room's mouth: its edges are where the hall's wall ends."""
    north = any(math.isclose(other.y0, room.space.y1) for other in spaces)
    for wall in (1, 3):
        first = (wall == 1) == north
        at = MOUTH_M / 2 if first else room.wall_length(wall) - MOUTH_M / 2
        room.reserve(wall, at, MOUTH_M)


def _dark(rng: np.random.Generator) -> Palette:
    """Door frames are dark, walls are light."""
    tone = float(rng.uniform(0.06, 0.2))
    return Palette((tone, tone, tone), (0.4, 0.4, 0.4), (0.5, 0.4, 0.3), (0.7, 0.7, 0.68))


def _walks(params: GatewaysParams, layout: Layout, seed: int, run: int) -> tuple[Walk, ...]:
    """People in the long halls."""
    rng = generator(seed, run, "people")
    halls = [space for space in layout.spaces if space.x1 - space.x0 > 18.0]
    made = []
    for _ in range(params.people):
        hall = halls[int(rng.integers(len(halls)))]
        x0 = float(rng.uniform(hall.x0 + 2.0, hall.x1 - 15.0))
        side = hall.centre[1] + float(rng.choice([-1.0, 1.0])) * 0.25 * layout.wide
        way = ((x0, side), (x0 + float(rng.uniform(5, 12)), side))
        made.append(Walk(way, float(rng.uniform(0.7, 1.3)), float(rng.uniform(0, 30))))
    return tuple(made)
