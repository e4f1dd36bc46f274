"""House style: palettes and finishes, drawn so that rooms are alike to a chosen degree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fpnav.sim.building import Finish
from fpnav.sim.furniture import Palette, hsv
from fpnav.sim.solids import Colour, Material

ROOM_KINDS: dict[str, tuple[str, ...]] = {
    "office": ("desk", "bookcase", "desk", "cupboard", "plant", "bin", "bookcase", "cartons"),
    "study": ("desk", "bookcase", "bookcase", "plant", "cupboard", "bin"),
    "laboratory": ("workbench", "workbench", "cupboard", "lockers", "desk", "cartons", "bin"),
    "store": ("bookcase", "lockers", "cartons", "cartons", "cupboard", "cartons"),
    "kitchen": ("kitchen", "bench", "vending", "plant", "bin"),
    "meeting": ("cupboard", "bench", "plant", "bench", "bin", "radiator"),
    "copying": ("copier", "cupboard", "bookcase", "bin", "cartons"),
}
ROOM_SHARES = (0.42, 0.2, 0.12, 0.06, 0.05, 0.1, 0.05)


@dataclass(frozen=True, slots=True)
class Style:
    """What a house has in common."""

    palette: Palette
    wall: Colour
    floor: Material
    room_floor: Material
    ceiling: Material
    door: Colour
    height_m: float


def house_style(rng: np.random.Generator, height_m: float) -> Style:
    """The common style of one building."""
    floors = (
        Material("linoleum", hsv(float(rng.uniform(0, 360)), 0.18, 0.62), (1.5, 1.5), rough=0.1),
        Material("tiles", hsv(float(rng.uniform(20, 60)), 0.15, 0.7), (1.6, 1.6), rough=0.1),
        Material("concrete", (0.6, 0.6, 0.58), (3.0, 3.0), rough=0.2),
    )
    rooms = (
        Material("carpet", hsv(float(rng.uniform(0, 360)), 0.25, 0.5), (1.0, 1.0), rough=0.6),
        Material("planks", (1.0, 0.95, 0.9), (1.2, 1.2), rough=0.1),
    )
    return Style(
        Palette(
            wood=hsv(float(rng.uniform(20, 40)), 0.12, float(rng.uniform(0.75, 1.0))),
            metal=(0.6, 0.6, 0.62),
            accent=hsv(float(rng.uniform(0, 360)), 0.55, 0.6),
            second=hsv(float(rng.uniform(0, 360)), 0.25, 0.7),
        ),
        wall=hsv(float(rng.uniform(20, 70)), 0.06, 0.92),
        floor=floors[int(rng.integers(len(floors)))],
        room_floor=rooms[int(rng.integers(len(rooms)))],
        ceiling=Material("ceiling", (0.95, 0.95, 0.95), (1.2, 1.2)),
        door=hsv(float(rng.uniform(0, 360)), 0.45, 0.6),
        height_m=height_m,
    )


def room_palette(style: Style, rng: np.random.Generator, own: bool, saturation: float) -> Palette:
    """Palette of a room: the house's, or its own."""
    if not own:
        return style.palette
    return Palette(
        wood=hsv(float(rng.uniform(15, 45)), float(rng.uniform(0.0, 0.3)), 0.85),
        metal=style.palette.metal,
        accent=hsv(float(rng.uniform(0, 360)), saturation, float(rng.uniform(0.4, 0.85))),
        second=hsv(float(rng.uniform(0, 360)), saturation * 0.6, float(rng.uniform(0.4, 0.85))),
    )


def room_finish(style: Style, rng: np.random.Generator, own: bool, saturation: float) -> Finish:
    """Walls and floor of a room."""
    wall = Material("plaster", style.wall, (2.5, 2.5))
    floor = style.room_floor
    if own:
        tone = hsv(float(rng.uniform(0, 360)), saturation * float(rng.uniform(0.1, 0.6)), 0.85)
        wall = Material("plaster", tone, (2.5, 2.5))
        floor = Material("carpet", hsv(float(rng.uniform(0, 360)), 0.3, 0.5), rough=0.6)
    return Finish(wall, floor, style.ceiling, style.height_m)


def corridor_finish(style: Style, rng: np.random.Generator, saturation: float) -> Finish:
    """A stretch of corridor: house walls, a dado of its own colour."""
    wall = Material("plaster", style.wall, (2.5, 2.5))
    tone = hsv(float(rng.uniform(0, 360)), saturation * float(rng.uniform(0.3, 1.0)), 0.75)
    kind = str(rng.choice(["plaster", "wood", "brick"], p=[0.7, 0.15, 0.15]))
    dado = Material(kind, tone if kind == "plaster" else (1.0, 1.0, 1.0), (2.0, 2.0))
    has_dado = rng.random() < 0.7
    high = float(rng.uniform(0.8, 1.3))
    return Finish(
        wall, style.floor, style.ceiling, style.height_m, dado if has_dado else None, high
    )
