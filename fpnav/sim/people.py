"""People: where they are at a time, and the bodies the sensors see."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sim.furniture import hsv
from fpnav.sim.jit import compiled
from fpnav.sim.raycast import Caster, Float32Array, Hits, from_point
from fpnav.sim.scene import Patches, Scene, lay_patches, triangle_normals
from fpnav.sim.seeds import generator
from fpnav.sim.solids import Face, Material, moved, prism
from fpnav.sim.world import Point, Walk
from fpnav.values import Pose2

KEEP_OFF_M = 0.62
"""People give way: nobody's middle comes nearer to the robot's."""

SIGHT_M = 25.0


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Somebody standing at the origin, facing along x: triangles (T, 3, 3), owners, patches."""

    triangles: Float32Array
    owner: NDArray[np.int32]
    patches: Patches


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """Somebody: a way, and a body."""

    walk: Walk
    body: Body
    marks: tuple[float, ...]

    def position(self, time_s: float) -> Point:
        """Where the walk has come to: to its end and back, over and over."""
        total = self.marks[-1]
        if total <= 0.0:
            return self.walk.points[0]
        at = (self.walk.start_m + self.walk.speed_mps * time_s) % (2.0 * total)
        at = at if at <= total else 2.0 * total - at
        x = np.interp(at, self.marks, [p[0] for p in self.walk.points])
        y = np.interp(at, self.marks, [p[1] for p in self.walk.points])
        return float(x), float(y)


def make_person(walk: Walk, scene: Scene, rng: np.random.Generator) -> Person:
    """A person with clothes of their own."""
    points = np.array(walk.points)
    steps = np.hypot(*np.diff(points, axis=0).T) if len(points) > 1 else np.zeros(0)
    marks = np.concatenate([[0.0], np.cumsum(steps)])
    faces = _body(rng)
    counts = [len(face.triangles) for face in faces]
    body = Body(
        np.concatenate([face.corners() for face in faces]).astype(np.float32),
        np.repeat(np.arange(len(faces), dtype=np.int32), counts),
        lay_patches(faces, scene.texture_names, 10.0),
    )
    return Person(walk, body, tuple(float(mark) for mark in marks))


def _body(rng: np.random.Generator) -> list[Face]:
    tall = float(rng.uniform(1.58, 1.9))
    shirt = _cloth(rng, float(rng.uniform(0.1, 0.9)), float(rng.uniform(0.2, 0.9)))
    trousers = _cloth(rng, float(rng.uniform(0.0, 0.5)), float(rng.uniform(0.1, 0.5)))
    skin = Material(colour=hsv(float(rng.uniform(15, 30)), 0.45, float(rng.uniform(0.35, 0.9))))
    hair = Material(colour=hsv(float(rng.uniform(15, 40)), 0.6, float(rng.uniform(0.08, 0.5))))
    hip, shoulder = 0.5 * tall, 0.84 * tall
    faces = moved(prism((0.0, 0.1), 0.09, 0.0, hip, trousers, sides=6, cap=False), (0.08, 0, 0))
    faces += moved(prism((0.0, -0.1), 0.09, 0.0, hip, trousers, sides=6, cap=False), (-0.08, 0, 0))
    faces += prism((0.0, 0.0), (0.16, 0.24), hip, shoulder, shirt, sides=8, taper=1.1)
    faces += prism((0.0, 0.0), 0.055, shoulder, 0.88 * tall, skin, sides=6, cap=False)
    faces += prism((0.0, 0.0), 0.09, 0.87 * tall, 0.94 * tall, skin, sides=8)
    faces += prism((0.0, 0.0), 0.1, 0.94 * tall, tall, hair, sides=8, taper=0.7)
    return faces


def _cloth(rng: np.random.Generator, saturation: float, value: float) -> Material:
    return Material("fabric", hsv(float(rng.uniform(0, 360)), saturation, value), (0.4, 0.4))


@dataclass(frozen=True, slots=True, eq=False)
class Crowd:
    """The people of a run."""

    people: tuple[Person, ...]

    def around(self, time_s: float, robot: Point) -> Bystanders | None:
        """Those in sight of the robot, as they stand at that time; None where nobody is."""
        standing = []
        for person in self.people:
            x, y = _give_way(person.position(time_s), robot)
            if math.hypot(x - robot[0], y - robot[1]) <= SIGHT_M:
                ahead = person.position(time_s + 0.3)
                facing = math.atan2(ahead[1] - y, ahead[0] - x)
                standing.append((person.body, Pose2(x, y, facing)))
        return stand(standing) if standing else None


