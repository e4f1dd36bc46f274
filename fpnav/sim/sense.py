"""One data set: every sensor of the rig, each at its own moment, with its own chance."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import compose
from fpnav.sim.people import Bystanders
from fpnav.sim.rig import Rig, pan_camera
from fpnav.sim.seeds import generator
from fpnav.sim.sensors import eyes, film, ranges
from fpnav.sim.stage import Stage
from fpnav.values import Pose2

CAMERAS = frozenset({"panorama", "omni", "camera", "camera_offset", "pan"})

PoseAt = Callable[[float], tuple[Pose2, float]]
"""Time (s) -> true pose and rate of turn (rad/s)."""


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """What a role gave at a time: pixels (H, W, 3), LaserScan, SonarRing or pan angle (rad)."""

    role: str
    time_s: float
    value: Any


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """Data set number ``index`` of a run, about to be taken at ``time_s``.

    ``progress`` is the share of the run that is done; the cameras sleep unless ``looking``; of a
    panned camera only the one ``view`` is taken, where a number is given.
    """

    stage: Stage
    rig: Rig
    pose_at: PoseAt
    index: int
    time_s: float
    progress: float = 0.0
    looking: bool = True
    view: int | None = None

    def rng(self, sensor: str) -> np.random.Generator:
        """The sensor's own chance at this moment."""
        world = self.stage.world
        return generator(world.seed, world.run, sensor, self.index)


def sense(moment: Moment) -> list[Reading]:
    """All readings of a data set, in the order of their times."""
    pose, _ = moment.pose_at(moment.time_s)
    people = moment.stage.bystanders(moment.time_s, pose)
    readings: list[Reading] = []
    for role in moment.rig.roles:
        if moment.looking or role not in CAMERAS:
            readings += _SENSES[role](moment, people)
    return sorted(readings, key=lambda reading: reading.time_s)


def _panorama(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    eye = moment.rig.panorama
    light, turning = _look(moment, people, _panorama_rays(eye), eye.height_m)
    smear = turning * moment.rig.film.shutter_s * eye.width_px / (2.0 * np.pi)
    pixels = film.develop(light, moment.rig.film, moment.rng("panorama"), smear, around=True)
    hidden = film.hide(pixels, moment.rig.mask, moment.progress)
    yield Reading("panorama", moment.time_s, hidden)


def _omni(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    eye = moment.rig.omni
    light, _ = _look(moment, people, _omni_rays(eye), eye.height_m)
    pixels = film.develop(light, moment.rig.film, moment.rng("omni"), 0.0, around=False)
    yield Reading("omni", moment.time_s, pixels)


def _camera(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    if "pan" not in moment.rig.roles:
        yield Reading("camera", moment.time_s, _ahead(moment, people, "camera", offset=False))


def _camera_offset(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    pixels = _ahead(moment, people, "camera_offset", offset=True)
    yield Reading("camera_offset", moment.time_s, pixels)


def _ahead(
    moment: Moment, people: Bystanders | None, name: str, *, offset: bool
) -> NDArray[np.uint8]:
    """Forward image; both twins share one exposure, each has its own noise."""
    eye = moment.rig.camera
    mount = eye.mount(offset=offset)
    light, turning = _look(moment, people, _camera_rays(eye), eye.height_m, mount)
    smear = turning * moment.rig.film.shutter_s * eye.focal_px
    shared, own = moment.rng("camera"), moment.rng(name)
    return film.develop(light, moment.rig.film, shared, smear, around=False, grain=own)


def _pan(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    """The row of partial views, each with its pan angle."""
    head, eye = moment.rig.pan, pan_camera(moment.rig)
    angles = list(enumerate(head.angles_rad().tolist()))
    chosen = angles if moment.view is None else [angles[moment.view % len(angles)]]
    for number, angle in chosen:
        late = number * head.period_s if moment.view is None else 0.0
        time_s = moment.time_s + late
        mount = Pose2(0.0, 0.0, angle)
        light, _ = _look(moment, people, _camera_rays(eye), eye.height_m, mount, time_s)
        rng = moment.rng(f"pan {number}")
        pixels = film.develop(light, moment.rig.film, rng, 0.0, around=False)
        yield Reading("pan", time_s, angle)
        yield Reading("camera", time_s, pixels)


def _scan(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    time_s = moment.time_s + moment.rig.capture.scan_late_s
    pose, _ = moment.pose_at(time_s)
    rig, rng = moment.rig, moment.rng("laser")
    yield Reading("scan", time_s, ranges.scan(moment.stage.scene, people, pose, rig.laser, rng))


def _sonar(moment: Moment, people: Bystanders | None) -> Iterator[Reading]:
    time_s = moment.time_s + moment.rig.capture.sonar_late_s
    pose, _ = moment.pose_at(time_s)
    rig, rng = moment.rig, moment.rng("sonar")
    yield Reading("sonar", time_s, ranges.ring(moment.stage.scene, people, pose, rig.sonar, rng))


def _look(
    moment: Moment,
    people: Bystanders | None,
    rays: eyes.Rays,
    height_m: float,
    mount: Pose2 | None = None,
    time_s: float | None = None,
) -> tuple[NDArray[np.float32], float]:
    """Radiance seen from a mount, and the rate of turn meanwhile."""
    pose, turning = moment.pose_at(moment.time_s if time_s is None else time_s)
    place = pose if mount is None else compose(pose, mount)
    return moment.stage.look(rays, place, height_m, people), turning


_SENSES: dict[str, Callable[[Moment, Bystanders | None], Iterator[Reading]]] = {
    "panorama": _panorama,
    "omni": _omni,
    "camera": _camera,
    "camera_offset": _camera_offset,
    "pan": _pan,
    "scan": _scan,
    "sonar": _sonar,
}


@functools.lru_cache(maxsize=4)
def _panorama_rays(eye: eyes.PanoramaEye) -> eyes.Rays:
    return eyes.panorama_rays(eye)


@functools.lru_cache(maxsize=4)
def _omni_rays(eye: eyes.OmniEye) -> eyes.Rays:
    return eyes.omni_rays(eye)


@functools.lru_cache(maxsize=4)
def _camera_rays(eye: eyes.CameraEye) -> eyes.Rays:
    return eyes.camera_rays(eye)
