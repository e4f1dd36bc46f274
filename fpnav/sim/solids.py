"""What the world is made of: planar faces with a material, and the solids built from them.

Units are metres, z is up, the floor is z = 0. A face is seen and lit from the side its normal
``u x v`` points to; solids are closed, so nobody looks at a back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import ArrayLike

    from fpnav.values import FloatArray

Colour = tuple[float, float, float]
"""sRGB in 0..1."""


@dataclass(frozen=True, slots=True)
class Material:
    """Look and touch of a surface.

    ``texture`` : kind, or kind:variant, of ``textures.KINDS``; ``repeat_m`` : width and height of
    one repetition; ``colour`` : tint the texture is multiplied by; ``emission`` : radiance of its
    own; ``rough`` : 0 mirrors sonar away, 1 scatters it; ``glass`` : light passes, sound does not.
    """

    texture: str = "plain"
    colour: Colour = (1.0, 1.0, 1.0)
    repeat_m: tuple[float, float] = (1.0, 1.0)
    emission: float = 0.0
    rough: float = 0.3
    glass: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """Polygon in a plane: corners ``origin + s u + t v`` of triangles (k, 3, 2) of (s, t)."""

    origin: FloatArray
    u: FloatArray
    v: FloatArray
    triangles: FloatArray
    material: Material

    def corners(self) -> FloatArray:
        """Triangle corners in space, (k, 3, 3)."""
        s, t = self.triangles[..., :1], self.triangles[..., 1:]
        return np.asarray(self.origin + s * self.u + t * self.v)


def rectangles(boxes: Iterable[Sequence[float]]) -> FloatArray:
    """Two triangles for each (s0, t0, s1, t1), (k, 3, 2)."""
    triangles = [
        [[[s0, t0], [s1, t0], [s1, t1]], [[s0, t0], [s1, t1], [s0, t1]]] for s0, t0, s1, t1 in boxes
    ]
    return np.array(triangles, dtype=np.float64).reshape(-1, 3, 2)


def sheet(origin: ArrayLike, u: ArrayLike, v: ArrayLike, material: Material) -> Face:
    """Parallelogram-free rectangle spanned by the perpendicular vectors ``u`` and ``v``."""
    u_m, v_m = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
    width, height = math.sqrt(u_m @ u_m), math.sqrt(v_m @ v_m)
    return Face(
        np.asarray(origin, dtype=np.float64),
        u_m / width,
        v_m / height,
        rectangles([(0.0, 0.0, width, height)]),
        material,
    )


def picture(origin: ArrayLike, u: ArrayLike, v: ArrayLike, material: Material) -> Face:
    """Rectangle that shows its texture exactly once (poster, screen, door leaf)."""
    size = (float(np.linalg.norm(np.asarray(u))), float(np.linalg.norm(np.asarray(v))))
    return sheet(origin, u, v, replace(material, repeat_m=size))


def triangle(corners: ArrayLike, material: Material) -> Face:
    """One triangle, counter-clockwise from outside."""
    return triangles(np.asarray(corners, dtype=np.float64)[None], material)[0]


def box(
    low: Sequence[float],
    high: Sequence[float],
    material: Material,
    *,
    top: Material | None = None,
    front: Material | None = None,
    turn_rad: float = 0.0,
    bottom: bool = False,
) -> list[Face]:
    """Upright box; ``front`` covers its -y side once, ``turn_rad`` turns it about its centre."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    w, d, h = x1 - x0, y1 - y0, z1 - z0
    x, y, z = np.diag([w, d, h])
    o = np.array([x0, y0, z0])
    faces = [
        picture(o, x, z, front) if front else sheet(o, x, z, material),
        sheet(o + x, y, z, material),
        sheet(o + x + y, -x, z, material),
        sheet(o + y, -y, z, material),
        sheet(o + z, x, y, top or material),
    ]
    if bottom:
        faces.append(sheet(o + y, x, -y, material))
    return turned(faces, ((x0 + x1) / 2, (y0 + y1) / 2), turn_rad) if turn_rad else faces


