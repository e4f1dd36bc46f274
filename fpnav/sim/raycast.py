"""Rays against triangles, by embree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]

FAR_M = np.float32(1e6)
"""Length of a ray that hits nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """``distance_m`` (N,) float32, FAR_M where nothing was hit; ``triangle`` (N,) int32 or -1."""

    distance_m: Float32Array
    triangle: NDArray[np.int32]


class Caster:
    """A fixed set of triangles, (T, 3, 3) float, ready to be hit. Safe to use after a fork."""

    def __init__(self, triangles: NDArray[np.floating]) -> None:
        self.count = len(triangles)
        self._scene = EmbreeScene()
        if self.count:
            self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(triangles, np.float32))

    def cast(self, origins: Float32Array, directions: Float32Array) -> Hits:
        """First hit of every ray; both (N, 3), directions of unit length."""
        if not self.count or not len(origins):
            return Hits(np.full(len(origins), FAR_M), np.full(len(origins), -1, np.int32))
        reach = np.full(len(origins), FAR_M, dtype=np.float32)
        found = self._scene.run(origins, directions, reach, output=True)
        return Hits(found["tfar"], found["primID"])

    def first(self, origins: Float32Array, directions: Float32Array) -> NDArray[np.int32]:
        """Triangle that every ray hits first, (N,), -1 for none; cheaper than ``cast``."""
        if not self.count or not len(origins):
            return np.full(len(origins), -1, dtype=np.int32)
        found = self._scene.run(origins, directions, query="INTERSECT")
        return np.asarray(found, dtype=np.int32)

    def blocked(
        self, origins: Float32Array, directions: Float32Array, reach_m: Float32Array
    ) -> NDArray[np.bool_]:
        """Whether anything stands within ``reach_m`` (N,) along each ray."""
        if not self.count or not len(origins):
            return np.zeros(len(origins), dtype=np.bool_)
        found = self._scene.run(origins, directions, reach_m.copy(), query="OCCLUDED")
        return np.asarray(found) >= 0


def from_point(
    point: Float32Array | tuple[float, float, float], directions: Float32Array
) -> Float32Array:
    """The point repeated as the origin of every direction, (N, 3)."""
    origins = np.empty_like(directions)
    origins[:] = point
    return origins
