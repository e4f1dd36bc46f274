"""Ceiling lamps and daylight as they are on one run."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from fpnav.sim.light import Daylight, Lamp
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Face, Material, box
from fpnav.sim.world import Point, Space

LAMP_POWER = 2.6


def ceiling_lamps(
    spaces: Iterable[Space],
    height_m: float,
    rng: np.random.Generator,
    *,
    off_share: float,
    spread: float,
    warmth_spread: float,
) -> tuple[tuple[Lamp, ...], list[Face]]:
    """Lights of a run and their panels: a common level and warmth, some weak, some off."""
    level = float(np.exp(rng.normal(0.0, spread)))
    warm = float(rng.normal(0.0, warmth_spread))
    lamps: list[Lamp] = []
    faces: list[Face] = []
    z = height_m - 0.06
    for x, y in (place for space in spaces for place in lamp_places(space)):
        on = rng.random() >= off_share
        power = LAMP_POWER * level * float(rng.uniform(0.85, 1.15))
        if on:
            colour = (power * (1 + 0.5 * warm), power, power * (0.92 - warm))
            lamps.append(Lamp(x, y, z - 0.05, colour))
        glow = Material(colour=(1.0, 1.0, 0.97), emission=2.0 * level if on else 0.0)
        faces += box((x - 0.6, y - 0.12, z), (x + 0.6, y + 0.12, z + 0.05), glow, bottom=True)
    return tuple(lamps), faces


def lamp_places(space: Space) -> list[Point]:
    """A grid of lamps about three metres apart."""
    nx = max(1, round((space.x1 - space.x0) / 2.9))
    ny = max(1, round((space.y1 - space.y0) / 3.2))
    return [
        (
            space.x0 + (space.x1 - space.x0) * (i + 0.5) / nx,
            space.y0 + (space.y1 - space.y0) * (j + 0.5) / ny,
        )
        for i in range(nx)
        for j in range(ny)
    ]


def weather(seed: int, run: int) -> Daylight:
    """Any daylight: sun or cloud, from anywhere."""
    rng = generator(seed, run, "daylight")
    return Daylight(
        sun_azimuth_rad=float(rng.uniform(-math.pi, math.pi)),
        sun_elevation_rad=math.radians(float(rng.uniform(15, 55))),
        sun=float(rng.uniform(0.0, 5.0)),
        sky=float(rng.uniform(0.8, 2.4)),
        clouds=float(rng.uniform(0.0, 1.0)),
        seed=seed * 1000 + run,
    )


def clock_sun(seed: int, run: int) -> Daylight:
    """Fair weather at five in the afternoon on odd runs, at ten in the morning on even ones."""
    rng = generator(seed, run, "daylight")
    afternoon = run % 2 == 1
    bearing = math.radians(-165.0 if afternoon else -40.0) + float(rng.uniform(-0.15, 0.15))
    height = math.radians(24.0 if afternoon else 33.0) + float(rng.uniform(-0.06, 0.06))
    return Daylight(
        sun_azimuth_rad=bearing,
        sun_elevation_rad=height,
        sun=float(rng.uniform(2.0, 3.2)),
        sky=float(rng.uniform(1.3, 1.8)),
        clouds=float(rng.uniform(0.0, 0.6)),
        warmth=0.8 if afternoon else 0.2,
        seed=seed * 1000 + run,
    )
