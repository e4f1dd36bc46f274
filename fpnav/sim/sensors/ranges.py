"""Laser scanner and sonar ring: rays, echoes, and what goes wrong with them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Params
from fpnav.sim.people import Bystanders
from fpnav.sim.raycast import FAR_M, Float32Array, from_point
from fpnav.sim.scene import Scene
from fpnav.values import LaserScan, Pose2, SonarRing


class Laser(Params, frozen=True):
    """A planar scanner. ``glass_deg``: steeper than this, a pane lets the beam through."""

    beams: int = 720
    field_of_view_deg: float = 360.0
    height_m: float = 0.35
    range_min_m: float = 0.05
    range_max_m: float = 30.0
    noise_m: float = 0.012
    noise_share: float = 0.003
    dropouts: float = 0.004
    mixed: float = 0.3
    glass_deg: float = 12.0
    step_m: float = 0.005


class Sonar(Params, frozen=True):
    """A ring of transducers with conical beams."""

    count: int = 24
    radius_m: float = 0.21
    height_m: float = 0.38
    cone_deg: float = 30.0
    range_min_m: float = 0.15
    range_max_m: float = 6.0
    noise_m: float = 0.015
    step_m: float = 0.01
    misses: float = 0.8
    cross_talk: float = 0.01
    rays_across: int = 13
    rays_up: int = 3
    rise_deg: float = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Echoes:
    """``distance_m`` (N,) along each ray, ``slant_rad`` (N,) incidence, ``rough`` (N,) surface."""

    distance_m: NDArray[np.float64]
    slant_rad: NDArray[np.float64]
    rough: NDArray[np.float64]


def echoes(
    scene: Scene, people: Bystanders | None, origins: Float32Array, directions: Float32Array
) -> tuple[Echoes, Echoes]:
    """What solid things and people send back, and what panes of glass would."""
    hits = scene.solid.cast(origins, directions)
    found = hits.triangle >= 0
    normals = scene.normals[hits.triangle]
    cosine = np.abs(np.einsum("ij,ij->i", normals, directions))
    rough = scene.patches.real[scene.owner[hits.triangle], 20]
    distance = np.where(found, hits.distance_m, FAR_M).astype(np.float64)
    if people is not None:
        rays, closer = people.nearer(origins, directions, hits)
        distance[rays], rough[rays] = closer.distance_m, 0.9
        cosine[rays] = np.abs(
            np.einsum("ij,ij->i", people.normals[closer.triangle], directions[rays])
        )
    solid = Echoes(distance, np.arccos(np.clip(cosine, 0.0, 1.0)), rough.astype(np.float64))
    return solid, _panes(scene, origins, directions)


def _panes(scene: Scene, origins: Float32Array, directions: Float32Array) -> Echoes:
    hits = scene.glass.cast(origins, directions)
    slant = np.full(len(origins), math.pi / 2)
    found = np.flatnonzero(hits.triangle >= 0)
    normals = scene.glass_normals[hits.triangle[found]]
    cosine = np.abs(np.einsum("ij,ij->i", normals, directions[found]))
    slant[found] = np.arccos(np.clip(cosine, 0.0, 1.0))
    return Echoes(hits.distance_m.astype(np.float64), slant, np.zeros(len(origins)))


def bearings(laser: Laser) -> tuple[float, float]:
    """First bearing and increment, radians; a full circle begins at the rear, ends before it."""
    fov = math.radians(laser.field_of_view_deg)
    full = laser.field_of_view_deg >= 360.0
    increment = fov / (laser.beams if full else laser.beams - 1)
    return -fov / 2, increment


def level_rays(angles: NDArray[np.float64]) -> Float32Array:
    """Horizontal unit vectors (N, 3)."""
    return np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)]).astype(
        np.float32
    )


def scan(
    scene: Scene,
    people: Bystanders | None,
    pose: Pose2,
    laser: Laser,
    rng: np.random.Generator,
) -> LaserScan:
    """One scan taken at a pose."""
    first, increment = bearings(laser)
    angles = pose.heading_rad + first + increment * np.arange(laser.beams, dtype=np.float64)
    rays = level_rays(angles)
    origins = from_point((pose.x_m, pose.y_m, laser.height_m), rays)
    solid, glass = echoes(scene, people, origins, rays)
    straight = glass.slant_rad < math.radians(laser.glass_deg)
    true = np.where(straight, np.minimum(glass.distance_m, solid.distance_m), solid.distance_m)
    measured = _measured(true, laser, rng)
    return LaserScan(measured, first, increment, laser.range_min_m, laser.range_max_m)


def _measured(
    true: NDArray[np.float64], laser: Laser, rng: np.random.Generator
) -> NDArray[np.float32]:
    """True distances with mixed pixels, noise, steps and dropouts; REP 117."""
    noise = rng.standard_normal(len(true))
    mixing, share, lost = rng.random((3, len(true)))
    behind = np.roll(true, -1)
    edge = (np.abs(behind - true) > 0.3) & (np.maximum(behind, true) < laser.range_max_m)
    mixed = np.where(edge & (mixing < laser.mixed), true + share * (behind - true), true)
    out = mixed + noise * (laser.noise_m + laser.noise_share * np.minimum(mixed, 100.0))
    if laser.step_m > 0.0:
        out = np.round(out / laser.step_m) * laser.step_m
    out[(true > laser.range_max_m) | (lost < laser.dropouts)] = math.inf
    out[out < laser.range_min_m] = -math.inf
    return np.asarray(out, dtype=np.float32)


def mounts(sonar: Sonar) -> NDArray[np.float64]:
    """Place and heading of each transducer on the robot, (N, 3), the first ahead."""
    heading = 2 * math.pi * np.arange(sonar.count) / sonar.count
    heading = (heading + math.pi) % (2 * math.pi) - math.pi
    return np.column_stack(
        [sonar.radius_m * np.cos(heading), sonar.radius_m * np.sin(heading), heading]
    )


def cone(sonar: Sonar) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Bearings and elevations of the rays of one beam, relative to its axis."""
    half = math.radians(sonar.cone_deg / 2)
    rise = math.radians(sonar.rise_deg)
    across, up = np.meshgrid(
        np.linspace(-half, half, sonar.rays_across), np.linspace(-rise, rise, sonar.rays_up)
    )
    return across.ravel(), up.ravel()


