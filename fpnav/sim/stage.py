"""A world made ready: compiled, lit, peopled; everything a sensor needs at any pose and time."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sim.grid import View, cast_grid, stride_of, view_of
from fpnav.sim.light import bake, sky_picture
from fpnav.sim.people import Bystanders, Crowd, make_crowd
from fpnav.sim.raycast import FAR_M, Float32Array, Hits, from_point
from fpnav.sim.scene import Scene, compile_scene
from fpnav.sim.sensors.eyes import Rays
from fpnav.sim.shade import shade
from fpnav.sim.world import World
from fpnav.values import Pose2


@dataclass(frozen=True, eq=False)
class Stage:
    """A world compiled and peopled; it is lit when somebody first looks."""

    world: World
    scene: Scene
    crowd: Crowd

    @functools.cached_property
    def light(self) -> Float32Array:
        """Light maps, (L, 3)."""
        visuals = self.world.visuals
        return bake(
            self.scene,
            self.world.lamps,
            self.world.daylight,
            rays=visuals.light_rays,
            ambient=visuals.ambient,
        )

    @functools.cached_property
    def sky(self) -> Float32Array:
        """Radiance of the sky, (rows, columns, 3)."""
        return sky_picture(self.world.daylight)

    def bystanders(self, time_s: float, pose: Pose2) -> Bystanders | None:
        """People in sight of the robot at that time."""
        return self.crowd.around(time_s, (pose.x_m, pose.y_m))

    def look(
        self, rays: Rays, pose: Pose2, height_m: float, people: Bystanders | None
    ) -> NDArray[np.float32]:
        """Radiance (H, W, 3), linear RGB, of the rays' view from a pose."""
        view = view_of(rays.directions, pose, height_m)
        hits = self._cast(rays, view)
        out = np.empty((len(rays.directions), 3), dtype=np.float32)
        self._shade(hits, view, rays.pixel_rad, out)
        if people is not None:
            self._add_people(people, hits, view, out)
        if rays.seen is not None:
            out[~rays.seen] = 0.0
        return out.reshape(*rays.shape, 3)

    def _cast(self, rays: Rays, view: View) -> Hits:
        """Solid hits of an image; pixels that see nothing are not cast."""
        if rays.seen is None:
            return cast_grid(self.scene, view, rays.shape[1], stride_of(rays.pixel_rad))
        distance = np.full(len(rays.seen), FAR_M, dtype=np.float32)
        triangle = np.full(len(rays.seen), -1, dtype=np.int32)
        chosen = view.some(np.flatnonzero(rays.seen))
        hits = self.scene.solid.cast(from_point(view.origin, chosen), chosen)
        distance[rays.seen], triangle[rays.seen] = hits.distance_m, hits.triangle
        return Hits(distance, triangle)

    def _shade(self, hits: Hits, view: View, pixel_rad: float, out: Float32Array) -> None:
        scene = self.scene
        shade(
            hits.distance_m,
            hits.triangle,
            view.origin,
            view.directions,
            view.turn,
            pixel_rad,
            scene.owner,
            scene.patches.real,
            scene.patches.index,
            scene.textures,
            self.light,
            self.sky,
            self.world.visuals.haze_m,
            out,
        )

    def _add_people(self, people: Bystanders, hits: Hits, view: View, out: Float32Array) -> None:
        """Paint people over what stands behind them, lit like the floor where they are."""
        rays, closer = people.nearer(view.origin, view.all(), hits)
        if not len(rays):
            return
        painted = np.empty((len(rays), 3), dtype=np.float32)
        shade(
            closer.distance_m,
            closer.triangle,
            view.origin,
            np.ascontiguousarray(view.directions[rays]),
            view.turn,
            0.005,
            people.owner,
            people.patches.real,
            people.patches.index,
            self.scene.textures,
            self._light_on(people),
            self.sky,
            self.world.visuals.haze_m,
            painted,
        )
        out[rays] = painted

    def _light_on(self, people: Bystanders) -> Float32Array:
        """Light of each patch of the bystanders: that of the floor below, shaped by its slope."""
        down = np.array([[0.0, 0.0, -1.0]], dtype=np.float32)
        patches = people.patches
        middle = patches.real[:, 0:3]
        starts = np.column_stack([middle[:, :2], np.full(len(middle), 0.5, np.float32)])
        below = self.scene.solid.cast(starts, np.repeat(down, len(middle), axis=0))
        row = self.scene.owner[np.maximum(below.triangle, 0)]
        light = self.light[self._nearest_texel(row, starts)]
        normal = np.cross(patches.real[:, 3:6], patches.real[:, 6:9])
        shape = 0.55 + 0.2 * normal[:, 2] + 0.12 * np.sin(np.arctan2(normal[:, 1], normal[:, 0]))
        return np.asarray(light * shape[:, None], dtype=np.float32)

    def _nearest_texel(self, row: NDArray[np.int32], points: Float32Array) -> NDArray[np.int64]:
        real, index = self.scene.patches.real[row], self.scene.patches.index[row]
        offset = points - real[:, 0:3]
        s = np.einsum("ij,ij->i", offset, real[:, 3:6]) - real[:, 18]
        t = np.einsum("ij,ij->i", offset, real[:, 6:9]) - real[:, 19]
        column = np.clip((s * real[:, 21]).astype(int), 0, index[:, 2] - 1)
        line = np.clip((t * real[:, 22]).astype(int), 0, index[:, 3] - 1)
        return np.asarray(index[:, 1] + line * index[:, 2] + column, dtype=np.int64)


def set_stage(world: World) -> Stage:
    """Compile a world."""
    scene = compile_scene(world.faces, world.seed, world.visuals.light_resolution_m)
    return Stage(world, scene, make_crowd(world.walks, scene, world.seed, world.run))
