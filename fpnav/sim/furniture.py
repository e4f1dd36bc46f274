"""Things that stand in rooms. All are built with their back at y = 0 and their front to -y."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from fpnav.sim.solids import Colour, Face, Material, blob, box, moved, picture, prism, turned


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours a room is furnished in."""

    wood: Colour
    metal: Colour
    accent: Colour
    second: Colour


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Furniture with its footprint: ``width_m`` along the wall, ``depth_m`` into the room."""

    kind: str
    width_m: float
    depth_m: float
    faces: list[Face]
    movable: bool = False


def hue(rng: np.random.Generator, saturation: float, value: float) -> Colour:
    """Colour of a random hue."""
    return hsv(float(rng.uniform(0.0, 360.0)), saturation, value)


def hsv(hue_deg: float, saturation: float, value: float) -> Colour:
    """sRGB of hue in degrees, saturation and value in 0..1."""
    pixel = np.array([[[hue_deg % 360.0, saturation, value]]], dtype=np.float32)
    r, g, b = cv2.cvtColor(pixel, cv2.COLOR_HSV2RGB)[0, 0].tolist()
    return r, g, b


def _variant(rng: np.random.Generator, kind: str, variants: int = 12) -> str:
    return f"{kind}:{int(rng.integers(variants))}"


def cupboard(rng: np.random.Generator, palette: Palette) -> Piece:
    """Closed cupboard of any height."""
    w, d = float(rng.uniform(0.8, 1.2)), float(rng.uniform(0.4, 0.5))
    h = float(rng.choice([0.75, 1.2, 1.95]))
    coloured = rng.random() < 0.3
    body = Material("wood", palette.wood) if not coloured else Material("metal", palette.accent)
    front = Material(_variant(rng, "drawers", 6), body.colour)
    faces = box((-w / 2, -d, 0), (w / 2, 0, h), body, front=front)
    if h < 1.0 and rng.random() < 0.6:
        faces += moved(pot(rng, palette).faces, (0.0, -d / 2, h))
    return Piece("cupboard", w, d, faces)


def bookcase(rng: np.random.Generator, palette: Palette) -> Piece:
    """Open shelf of books."""
    w, d, h = float(rng.uniform(0.8, 1.6)), 0.32, float(rng.uniform(1.6, 2.1))
    front = Material(_variant(rng, "books"))
    return Piece(
        "bookcase",
        w,
        d,
        box((-w / 2, -d, 0), (w / 2, 0, h), Material("wood", palette.wood), front=front),
    )


def desk(rng: np.random.Generator, palette: Palette) -> Piece:
    """Desk with drawers, screen, things on it and a chair before it."""
    w, d, top = float(rng.uniform(1.3, 1.8)), 0.75, 0.73
    board = Material("wood", palette.wood)
    legs = Material("metal", palette.metal)
    faces = box((-w / 2, -d, top - 0.03), (w / 2, 0, top), board, bottom=True)
    drawer = Material(_variant(rng, "drawers", 6), palette.second)
    faces += box(
        (w / 2 - 0.45, -d + 0.05, 0), (w / 2 - 0.03, -0.05, top - 0.04), legs, front=drawer
    )
    faces += box((-w / 2, -d + 0.03, 0), (-w / 2 + 0.04, -0.03, top - 0.03), legs)
    for _ in range(int(rng.integers(1, 3))):
        faces += moved(_monitor(rng), (float(rng.uniform(-w / 3, w / 3)), -0.3, top))
    if rng.random() < 0.7:
        stack = box((-0.15, -0.11, 0), (0.15, 0.11, float(rng.uniform(0.03, 0.25))), _paper(rng))
        faces += moved(stack, (float(rng.uniform(-w / 2 + 0.2, w / 2 - 0.2)), -0.5, top))
    seat = chair(rng, palette)
    swing = turned(seat.faces, (0.0, -0.25), float(rng.uniform(-0.8, 0.8)))
    faces += moved(swing, (float(rng.uniform(-0.3, 0.2)), -d + 0.15, 0.0))
    return Piece("desk", w, d + 0.35, faces)


def _paper(rng: np.random.Generator) -> Material:
    return Material(colour=hue(rng, float(rng.uniform(0.0, 0.8)), 0.85))


def _monitor(rng: np.random.Generator) -> list[Face]:
    w, h = float(rng.uniform(0.4, 0.6)), float(rng.uniform(0.28, 0.36))
    dark = Material(colour=(0.08, 0.08, 0.09))
    shown = Material(_variant(rng, "screen", 8), emission=0.5)
    turn = float(rng.uniform(-0.4, 0.4))
    head = box((-w / 2, -0.03, 0.1), (w / 2, 0.03, 0.1 + h), dark, front=shown, bottom=True)
    return turned(head + box((-0.05, -0.02, 0), (0.05, 0.02, 0.1), dark), (0.0, 0.0), turn)


def chair(rng: np.random.Generator, palette: Palette) -> Piece:
    """Office chair."""
    cloth = Material("fabric", palette.accent, (0.3, 0.3), rough=0.9)
    dark = Material(colour=(0.12, 0.12, 0.13))
    faces = box((-0.23, -0.47, 0.42), (0.23, -0.03, 0.5), cloth, bottom=True)
    faces += box((-0.21, -0.5, 0.55), (0.21, -0.44, 0.98), cloth, bottom=True)
    faces += prism((0.0, -0.25), 0.03, 0.05, 0.42, dark, sides=6, cap=False)
    faces += box((-0.28, -0.28, 0.02), (0.28, -0.22, 0.07), dark)
    faces += box((-0.03, -0.53, 0.02), (0.03, 0.03, 0.07), dark)
    return Piece("chair", 0.56, 0.56, faces, movable=True)


def pot(rng: np.random.Generator, palette: Palette) -> Piece:
    """Small potted plant."""
    faces = prism((0.0, 0.0), 0.09, 0.0, 0.16, Material(colour=palette.accent), sides=8)
    green = Material(_variant(rng, "foliage", 3), (1.1, 1.15, 1.0), (0.3, 0.3), rough=1.0)
    size = float(rng.uniform(0.12, 0.22))
    faces += blob((0, 0, 0.16 + size), (size, size, size * 1.2), green, rng, subdivisions=1)
    return Piece("pot", 0.2, 0.2, faces, movable=True)


def plant(rng: np.random.Generator, palette: Palette) -> Piece:
    """Tall plant in a tub."""
    r, h = float(rng.uniform(0.17, 0.22)), float(rng.uniform(0.3, 0.45))
    faces = prism((0.0, -0.25), r, 0.0, h, Material(colour=palette.second), sides=10, taper=1.15)
    green = Material(_variant(rng, "foliage", 3), (1.1, 1.15, 1.0), (0.35, 0.35), rough=1.0)
    tall = float(rng.uniform(0.35, 0.65))
    faces += blob((0, -0.25, h + tall), (0.25, 0.24, tall), green, rng, rough=0.35)
    return Piece("plant", 0.55, 0.5, faces, movable=True)


def bin_(rng: np.random.Generator, palette: Palette) -> Piece:
    """Waste bin."""
    tone = hue(rng, float(rng.choice([0.0, 0.7])), float(rng.uniform(0.3, 0.8)))
    faces = prism((0.0, -0.17), 0.14, 0.0, 0.36, Material(colour=tone), sides=10, taper=1.2)
    return Piece("bin", 0.36, 0.34, faces, movable=True)


def cartons(rng: np.random.Generator, palette: Palette) -> Piece:
    """Stack of boxes somebody left."""
    faces, z = [], 0.0
    for _ in range(int(rng.integers(1, 5))):
        w, h = float(rng.uniform(0.3, 0.5)), float(rng.uniform(0.2, 0.4))
        card = Material("concrete", (0.86, 0.68, 0.46), rough=0.7)
        turn = float(rng.uniform(-0.2, 0.2))
        faces += turned(box((-w / 2, -0.42, z), (w / 2, -0.06, z + h), card), (0.0, -0.24), turn)
        z += h
    return Piece("cartons", 0.55, 0.48, faces, movable=True)


def radiator(rng: np.random.Generator, palette: Palette) -> Piece:
    """Ribbed heater."""
    w = float(rng.uniform(0.8, 1.4))
    ribs = Material("grille", (0.95, 0.95, 0.92), (0.8, 0.8), rough=0.8)
    return Piece("radiator", w, 0.12, box((-w / 2, -0.12, 0.12), (w / 2, -0.02, 0.72), ribs))


def lockers(rng: np.random.Generator, palette: Palette) -> Piece:
    """Row of narrow lockers."""
    count = int(rng.integers(2, 5))
    tone = hue(rng, 0.55, 0.7)
    faces: list[Face] = []
    for i in range(count):
        x = (i - count / 2) * 0.3
        front = Material(f"panel:{i % 3}", tone)
        faces += box((x, -0.4, 0), (x + 0.295, 0, 1.8), Material("metal", tone), front=front)
    return Piece("lockers", 0.3 * count, 0.4, faces)


def vending(rng: np.random.Generator, palette: Palette) -> Piece:
    """Vending machine with a lit front."""
    tone = hue(rng, 0.8, 0.75)
    front = Material(_variant(rng, "poster", 24), emission=0.35)
    faces = box((-0.45, -0.7, 0), (0.45, 0, 1.85), Material("metal", tone), front=front)
    return Piece("vending", 0.9, 0.7, faces)


def copier(rng: np.random.Generator, palette: Palette) -> Piece:
    """Photocopier."""
    grey = Material(colour=(0.82, 0.82, 0.8))
    faces = box((-0.35, -0.6, 0), (0.35, -0.02, 0.95), grey, front=Material("drawers:3"))
    faces += box((-0.3, -0.55, 0.95), (0.3, -0.05, 1.1), Material(colour=(0.25, 0.27, 0.3)))
    return Piece("copier", 0.7, 0.6, faces)


def bench(rng: np.random.Generator, palette: Palette) -> Piece:
    """Seat for those who wait."""
    w = float(rng.uniform(1.2, 1.8))
    seat = Material("planks", palette.wood)
    faces = box((-w / 2, -0.42, 0.4), (w / 2, -0.05, 0.46), seat, bottom=True)
    for x in (-w / 2 + 0.1, w / 2 - 0.16):
        faces += box((x, -0.4, 0), (x + 0.06, -0.07, 0.4), Material("metal", palette.metal))
    return Piece("bench", w, 0.42, faces)


def kitchen(rng: np.random.Generator, palette: Palette) -> Piece:
    """Kitchen unit with wall cupboards."""
    w, front = float(rng.uniform(1.6, 2.2)), Material("drawers:2", palette.accent)
    body = Material("wood", palette.wood)
    faces = box((-w / 2, -0.6, 0), (w / 2, 0, 0.88), body, front=front)
    faces += box((-w / 2, -0.35, 1.4), (w / 2, 0, 2.05), body, front=front, bottom=True)
    faces += box((-w / 2, -0.62, 0.88), (w / 2, 0, 0.92), Material("concrete", (0.7, 0.7, 0.7)))
    fridge = box((w / 2, -0.6, 0), (w / 2 + 0.6, 0, 1.8), Material(colour=(0.92, 0.92, 0.93)))
    return Piece("kitchen", w + 1.2, 0.62, faces + fridge)


def workbench(rng: np.random.Generator, palette: Palette) -> Piece:
    """Laboratory bench with instruments."""
    w, top = float(rng.uniform(1.6, 2.4)), 0.9
    faces = box((-w / 2, -0.75, top - 0.05), (w / 2, 0, top), Material("planks"), bottom=True)
    for x in (-w / 2, w / 2 - 0.08):
        faces += box((x, -0.7, 0), (x + 0.08, -0.05, top - 0.05), Material("metal", palette.metal))
    for _ in range(int(rng.integers(2, 5))):
        a, b, h = (float(v) for v in rng.uniform((0.2, 0.2, 0.15), (0.45, 0.4, 0.45)))
        tone = Material("metal", hue(rng, float(rng.uniform(0.0, 0.7)), 0.7))
        front = Material(_variant(rng, "screen", 8), emission=0.3)
        thing = box((-a / 2, -b, 0), (a / 2, 0, h), tone, front=front)
        faces += moved(thing, (float(rng.uniform(-w / 2 + 0.3, w / 2 - 0.3)), -0.2, top))
    return Piece("workbench", w, 0.75, faces)


def hanging(rng: np.random.Generator, kind: str, variants: int) -> Piece:
    """Poster, pin board or whiteboard on the wall; takes no floor."""
    sizes = {"poster": ((0.4, 0.9), (0.5, 1.2)), "notes": ((0.8, 1.6), (0.7, 1.1))}
    (w0, w1), (h0, h1) = sizes.get(kind, ((1.2, 2.0), (0.9, 1.2)))
    w, h = float(rng.uniform(w0, w1)), float(rng.uniform(h0, h1))
    z = float(rng.uniform(1.5, 1.7)) - h / 2
    shown = Material(_variant(rng, kind, variants))
    rim = box((-w / 2, -0.015, z), (w / 2, 0, z + h), Material(colour=(0.8, 0.8, 0.8)))
    front = picture((-w / 2, -0.018, z), (w, 0, 0), (0, 0, h), shown)
    return Piece(kind, w, 0.0, [*rim, front])


def doorway(rng: np.random.Generator, palette: Palette) -> Piece:
    """Closed door in its frame, flush with the wall; takes no floor."""
    w, high, rim = float(rng.uniform(0.8, 1.0)), 2.05, float(rng.uniform(0.07, 0.12))
    leaf = Material(_variant(rng, "panel", 4), palette.second)
    frame = Material(colour=palette.wood)
    faces = box((-w / 2 - rim, -0.025, 0), (-w / 2, 0, high + rim), frame)
    faces += box((w / 2, -0.025, 0), (w / 2 + rim, 0, high + rim), frame)
    faces += box((-w / 2, -0.025, high), (w / 2, 0, high + rim), frame, bottom=True)
    faces.append(picture((-w / 2, -0.008, 0), (w, 0, 0), (0, 0, high), leaf))
    return Piece("doorway", w + 2 * rim, 0.0, faces)


def extinguisher(rng: np.random.Generator, palette: Palette) -> Piece:
    """Fire extinguisher on the wall."""
    red = Material(colour=(0.8, 0.06, 0.05))
    return Piece("extinguisher", 0.25, 0.2, prism((0.0, -0.1), 0.08, 0.6, 1.15, red, sides=8))


STANDING: dict[str, Callable[[np.random.Generator, Palette], Piece]] = {
    "cupboard": cupboard,
    "bookcase": bookcase,
    "desk": desk,
    "plant": plant,
    "bin": bin_,
    "cartons": cartons,
    "radiator": radiator,
    "lockers": lockers,
    "vending": vending,
    "copier": copier,
    "bench": bench,
    "kitchen": kitchen,
    "workbench": workbench,
    "extinguisher": extinguisher,
}
