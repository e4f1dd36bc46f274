"""Light of a run: sky and sun, lamps, one bounce; baked into the light maps of a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sim.raycast import Caster, Float32Array
from fpnav.sim.scene import Patches, Scene
from fpnav.sim.seeds import generator

SKY_ROWS, SKY_COLUMNS = 128, 512


@dataclass(frozen=True, slots=True)
class Lamp:
    """Luminaire shining down: place, colour (linear) times strength."""

    x_m: float
    y_m: float
    z_m: float
    power: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Daylight:
    """Sun and sky of a run: elevation <= 0 is a night without sky light."""

    sun_azimuth_rad: float
    sun_elevation_rad: float
    sun: float
    sky: float
    clouds: float
    warmth: float = 0.0
    seed: int = 0

    def sun_direction(self) -> NDArray[np.float64]:
        """Unit vector towards the sun."""
        c = math.cos(self.sun_elevation_rad)
        return np.array(
            [
                c * math.cos(self.sun_azimuth_rad),
                c * math.sin(self.sun_azimuth_rad),
                math.sin(self.sun_elevation_rad),
            ]
        )

    def sun_radiance(self) -> NDArray[np.float64]:
        """Colour of the direct sun, redder near the horizon."""
        return self.sun * np.array([1.0, 0.94 - 0.12 * self.warmth, 0.84 - 0.34 * self.warmth])


def sky_picture(daylight: Daylight) -> Float32Array:
    """Radiance of the sky, (SKY_ROWS, SKY_COLUMNS, 3), row 0 at the zenith."""
    up = 1.0 - (np.arange(SKY_ROWS) + 0.5) / SKY_ROWS
    zenith, rim = np.array([0.30, 0.48, 0.85]), np.array([0.80, 0.86, 0.92])
    rim = rim * (1.0 + daylight.warmth * np.array([0.15, -0.05, -0.25]))
    blue = zenith + (rim - zenith) * ((1.0 - up) ** 3)[:, None]
    cover = _clouds(daylight)
    grey = np.array([0.92, 0.93, 0.95])
    sky = blue[:, None] * (1 - cover[..., None]) + grey * cover[..., None]
    return np.asarray(daylight.sky * sky, dtype=np.float32)


def _clouds(daylight: Daylight) -> NDArray[np.float32]:
    rng = generator(daylight.seed, "clouds")
    total = np.zeros((SKY_ROWS, SKY_COLUMNS), dtype=np.float32)
    for octave in range(4):
        grid = rng.random((4 << octave, 8 << octave), dtype=np.float32)
        wide = np.hstack([grid, grid[:, :1]])
        layer = cv2.resize(wide, (SKY_COLUMNS, SKY_ROWS), interpolation=cv2.INTER_LINEAR)
        total += layer * 0.5**octave / 1.875
    return np.asarray(np.clip((total - 0.75 + 0.5 * daylight.clouds) * 5.0, 0.0, 1.0))


def bake(
    scene: Scene, lamps: tuple[Lamp, ...], daylight: Daylight, *, rays: int, ambient: float
) -> Float32Array:
    """Light maps (L, 3) float32: lamps and sun with shadows, then one bounce and the sky.

    ``rays`` : directions of the gather; ``ambient`` : what further bounces would add, as a share
    of the mean direct light.
    """
    points, normals, patch = texels(scene.patches)
    direct = _from_lamps(scene.solid, points, normals, lamps)
    direct += _from_sun(scene.solid, points, normals, daylight)
    sky = sky_picture(daylight)
    return direct + _gathered(scene, points, normals, patch, direct, sky, rays, ambient)


def texels(patches: Patches) -> tuple[Float32Array, Float32Array, NDArray[np.int32]]:
    """Place (L, 3), normal (L, 3) and patch (L,) of every light texel; places stand 1 cm off."""
    counts = patches.index[:, 2].astype(np.int64) * patches.index[:, 3]
    patch = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    columns = patches.index[patch, 2]
    row = patches.real[patch]
    s = row[:, 18] + (within % columns + 0.5) / row[:, 21]
    t = row[:, 19] + (within // columns + 0.5) / row[:, 22]
    normals = np.cross(row[:, 3:6], row[:, 6:9])
    points = row[:, 0:3] + s[:, None] * row[:, 3:6] + t[:, None] * row[:, 6:9] + 0.01 * normals
    return points.astype(np.float32), normals.astype(np.float32), patch


def _from_lamps(
    caster: Caster, points: Float32Array, normals: Float32Array, lamps: tuple[Lamp, ...]
) -> Float32Array:
    total = np.zeros_like(points)
    for lamp in lamps:
        towards = np.array([lamp.x_m, lamp.y_m, lamp.z_m], dtype=np.float32) - points
        square = np.einsum("ij,ij->i", towards, towards)
        near = np.flatnonzero(square < 64.0)
        length = np.sqrt(square[near])
        unit = towards[near] / length[:, None]
        facing = np.einsum("ij,ij->i", unit, normals[near])
        down = np.clip(unit[:, 2], 0.0, 1.0)
        strength = np.clip(facing, 0.0, 1.0) * (0.15 + down) / (0.4 + square[near])
        seen = np.flatnonzero(strength > 0.003)
        free = ~caster.blocked(points[near[seen]], unit[seen], length[seen] - 0.03)
        total[near[seen]] += (strength[seen] * free)[:, None] * np.array(
            lamp.power, dtype=np.float32
        )
    return total


def _from_sun(
    caster: Caster, points: Float32Array, normals: Float32Array, daylight: Daylight
) -> Float32Array:
    total = np.zeros_like(points)
    if daylight.sun <= 0.0 or daylight.sun_elevation_rad <= 0.0:
        return total
    direction = daylight.sun_direction().astype(np.float32)
    facing = np.flatnonzero(normals @ direction > 0.0)
    rays = np.repeat(direction[None], len(facing), axis=0)
    free = ~caster.blocked(points[facing], rays, np.full(len(facing), 1e4, np.float32))
    strength = (normals[facing] @ direction) * free
    total[facing] = strength[:, None] * daylight.sun_radiance().astype(np.float32)
    return total


def _gathered(
    scene: Scene,
    points: Float32Array,
    normals: Float32Array,
    patch: NDArray[np.int32],
    direct: Float32Array,
    sky: Float32Array,
    rays: int,
    ambient: float,
) -> Float32Array:
    """Sky seen and light thrown back by what is near, cosine weighted."""
    counts = scene.patches.index[:, 2].astype(np.int64) * scene.patches.index[:, 3]
    albedo = scene.patches.real[:, 13:16] * _mean_texture(scene)
    sums = np.add.reduceat(direct, scene.patches.index[:, 1], axis=0)
    thrown = albedo * (sums / counts[:, None] + ambient * direct.mean(axis=0))
    thrown += albedo * scene.patches.real[:, 16:17]
    total = np.zeros_like(points)
    across, along = _basis(normals)
    for x, y, z in hemisphere(rays):
        world = np.ascontiguousarray(x * across + y * along + z * normals)
        hits = scene.solid.cast(points, world)
        met = hits.triangle >= 0
        total[met] += thrown[scene.owner[hits.triangle[met]]]
        total[~met] += _sky_light(sky, world[~met])
    return np.asarray(total / rays, dtype=np.float32)


def _mean_texture(scene: Scene) -> Float32Array:
    return np.asarray(scene.textures[scene.patches.index[:, 0], -1] / 65535.0, dtype=np.float32)


def _sky_light(sky: Float32Array, directions: Float32Array) -> Float32Array:
    row = (1.0 - np.arcsin(np.clip(directions[:, 2], 0.0, 1.0)) / (math.pi / 2)) * SKY_ROWS
    mean = sky.mean(axis=1)
    light = mean[np.minimum(row.astype(int), SKY_ROWS - 1)]
    return np.asarray(np.where(directions[:, 2:] > 0.0, light, 0.25 * light), dtype=np.float32)


def hemisphere(count: int) -> NDArray[np.float32]:
    """Cosine-weighted directions about +z, (count, 3): a spiral, the same for everybody."""
    i = np.arange(count) + 0.5
    radius, angle = np.sqrt(i / count), i * math.pi * (3.0 - math.sqrt(5.0))
    spiral = [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius**2)]
    return np.column_stack(spiral).astype(np.float32)


def _basis(normals: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Two unit vectors across each normal, at right angles to each other."""
    z, x = np.eye(3, dtype=np.float32)[[2, 0]]
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, z, x)
    across = np.cross(helper, normals)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(normals, across)