def prism(
    centre: Sequence[float],
    radius_m: float | tuple[float, float],
    z0: float,
    z1: float,
    material: Material,
    *,
    sides: int = 12,
    taper: float = 1.0,
    cap: bool = True,
) -> list[Face]:
    """Upright pillar with ``sides`` flat sides, top radius ``taper`` times the lower one."""
    rx, ry = radius_m if isinstance(radius_m, tuple) else (radius_m, radius_m)
    angles = 2.0 * math.pi * np.arange(sides + 1) / sides
    ring = np.column_stack([rx * np.cos(angles), ry * np.sin(angles)])
    low = np.column_stack([ring + centre[:2], np.full(sides + 1, z0)])
    high = np.column_stack([ring * taper + centre[:2], np.full(sides + 1, z1)])
    faces = quads(np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1), material)
    if cap and taper > 0.0:
        middle = np.array([centre[0], centre[1], z1])
        middles = np.repeat(middle[None], sides, axis=0)
        faces += triangles(np.stack([middles, high[:-1], high[1:]], axis=1), material)
    return faces


def quad(corners: ArrayLike, material: Material) -> Face:
    """Planar quadrilateral, counter-clockwise from outside."""
    return quads(np.asarray(corners, dtype=np.float64)[None], material)[0]


def quads(corners: FloatArray, material: Material) -> list[Face]:
    """A face for each of many planar quadrilaterals (n, 4, 3)."""
    halves = triangles(corners[:, :3], material)
    axes = np.array([(face.u, face.v) for face in halves])
    flat = np.einsum("nci,nai->nca", corners - corners[:, :1], axes)[:, [[0, 1, 2], [0, 2, 3]]]
    return [
        Face(face.origin, face.u, face.v, both, material)
        for face, both in zip(halves, flat, strict=True)
    ]


def blob(
    centre: Sequence[float],
    radii_m: Sequence[float],
    material: Material,
    rng: np.random.Generator,
    *,
    rough: float = 0.25,
    subdivisions: int = 2,
) -> list[Face]:
    """Crumpled ellipsoid: a tree crown, a bush, a potted plant, a head."""
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=subdivisions)
    swell = 1.0 + rough * rng.uniform(-1.0, 1.0, (len(ball.vertices), 1))
    points = np.asarray(centre) + np.array(ball.vertices) * swell * np.asarray(radii_m)
    return triangles(points[np.array(ball.faces)], material)


def triangles(corners: FloatArray, material: Material) -> list[Face]:
    """A face for each of many triangles (n, 3, 3), counter-clockwise from outside."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    u = _unit(b - a)
    v = np.cross(_unit(np.cross(u, c - a)), u)
    flat = np.zeros((len(a), 1, 3, 2))
    flat[:, 0, 1, 0] = np.einsum("ij,ij->i", b - a, u)
    flat[:, 0, 2, 0] = np.einsum("ij,ij->i", c - a, u)
    flat[:, 0, 2, 1] = np.einsum("ij,ij->i", c - a, v)
    return [Face(*parts, material) for parts in zip(a, u, v, flat, strict=True)]


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def turned(faces: Iterable[Face], about: tuple[float, float], angle_rad: float) -> list[Face]:
    """The faces turned about the vertical axis through ``about``."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    pivot = np.array([*about, 0.0])
    return placed(faces, rotation, pivot - rotation @ pivot)


def moved(faces: Iterable[Face], by: Sequence[float]) -> list[Face]:
    """The faces moved by a vector."""
    return placed(faces, np.eye(3), np.asarray(by, dtype=np.float64))


def placed(faces: Iterable[Face], rotation: FloatArray, shift: FloatArray) -> list[Face]:
    """The faces turned about the origin by a matrix (3, 3), then moved."""
    kept = list(faces)
    if not kept:
        return []
    frames = np.array([(face.origin, face.u, face.v) for face in kept]) @ rotation.T
    frames[:, 0] += shift
    return [
        Face(origin, u, v, face.triangles, face.material)
        for (origin, u, v), face in zip(frames, kept, strict=True)
    ]