def make_crowd(walks: tuple[Walk, ...], scene: Scene, seed: int, run: int) -> Crowd:
    """People of a run, dressed by chance."""
    return Crowd(
        tuple(
            make_person(walk, scene, generator(seed, run, "dress", i))
            for i, walk in enumerate(walks)
        )
    )


def _give_way(place: Point, robot: Point) -> Point:
    dx, dy = place[0] - robot[0], place[1] - robot[1]
    away = math.hypot(dx, dy)
    if away >= KEEP_OFF_M:
        return place
    if away < 1e-6:
        return robot[0] + KEEP_OFF_M, robot[1]
    return robot[0] + dx * KEEP_OFF_M / away, robot[1] + dy * KEEP_OFF_M / away


@dataclass(frozen=True, slots=True, eq=False)
class Bystanders:
    """People in sight at one instant, ready to be hit and shaded."""

    places: tuple[Point, ...]
    caster: Caster
    owner: NDArray[np.int32]
    normals: Float32Array
    patches: Patches

    def in_view(self, origin: Float32Array, directions: Float32Array) -> NDArray[np.int64]:
        """Indices of the rays that pass within half a metre of somebody's axis."""
        offsets = np.array(self.places, dtype=np.float32) - origin[:2]
        found = np.empty(len(directions), dtype=np.int64)
        return found[: _near(offsets, directions, found)]

    def nearer(
        self, origins: Float32Array, directions: Float32Array, hits: Hits
    ) -> tuple[NDArray[np.int64], Hits]:
        """Rays that meet a person before anything else: their indices, and those hits.

        ``origins`` : (N, 3), or (3,) where all rays start at one point.
        """
        start = origins if origins.ndim == 1 else origins[0]
        rays = self.in_view(start, directions)
        chosen = np.ascontiguousarray(directions[rays])
        starts = origins[rays] if origins.ndim == 2 else from_point(start, chosen)
        found = self.caster.cast(starts, chosen)
        closer = (found.triangle >= 0) & (found.distance_m < hits.distance_m[rays])
        return rays[closer], Hits(found.distance_m[closer], found.triangle[closer])


@compiled
def _near(offsets: Float32Array, directions: Float32Array, found: NDArray[np.int64]) -> int:
    """Indices of rays passing within half a metre of an offset (n, 2), written to ``found``."""
    count = 0
    for i in range(len(directions)):
        x, y = directions[i, 0], directions[i, 1]
        level = np.float32(0.25) * (x * x + y * y)
        for k in range(len(offsets)):
            side = x * offsets[k, 1] - y * offsets[k, 0]
            if side * side < level and x * offsets[k, 0] + y * offsets[k, 1] > 0.0:
                found[count] = i
                count += 1
                break
    return count


def stand(standing: Sequence[tuple[Body, Pose2]]) -> Bystanders:
    """Bodies put at their places."""
    triangles, owner, rows, first = [], [], [], 0
    for body, pose in standing:
        c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]], dtype=np.float32)
        shift = np.array([pose.x_m, pose.y_m, 0.0], dtype=np.float32)
        row = body.patches.real.copy()
        row[:, 0:3] = row[:, 0:3] @ turn + shift
        row[:, 3:6], row[:, 6:9] = row[:, 3:6] @ turn, row[:, 6:9] @ turn
        triangles.append(body.triangles @ turn + shift)
        owner.append(body.owner + np.int32(first))
        rows.append(row)
        first += len(row)
    corners = np.concatenate(triangles)
    index = np.concatenate([body.patches.index for body, _ in standing])
    index[:, 1:] = (np.arange(len(index), dtype=np.int32)[:, None] * [1, 0, 0]) + [0, 1, 1]
    size = np.concatenate([body.patches.size_m for body, _ in standing])
    return Bystanders(
        tuple((pose.x_m, pose.y_m) for _, pose in standing),
        Caster(corners),
        np.concatenate(owner),
        triangle_normals(corners),
        Patches(np.concatenate(rows), index, size),
    )
