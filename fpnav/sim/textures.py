"""Procedural textures: every kind is a function of a seeded generator, tileable or shown once.

A texture is (height, width, 3) float32 in 0..1, sRGB, row 0 at the top; a material's colour tints
it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sim.seeds import generator

Picture = NDArray[np.float32]
SIZE = 256


def make_texture(name: str, seed: int) -> Picture:
    """The texture ``kind`` or ``kind:variant`` of a world.

    Raises
    ------
    KeyError
        No kind has that name (a fault of the world's generator).
    """
    kind = name.partition(":")[0]
    made = KINDS[kind](generator(seed, "texture", name))
    return np.clip(made, 0.0, 1.0).astype(np.float32)


def is_tiled(name: str) -> bool:
    """Whether the texture repeats (and may start anywhere) instead of being one picture."""
    return name.partition(":")[0] not in ONCE


def noise(rng: np.random.Generator, cells_x: int, cells_y: int | None = None) -> NDArray[Any]:
    """Tileable smooth noise in 0..1, (SIZE, SIZE), with that many cells along x and y."""
    grid = rng.random((cells_y or cells_x, cells_x), dtype=np.float32)
    wrapped = np.pad(grid, 2, mode="wrap")
    scale_x, scale_y = SIZE / grid.shape[1], SIZE / grid.shape[0]
    x = (np.arange(SIZE, dtype=np.float32) + 0.5) / scale_x - 0.5 + 2
    y = (np.arange(SIZE, dtype=np.float32) + 0.5) / scale_y - 0.5 + 2
    map_x, map_y = np.meshgrid(x, y)
    return np.asarray(cv2.remap(wrapped, map_x, map_y, cv2.INTER_LINEAR))


def fractal(rng: np.random.Generator, cells: int, octaves: int = 4) -> NDArray[Any]:
    """Sum of noises of doubled frequency and halved weight, in 0..1."""
    weights = 0.5 ** np.arange(octaves)
    layers = [
        weight * noise(rng, min(SIZE, cells << i)) for i, weight in enumerate(weights.tolist())
    ]
    return np.asarray(sum(layers) / weights.sum())


def _grey(values: NDArray[Any]) -> Picture:
    return np.repeat(np.asarray(values, dtype=np.float32)[..., None], 3, axis=2)


def _mixed(weight: NDArray[Any], first: tuple[float, ...], second: tuple[float, ...]) -> Picture:
    w = np.asarray(weight, dtype=np.float32)[..., None]
    return np.asarray(w * np.array(first) + (1 - w) * np.array(second), dtype=np.float32)


def _colour(rng: np.random.Generator, saturation: float = 0.7, value: float = 0.8) -> list[float]:
    hsv = np.array([[[rng.uniform(0, 360), saturation, value]]], dtype=np.float32)
    made: list[float] = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0].tolist()
    return made


def plain(rng: np.random.Generator) -> Picture:
    """Nearly even paint."""
    return _grey(0.94 + 0.06 * noise(rng, 8))


def plaster(rng: np.random.Generator) -> Picture:
    """Painted wall: grain, faint stains."""
    grain = rng.normal(0.0, 0.012, (SIZE, SIZE))
    return _grey(0.86 + 0.12 * fractal(rng, 4) + grain)


def concrete(rng: np.random.Generator) -> Picture:
    """Blotched grey with pores."""
    pores = (rng.random((SIZE, SIZE)) > 0.996) * 0.25
    return _grey(0.55 + 0.4 * fractal(rng, 3, 6) - cv2.GaussianBlur(pores, (0, 0), 0.8))


def carpet(rng: np.random.Generator) -> Picture:
    """Short pile with worn patches."""
    return _grey(0.7 + 0.2 * fractal(rng, 3) + rng.normal(0.0, 0.07, (SIZE, SIZE)))


def linoleum(rng: np.random.Generator) -> Picture:
    """Floor covering with marbled specks."""
    return _grey(0.72 + 0.25 * (fractal(rng, 48, 2) > 0.52) * fractal(rng, 64, 2))


def tiles(rng: np.random.Generator) -> Picture:
    """Four by four tiles with joints."""
    return _grid(rng, 4, 4, joint=3, spread=0.08)


def ceiling(rng: np.random.Generator) -> Picture:
    """Perforated panels, two by two."""
    holes = (rng.random((SIZE, SIZE)) > 0.97) * 0.1
    return _grid(rng, 2, 2, joint=3, spread=0.02) - _grey(holes)


def paving(rng: np.random.Generator) -> Picture:
    """Slabs with dark joints and dirt."""
    return _grid(rng, 4, 6, joint=4, spread=0.2) * _grey(0.8 + 0.2 * fractal(rng, 4))


def brick(rng: np.random.Generator) -> Picture:
    """Running bond with mortar."""
    rows, columns = 12, 4
    shade = 0.75 + 0.25 * rng.random((rows, columns, 3)) * np.array([1.0, 0.7, 0.6])
    out = np.ones((SIZE, SIZE, 3)) * 0.72
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    row = y * rows // SIZE
    along = (x + (row % 2) * SIZE // (2 * columns)) % SIZE
    inside = (y * rows % SIZE > SIZE // 8) & (along * columns % SIZE > SIZE // 20)
    base = np.array([0.72, 0.36, 0.27])
    out[inside] = (base * shade[row, along * columns // SIZE])[inside]
    return np.asarray(out * (0.85 + 0.15 * _grey(fractal(rng, 16, 2))), dtype=np.float32)


def wood(rng: np.random.Generator) -> Picture:
    """Grain along the vertical."""
    rings = np.sin(40.0 * noise(rng, 6, 1) + 9.0 * fractal(rng, 2)) * 0.5 + 0.5
    fine = noise(rng, 128, 4)
    return _mixed(0.6 * rings + 0.4 * fine, (0.86, 0.66, 0.42), (0.62, 0.42, 0.24))


def planks(rng: np.random.Generator) -> Picture:
    """Wooden boards side by side."""
    boards = np.repeat(0.75 + 0.25 * rng.random((1, 8)), SIZE // 8, axis=1)
    gaps = (np.arange(SIZE) % (SIZE // 8) < 2) * 0.4
    return np.asarray(wood(rng) * (boards - gaps)[..., None], dtype=np.float32)


def metal(rng: np.random.Generator) -> Picture:
    """Brushed sheet."""
    return _grey(0.75 + 0.2 * noise(rng, 2, 128))


def fabric(rng: np.random.Generator) -> Picture:
    """Woven cloth."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    return _grey(0.8 + 0.15 * ((x // 4 + y // 4) % 2) + rng.normal(0.0, 0.04, (SIZE, SIZE)))


def foliage(rng: np.random.Generator) -> Picture:
    """Leaves of several greens with dark gaps between."""
    shade = fractal(rng, 24, 3)
    leaves = _mixed(noise(rng, 40), (0.62, 0.70, 0.30), (0.24, 0.44, 0.14))
    return np.asarray(leaves * _grey(np.clip(2.2 * (shade - 0.28), 0.12, 1.1)), dtype=np.float32)


def grass(rng: np.random.Generator) -> Picture:
    """Lawn with dry patches."""
    blades = rng.random((SIZE, SIZE)) * 0.35 + 0.65
    tint = _mixed(fractal(rng, 3), (0.58, 0.58, 0.26), (0.28, 0.44, 0.16))
    return np.asarray(tint * _grey(blades), dtype=np.float32)


def asphalt(rng: np.random.Generator) -> Picture:
    """Tar and gravel."""
    return _grey(0.42 + 0.18 * fractal(rng, 4) + rng.normal(0.0, 0.05, (SIZE, SIZE)))


def bark(rng: np.random.Generator) -> Picture:
    """Vertical furrows."""
    return _mixed(noise(rng, 24, 5) * fractal(rng, 8), (0.70, 0.60, 0.50), (0.28, 0.22, 0.17))


def facade(rng: np.random.Generator) -> Picture:
    """One bay by one storey: wall with a window, sill and frame."""
    return _windowed(_grey(0.85 + 0.1 * fractal(rng, 8)), rng)


def townhouse(rng: np.random.Generator) -> Picture:
    """One bay by one storey of brick."""
    return _windowed(brick(rng), rng)


def _windowed(out: Picture, rng: np.random.Generator) -> Picture:
    left, right = (int(SIZE * f) for f in (rng.uniform(0.18, 0.28), rng.uniform(0.72, 0.82)))
    top, low = (int(SIZE * f) for f in (rng.uniform(0.15, 0.25), rng.uniform(0.65, 0.85)))
    out[top - 8 : low + 8, left - 8 : right + 8] = rng.uniform(0.35, 0.95)
    glass = np.linspace(0.38, 0.16, low - top, dtype=np.float32)[:, None, None]
    out[top:low, left:right] = glass * np.array([0.85, 1.0, 1.15]) * rng.uniform(0.7, 1.5)
    middle = (left + right) // 2
    out[top:low, middle - 3 : middle + 3] = 0.7
    out[low + 8 : low + 14, left - 14 : right + 14] = 0.5
    return out


def books(rng: np.random.Generator) -> Picture:
    """Four boards of book spines."""
    out = np.full((SIZE, SIZE, 3), 0.18, dtype=np.float32)
    shelf = SIZE // 4
    for row in range(4):
        x = 2
        while x < SIZE - 8:
            width, height = int(rng.integers(5, 17)), int(rng.integers(shelf // 2, shelf - 8))
            bottom = (row + 1) * shelf - 5
            tone = _colour(rng, rng.uniform(0.1, 0.9), rng.uniform(0.25, 0.9))
            out[bottom - height : bottom, x : min(x + width, SIZE - 4)] = tone
            x += width + int(rng.random() < 0.12) * int(rng.integers(5, 40)) + 1
        out[(row + 1) * shelf - 5 : (row + 1) * shelf] = (0.55, 0.42, 0.28)
    return out


def poster(rng: np.random.Generator) -> Picture:
    """Sheet with a coloured ground, shapes and lines of text."""
    saturation = float(rng.uniform(0.1, 0.9))
    out = np.full((SIZE, SIZE, 3), _colour(rng, saturation, rng.uniform(0.5, 0.95)), np.float32)
    for _ in range(int(rng.integers(2, 6))):
        tone = _colour(rng, rng.uniform(0.3, 1.0), rng.uniform(0.3, 1.0))
        a, b = rng.integers(0, SIZE, 2).tolist(), rng.integers(0, SIZE, 2).tolist()
        if rng.random() < 0.5:
            cv2.rectangle(out, a, b, tone, -1)
        else:
            cv2.circle(out, a, int(rng.integers(15, 70)), tone, -1)
    ink = float(rng.choice([0.05, 0.95]))
    for y in range(int(rng.integers(20, 160)), SIZE - 20, int(rng.integers(10, 22))):
        cv2.line(out, (20, y), (int(rng.integers(90, 235)), y), (ink, ink, ink), 3)
    out[:4], out[-4:], out[:, :4], out[:, -4:] = 1.0, 1.0, 1.0, 1.0
    return out


def notes(rng: np.random.Generator) -> Picture:
    """Pin board full of paper."""
    out = np.asarray(_mixed(fractal(rng, 32, 2), (0.78, 0.58, 0.36), (0.62, 0.44, 0.26)))
    for _ in range(int(rng.integers(8, 18))):
        x, y = rng.integers(4, SIZE - 60, 2).tolist()
        w, h = rng.integers(22, 56, 2).tolist()
        out[y : y + h, x : x + w] = _colour(rng, rng.choice([0.05, 0.1, 0.6]), 0.95)
        for line in range(y + 6, y + h - 4, 6):
            out[line : line + 2, x + 4 : x + int(rng.integers(10, max(11, w - 2)))] = 0.25
    return out


def whiteboard(rng: np.random.Generator) -> Picture:
    """Scribbles in three inks on white."""
    out = _grey(0.93 + 0.05 * noise(rng, 6))
    inks = ((0.1, 0.2, 0.7), (0.75, 0.1, 0.1), (0.05, 0.05, 0.05), (0.0, 0.5, 0.2))
    for _ in range(int(rng.integers(4, 12))):
        start = rng.integers(15, SIZE - 70, 2)
        steps = rng.integers(-12, 16, (int(rng.integers(5, 30)), 2))
        stroke = np.clip(start + np.cumsum(steps, axis=0), 8, SIZE - 8).astype(np.int32)
        cv2.polylines(out, [stroke[:, None]], False, inks[int(rng.integers(4))], 2)
    out[:6], out[-8:], out[:, :6], out[:, -6:] = 0.6, 0.6, 0.6, 0.6
    return out


def screen(rng: np.random.Generator) -> Picture:
    """Monitor with windows open."""
    out = np.full((SIZE, SIZE, 3), _colour(rng, 0.5, rng.uniform(0.2, 0.5)), np.float32)
    for _ in range(int(rng.integers(1, 4))):
        x, y = rng.integers(10, SIZE // 2, 2).tolist()
        out[y : y + 110, x : x + 120] = rng.uniform(0.7, 0.95)
        out[y : y + 10, x : x + 120] = _colour(rng, 0.6, 0.7)
        for line in range(y + 18, y + 104, 9):
            out[line : line + 3, x + 6 : x + int(rng.integers(20, 110))] = 0.3
    out[:10], out[-10:], out[:, :8], out[:, -8:] = 0.05, 0.05, 0.05, 0.05
    return out


def panel(rng: np.random.Generator) -> Picture:
    """Door leaf or cupboard front: framed field, handle."""
    out = _grey(0.85 + 0.1 * noise(rng, 2, 32))
    out[4:-4, 4:-4] *= 0.97
    out[10:-10, 10:12], out[10:-10, -12:-10] = 0.55, 0.55
    out[10:12, 10:-10], out[-12:-10, 10:-10] = 0.55, 0.55
    out[SIZE // 2 - 5 : SIZE // 2 + 5, 20:44] = 0.25
    return out


def drawers(rng: np.random.Generator) -> Picture:
    """Cupboard front with boards and handles."""
    count = int(rng.integers(2, 6))
    out = _grey(0.88 + 0.08 * noise(rng, 2, 32))
    for row in range(count):
        y = row * SIZE // count
        out[y : y + 4] = 0.4
        out[y + 16 : y + 22, SIZE // 2 - 24 : SIZE // 2 + 24] = 0.3
    out[:, :4], out[:, -4:] = 0.5, 0.5
    return out


def grille(rng: np.random.Generator) -> Picture:
    """Radiator ribs."""
    ribs = 0.75 + 0.25 * np.cos(2 * np.pi * np.arange(SIZE) / 16.0)
    return _grey(np.broadcast_to(ribs, (SIZE, SIZE)) * (0.96 + 0.04 * noise(rng, 4)))


def stripes(rng: np.random.Generator) -> Picture:
    """Three horizontal bands."""
    bands = rng.uniform(0.55, 1.0, 3)
    rows = bands[np.arange(SIZE) * 3 // SIZE]
    return _grey(np.broadcast_to(rows[:, None], (SIZE, SIZE)) * (0.95 + 0.05 * noise(rng, 8)))


def _grid(rng: np.random.Generator, nx: int, ny: int, *, joint: int, spread: float) -> Picture:
    shade = 1.0 - spread * rng.random((ny, nx))
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    out = shade[y * ny // SIZE, x * nx // SIZE]
    gap = (x % (SIZE // nx) < joint) | (y % (SIZE // ny) < joint)
    out = np.where(gap, 0.55, out)
    return _grey(out + rng.normal(0.0, 0.012, (SIZE, SIZE)))


KINDS: dict[str, Callable[[np.random.Generator], Picture]] = {
    "plain": plain,
    "plaster": plaster,
    "concrete": concrete,
    "carpet": carpet,
    "linoleum": linoleum,
    "tiles": tiles,
    "ceiling": ceiling,
    "paving": paving,
    "brick": brick,
    "wood": wood,
    "planks": planks,
    "metal": metal,
    "fabric": fabric,
    "foliage": foliage,
    "grass": grass,
    "asphalt": asphalt,
    "bark": bark,
    "facade": facade,
    "townhouse": townhouse,
    "books": books,
    "poster": poster,
    "notes": notes,
    "whiteboard": whiteboard,
    "screen": screen,
    "panel": panel,
    "drawers": drawers,
    "grille": grille,
    "stripes": stripes,
}

ONCE = frozenset(
    {"books", "poster", "notes", "whiteboard", "screen", "panel", "drawers", "stripes"}
)
