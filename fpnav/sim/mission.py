"""What ``fpnav navigate`` sends a robot out to do: from a map and a task to an expedition."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.execution.guided import Guide
from fpnav.navigation.steering import SteeringParams
from fpnav.params import resolve
from fpnav.sim.catalogue import Setting, default_rig, overrides_in, route_of
from fpnav.sim.record import stage_of
from fpnav.sim.rig import Rig, make_rig
from fpnav.sim.robot import touches
from fpnav.sim.stage import Stage
from fpnav.sim.trips import Expedition, starts_around, travel
from fpnav.sim.world import Mark, Point, Route
from fpnav.values import Pose2

HOMING_S = 30.0
"""Time of a trip to a goal, where none is given."""

SLACK = 2.0
"""A trip along a route takes at most so many times what the route does at the policy's speed."""

TRIES = 2000


AFTER_MAP = 2
"""Runs after the map's: another drive at the same time of day."""


@dataclass(frozen=True, slots=True)
class Order:
    """What was asked for: which building and run, where to start, how often, how long."""

    seed: int | None = None
    run: int | None = None
    sensors: str | None = None
    trips: int = 1
    within_m: float = 1.5
    start: Pose2 | None = None
    seconds: float = 0.0
    period_s: float = 0.25


def send_out(
    guide: Guide,
    world: str,
    order: Order,
    output: Path,
    *,
    clobber: bool = True,
    advance: Callable[[int], None] = lambda done: None,
) -> tuple[NDArray[Any], dict[str, Any]]:
    """Send a robot out as ordered, its log to ``output``.

    Returns
    -------
    decisions : (A,) ACTION
    task : what the protocol of the result says of it

    Raises
    ------
    UsageError
        The map was learned elsewhere, or the world has no such route or no place to start from.
    FpnavError
        The log cannot be written.
    """
    setting, rig = _setting(guide, world, order)
    stage, task = stage_of(setting), guide.facts(driven=True)
    if guide.goal is not None:
        expedition = homing(stage, rig, task["goal_m"], order)
    else:
        speed = resolve("navigate", SteeringParams(), guide.tables).speed_mps
        expedition = following(stage, rig, guide.route, speed, order)
        task["way_m"] = [list(point) for point in expedition.route.points]
    actions = travel(stage, expedition, guide.make_policy, output, clobber=clobber, advance=advance)
    return actions, {**task, "seed": setting.seed, "run": setting.run}


def _setting(guide: Guide, world: str, order: Order) -> tuple[Setting, Rig]:
    """The world on its run, the map's own where nothing was asked for, and what the robot carries.

    Raises
    ------
    UsageError
        The map was learned in another world.
    """
    learned = world_of_map(guide.header) or {"world": world, "seed": 1, "run": 1}
    seed = learned["seed"] if order.seed is None else order.seed
    if (world, seed) != (learned["world"], learned["seed"]):
        raise UsageError(
            f"the map was learned in world {learned['world']} --seed {learned['seed']}, "
            f"not in {world} --seed {seed}"
        )
    run = learned["run"] + AFTER_MAP if order.run is None else order.run
    roles, defaults = default_rig(world)
    chosen = order.sensors.split(",") if order.sensors else roles
    rig = make_rig(chosen, defaults, guide.tables)
    return Setting(world, seed, run, overrides_in(guide.tables)), rig


def homing(stage: Stage, rig: Rig, goal_m: Sequence[float], order: Order) -> Expedition:
    """Trips to a goal from poses drawn about it, or from the one given.

    Raises
    ------
    UsageError
        There is no free place to start from.
    """
    goal = (float(goal_m[0]), float(goal_m[1]))
    seconds = order.seconds or HOMING_S
    starts = [order.start] * order.trips if order.start else _drawn(stage, goal, order)
    marks = _all_marks(stage.world.routes)
    route = Route("navigate", (goal, goal), marks=marks)
    return Expedition(rig, route, starts, math.ceil(seconds / order.period_s), order.period_s)


def following(stage: Stage, rig: Rig, name: str, speed_mps: float, order: Order) -> Expedition:
    """Trips along a route of the world from its start.

    Raises
    ------
    UsageError
        The world has no such route.
    """
    route = route_of(stage.world, name)
    (x, y), (nx, ny) = route.points[:2]
    start = order.start or Pose2(x, y, math.atan2(ny - y, nx - x))
    points = list(cut(route.points, rig.capture.length_m or route.length_m))
    seconds = order.seconds or SLACK * length_of(points) / speed_mps
    decisions = math.ceil(seconds / order.period_s)
    followed = replace(route, points=tuple(points))
    starts = [start] * order.trips
    return Expedition(rig, followed, starts, decisions, order.period_s, follow=True)


def length_of(points: Sequence[Point]) -> float:
    """Length of a way."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def cut(points: Sequence[Point], length_m: float) -> list[Point]:
    """The beginning of a way, of at most that length."""
    kept, left = [points[0]], length_m
    for a, b in itertools.pairwise(points):
        step = math.dist(a, b)
        if step >= left:
            share = left / step if step else 0.0
            return [*kept, (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))]
        kept.append(b)
        left -= step
    return kept


def world_of_map(header: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """World, seed and run that a map was learned in, None where no simulator made its log."""
    for signatures in header.get("chain", ()):
        for world in signatures.get("worlds", ()):
            if world:
                return {key: world[key] for key in ("world", "seed", "run") if key in world}
    return None


def _drawn(stage: Stage, goal: Point, order: Order) -> list[Pose2]:
    world, tries = stage.world, iter(range(TRIES))

    def free(pose: Pose2) -> bool:
        if next(tries, None) is None:
            raise UsageError(f"no free place to start from within {order.within_m} m of the goal")
        return not touches(stage, pose.x_m, pose.y_m)

    return starts_around(goal, order.within_m, order.trips, world.seed, world.run, free)


def _all_marks(routes: Mapping[str, Route]) -> tuple[Mark, ...]:
    """Named places of all routes, each once."""
    return tuple(dict.fromkeys(mark for route in routes.values() for mark in route.marks))


def pose_from(text: str) -> Pose2:
    """``X,Y`` or ``X,Y,DEGREES`` as a pose.

    Raises
    ------
    ValueError
        It is not of that form.
    """
    x, y, *degrees = (float(part) for part in text.split(","))
    if len(degrees) > 1 or not np.isfinite([x, y, *degrees]).all():
        raise ValueError(text)
    return Pose2(x, y, math.radians(degrees[0]) if degrees else 0.0)