def ring(
    scene: Scene,
    people: Bystanders | None,
    pose: Pose2,
    sonar: Sonar,
    rng: np.random.Generator,
    only: tuple[int, ...] = (),
) -> SonarRing:
    """One reading of the ring, or of some of its transducers."""
    places = mounts(sonar)[list(only)] if only else mounts(sonar)
    across, up = cone(sonar)
    c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    x = pose.x_m + c * places[:, 0] - s * places[:, 1]
    y = pose.y_m + s * places[:, 0] + c * places[:, 1]
    angle = (pose.heading_rad + places[:, 2])[:, None] + across
    flat = np.cos(up)
    rays = np.stack(
        [flat * np.cos(angle), flat * np.sin(angle), np.broadcast_to(np.sin(up), angle.shape)], -1
    )
    starts = np.stack([x, y, np.full_like(x, sonar.height_m)], -1)[:, None].repeat(len(up), 1)
    solid, glass = echoes(
        scene,
        people,
        starts.reshape(-1, 3).astype(np.float32),
        rays.reshape(-1, 3).astype(np.float32),
    )
    shape = (len(places), len(up))
    ranges = np.minimum(
        _heard(solid, sonar, rng, shape).min(axis=1), _heard(glass, sonar, rng, shape).min(axis=1)
    )
    return SonarRing(
        _reported(ranges, sonar, rng),
        places,
        math.radians(sonar.cone_deg),
        sonar.range_min_m,
        sonar.range_max_m,
    )


def _heard(
    echo: Echoes, sonar: Sonar, rng: np.random.Generator, shape: tuple[int, int]
) -> NDArray[np.float64]:
    """Distances (transducers, rays), infinite where a smooth surface throws the sound away."""
    limit = math.radians(20.0) + echo.rough * math.radians(60.0)
    limit = limit + math.radians(6.0) * rng.standard_normal(shape).reshape(-1)
    lost = (echo.slant_rad > limit) & (rng.random(shape).reshape(-1) < sonar.misses)
    lost |= echo.distance_m > sonar.range_max_m
    return np.where(lost, math.inf, echo.distance_m).reshape(shape)


def _reported(
    ranges: NDArray[np.float64], sonar: Sonar, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Readings with noise, cross-talk from a neighbour, and steps; REP 117."""
    out = ranges + sonar.noise_m * rng.standard_normal(len(ranges))
    struck = rng.random(len(out)) < sonar.cross_talk
    heard = np.minimum(np.roll(out, 1), np.roll(out, -1)) * rng.uniform(0.6, 1.0, len(out))
    out = np.where(struck, np.minimum(out, heard), out)
    finite = np.isfinite(out)
    out[finite] = np.round(out[finite] / sonar.step_m) * sonar.step_m
    out[out > sonar.range_max_m] = math.inf
    out[out < sonar.range_min_m] = -math.inf
    return np.asarray(out, dtype=np.float32)
