"""Drive a route and record it: poses first, then every sensor at its times, in log order."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fpnav.execution.spread import Here, Spread
from fpnav.logs.writer import LogWriter
from fpnav.publish import publish
from fpnav.sim.catalogue import Setting, route_of
from fpnav.sim.journal import Journal
from fpnav.sim.motion import CARRY_S, TICK_S, Track, capture_times, carry, drive, kidnapped
from fpnav.sim.rig import Rig
from fpnav.sim.seeds import generator
from fpnav.sim.sense import Moment, Reading, sense
from fpnav.sim.sensors import film, state
from fpnav.sim.stage import Stage, set_stage
from fpnav.sim.walls import drive_along_walls
from fpnav.sim.world import Route, World
from fpnav.values import FloatArray, Pose2

CHUNK = 8
"""Data sets that one worker makes at a time."""

AFTER_S = 0.25
"""The log goes on this long after the last data set."""

Sealed = tuple[Reading, bytes | None]
"""A reading, and the JPEG bytes where it is an image."""


@dataclass(frozen=True)
class Job:
    """One run to record: all that decides its bytes."""

    setting: Setting
    route: str
    rig: Rig


@functools.lru_cache(maxsize=6)
def world_of(setting: Setting) -> World:
    """The world of a setting; kept for the next call in this process."""
    return setting.make()


@functools.lru_cache(maxsize=3)
def stage_of(setting: Setting) -> Stage:
    """The stage of a setting; kept for the next call in this process."""
    return set_stage(world_of(setting))


@functools.lru_cache(maxsize=4)
def driven(job: Job) -> tuple[Route, Track, FloatArray]:
    """Route and track of the run, and the times of its data sets; kept in this process."""
    world, capture = world_of(job.setting), job.rig.capture
    route = route_of(world, job.route)
    speed = capture.speed_mps or route.speed_mps
    track = _drive(job, route, speed)
    length = min(route.length_m, capture.length_m or route.length_m)
    if route.carried:
        times = np.arange(len(route.points), dtype=np.float64) * CARRY_S
    else:
        times = capture_times(track, capture.step_m or route.step_m, length)
    used = track.until(float(times[-1]) + AFTER_S)
    rng = generator(world.seed, world.run, "kidnaps")
    return route, *kidnapped(used, times, capture.kidnaps, rng)


def _drive(job: Job, route: Route, speed_mps: float) -> Track:
    if route.carried:
        return carry(route.points)
    if route.half_width_m <= 0.0:
        return drive(route, speed_mps)
    stage = stage_of(job.setting)
    rng = generator(stage.world.seed, stage.world.run, "walls")
    return drive_along_walls(route, speed_mps, stage.scene, job.rig.sonar, rng)


def sense_chunk(item: tuple[Job, int, int]) -> list[list[Sealed]]:
    """Data sets ``start`` to ``stop`` of a job: the unit of work that is spread."""
    job, start, stop = item
    route, track, times = driven(job)
    made = []
    for i in range(start, stop):
        time_s = float(times[i])
        pose = track.pose_at(time_s)
        awake = i % job.rig.capture.images_every == 0 and looking(route, job.rig, pose)
        stage = stage_at(job.setting, pose)
        moment = Moment(stage, job.rig, track.state_at, i, time_s, i / len(times), awake)
        made.append([sealed(reading, job.rig) for reading in sense(moment)])
    return made


def stage_at(setting: Setting, pose: Pose2) -> Stage:
    """The stage of the part of the world that a pose lies in."""
    blocks = world_of(setting).blocks
    if blocks is None:
        return stage_of(setting)
    part = blocks.part_at(pose.x_m, pose.y_m)
    return stage_of(replace(setting, overrides=(*setting.overrides, ("part", part))))


def looking(route: Route, rig: Rig, pose: Pose2) -> bool:
    """Whether the cameras look from here: always, or near the route's marks only."""
    near = rig.capture.images_near_m
    if near <= 0.0:
        return True
    return any(math.hypot(m.x_m - pose.x_m, m.y_m - pose.y_m) <= near for m in route.marks)


def sealed(reading: Reading, rig: Rig) -> Sealed:
    """The reading as the recorder takes it: images are encoded, their pixels dropped."""
    if not isinstance(reading.value, np.ndarray):
        return reading, None
    data = film.encode(reading.value, rig.film.quality)
    return Reading(reading.role, reading.time_s, None), data


def data_sets(job: Job, count: int, spread: Spread) -> Iterator[list[Sealed]]:
    """All data sets of a job, in order."""
    items = [(job, start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]
    for chunk in spread.ordered(sense_chunk, items):
        yield from chunk


def record(
    job: Job,
    output: Path,
    *,
    spread: Spread | None = None,
    clobber: bool = True,
    advance: Callable[[int], None] = lambda done: None,
) -> dict[str, Any]:
    """Record a job into an MCAP file; returns counts for the summary.

    Raises
    ------
    UsageError
        The world or the route does not exist.
    FpnavError
        The file cannot be written.
    """
    route, track, times = driven(job)
    end_s = track.duration_s
    with publish(output, clobber=clobber) as stream, LogWriter(stream) as log:
        journal = Journal(log, world_of(job.setting), route, job.rig)
        journal.begin()
        states = _States(journal, track, job)
        for readings in data_sets(job, len(times), spread or Here()):
            for reading in readings:
                states.write_until(reading[0].time_s)
                journal.readings([reading])
            advance(1)
        states.write_until(end_s)
        journal.finish()
    travelled = np.interp(times[-1], np.arange(len(track.poses)) * TICK_S, track.travelled_m)
    return {
        "data_sets": len(times),
        "length_m": round(float(travelled), 3),
        "duration_s": round(end_s, 3),
    }


class _States:
    """The state messages of a run, written up to a time."""

    def __init__(self, journal: Journal, track: Track, job: Job) -> None:
        world = journal.world
        self.journal, self.track, self.tick = journal, track, 0
        self.every = max(1, round(job.rig.capture.state_s / TICK_S))
        rng = generator(world.seed, world.run, "drift")
        self.odometry = state.odometry(track, job.rig.drift, rng)
        self.compass = state.compass_of(job.rig.compass, world.seed, world.run).read(track.poses)

    def write_until(self, time_s: float) -> None:
        """All states up to and including a time."""
        while self.tick < len(self.track.poses) and self.tick * TICK_S <= time_s:
            linear, angular = self.track.speeds[self.tick].tolist()
            self.journal.state(
                self.tick,
                Pose2(*self.track.poses[self.tick].tolist()),
                Pose2(*self.odometry[self.tick].tolist()),
                (linear, angular),
                float(self.compass[self.tick]),
            )
            self.tick += self.every
