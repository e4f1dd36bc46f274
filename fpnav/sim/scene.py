"""Faces compiled for rendering: triangles to cast at, patches to shade, textures in mip levels."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.sim.raycast import Caster, Float32Array
from fpnav.sim.solids import Face, Material
from fpnav.sim.textures import SIZE, is_tiled, make_texture

LEVELS = 9
"""Mip levels of a texture, 256 x 256 down to 1 x 1."""

LIGHT_SIDE = 96
"""Most light texels of a face along either side."""

CLOTHES = frozenset({"plain", "fabric"})
"""Textures people wear; every scene has them."""

REAL_FIELDS = 23
"""Columns of ``Patches.real``: origin 0-2, u 3-5, v 6-8, repeats per metre 9-10, texture offset
11-12, tint 13-15, emission 16, texels per metre 17, corner of the light map 18-19, roughness 20,
light texels per metre 21-22.
``Patches.index``: texture, first light texel, light texels along s, along t."""


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """One row for each face, in the order given.

    ``real`` (P, REAL_FIELDS) float32; ``index`` (P, 4) int32; ``size_m`` (P, 2) float32 extent
    along s and t.
    """

    real: Float32Array
    index: NDArray[np.int32]
    size_m: Float32Array

    @property
    def light_texels(self) -> int:
        """Texels of all light maps together."""
        return int((self.index[:, 2].astype(np.int64) * self.index[:, 3]).sum())


@dataclass(frozen=True, eq=False)
class Scene:
    """What rays meet and what they see there.

    ``solid`` stops light, ``glass`` only sound and sometimes a laser; ``owner`` (T,) int32 patch
    of a solid triangle; ``normals`` (T, 3) float32 of solid triangles, ``glass_normals`` alike;
    ``textures`` (n, texels, 3) uint16 linear.
    """

    solid: Caster
    glass: Caster
    owner: NDArray[np.int32]
    normals: Float32Array
    glass_normals: Float32Array
    patches: Patches
    texture_names: tuple[str, ...]
    seed: int

    @functools.cached_property
    def textures(self) -> NDArray[np.uint16]:
        """Texels, (n, texels, 3) uint16 linear; made when somebody first looks."""
        return np.stack([mip_levels(make_texture(name, self.seed)) for name in self.texture_names])


def compile_scene(faces: Sequence[Face], seed: int, light_resolution_m: float) -> Scene:
    """Scene of the faces; textures are made for this seed, light maps laid out but not lit."""
    solid = [face for face in faces if not face.material.glass]
    panes = [face for face in faces if face.material.glass]
    names = tuple(sorted({face.material.texture for face in solid} | CLOTHES))
    triangles, owner = _triangles(solid)
    glass, _ = _triangles(panes)
    return Scene(
        Caster(triangles),
        Caster(glass),
        owner,
        triangle_normals(triangles),
        triangle_normals(glass),
        lay_patches(solid, names, light_resolution_m),
        names,
        seed,
    )


def lay_patches(faces: Sequence[Face], names: Sequence[str], resolution_m: float) -> Patches:
    """Patch rows of the faces, light maps laid out one after another."""
    number = {name: i for i, name in enumerate(names)}
    low, size = _extents(faces)
    texels = np.clip(np.round(size / resolution_m), 1, LIGHT_SIDE).astype(np.int32)
    counts = texels.prod(axis=1)
    index = np.zeros((len(faces), 4), dtype=np.int32)
    index[:, 0] = [number[face.material.texture] for face in faces]
    index[:, 1] = np.cumsum(counts) - counts
    index[:, 2:] = texels
    real = np.zeros((len(faces), REAL_FIELDS), dtype=np.float32)
    real[:, 0:3] = [face.origin for face in faces]
    real[:, 3:6] = [face.u for face in faces]
    real[:, 6:9] = [face.v for face in faces]
    looks = {face.material: i for i, face in enumerate(faces)}
    rows = {material: _material_row(material) for material in looks}
    real[:, 9:18] = [rows[face.material] for face in faces]
    real[:, 20] = [face.material.rough for face in faces]
    real[:, 11:13] = _texture_offsets(faces)
    real[:, 18:20] = low
    real[:, 21:23] = texels / np.maximum(size, 1e-6)
    return Patches(real, index, size.astype(np.float32))


def _extents(faces: Sequence[Face]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower corner and extent of each face in its own (s, t), (P, 2) each."""
    flat = np.concatenate([face.triangles.reshape(-1, 2) for face in faces])
    counts = np.array([3 * len(face.triangles) for face in faces])
    starts = np.cumsum(counts) - counts
    low = np.minimum.reduceat(flat, starts, axis=0)
    return low, np.maximum.reduceat(flat, starts, axis=0) - low


def _material_row(material: Material) -> list[float]:
    """Columns 9-17; the texture's offset is filled in for each face."""
    width, height = material.repeat_m
    tint = linear(np.asarray(material.colour)).tolist()
    fine = SIZE / min(width, height)
    return [1.0 / width, 1.0 / height, 0.0, 0.0, *tint, material.emission, fine]


def _texture_offsets(faces: Sequence[Face]) -> NDArray[np.float64]:
    """Where on the texture a face starts: pictures at their corner, tiles anywhere."""
    corners = np.array([face.origin for face in faces])
    tiled = {name: is_tiled(name) for name in {face.material.texture for face in faces}}
    place = np.round(corners * 1000).astype(np.int64) @ np.array([[73, 191], [157, 61], [31, 113]])
    offsets = (place * 40503 & 0xFFFF) / 0x10000
    offsets[[not tiled[face.material.texture] for face in faces]] = 0.0
    return np.asarray(offsets, dtype=np.float64)


def linear(srgb: NDArray[np.floating]) -> NDArray[np.float64]:
    """Linear light of sRGB values in 0..1 (power 2.2)."""
    return np.asarray(np.clip(srgb, 0.0, 1.0) ** 2.2, dtype=np.float64)


def mip_levels(texture: NDArray[np.float32]) -> NDArray[np.uint16]:
    """All levels of a square texture, finest first, (texels, 3) uint16 in linear light."""
    image = linear(texture).astype(np.float32)
    levels = [image]
    for level in range(1, LEVELS):
        side = SIZE >> level
        smaller = cv2.resize(image, (side, side), interpolation=cv2.INTER_AREA)
        levels.append(np.asarray(smaller, dtype=np.float32))
    flat = np.concatenate([level.reshape(-1, 3) for level in levels])
    return np.asarray(np.round(np.clip(flat, 0.0, 1.0) * 65535.0), dtype=np.uint16)


def _triangles(faces: Sequence[Face]) -> tuple[Float32Array, NDArray[np.int32]]:
    if not faces:
        return np.zeros((0, 3, 3), np.float32), np.zeros(0, np.int32)
    corners = np.concatenate([face.corners() for face in faces]).astype(np.float32)
    counts = [len(face.triangles) for face in faces]
    return corners, np.repeat(np.arange(len(faces), dtype=np.int32), counts)


def triangle_normals(triangles: Float32Array) -> Float32Array:
    """Unit normals (T, 3) of triangles (T, 3, 3)."""
    raw = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.maximum(np.linalg.norm(raw, axis=1, keepdims=True), 1e-12)
    return np.asarray(raw / length, dtype=np.float32)
