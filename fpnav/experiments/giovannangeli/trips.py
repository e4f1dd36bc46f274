"""Navigation in closed loop: homing (figure 6), and the loop of a suburb (figure 8)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from fpnav.evaluation.guidance import (
    ends_from,
    ends_home,
    error_of,
    follows,
    resampled,
    taught_along,
    taught_home,
    trips,
)
from fpnav.execution.guided import asked_on_log
from fpnav.execution.stages import make_map
from fpnav.execution.walk import SystemChoice
from fpnav.experiments.giovannangeli.lines import LEARN, TEST, choice, labelled
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.navigation.actions import Actions, along, pose_of, towards
from fpnav.navigation.policy import PlaceAction
from fpnav.navigation.steering import SteeringParams
from fpnav.params import Tables
from fpnav.report.figures import trips as drawing
from fpnav.report.study import Illustration
from fpnav.sim.catalogue import Setting
from fpnav.sim.mission import Order, following, homing
from fpnav.sim.record import Job, stage_of
from fpnav.sim.trips import Expedition, travel
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import ACTION
from fpnav.systems.base import System
from fpnav.values import FloatArray, Metric

RING_M = 7.3
"""Length of the homing route that passes the goal and the ring of places about it."""

TRIPS, TRIPS_AMONG_PEOPLE, TRIPS_AT_ONCE = 40, 20, 5
HOMING_S, AMONG_PEOPLE_S, PERIOD_S = 16.0, 24.0, 0.5
"""Time of a trip and between two of its decisions; the map of figure 6 is eight places."""

MORNING = 2
"""Run at ten in the morning of the next day; LEARN and TEST are at five in the afternoon."""

LOOP_SPEED_MPS = 0.4
PLACES_EVERY_M = 2.0

OTHER_LIGHT: dict[str, Any] = {"spacing_m": PLACES_EVERY_M, "patch_norm": "meanstd"}
"""What is changed of figure 8's column for a way that is driven in other light: places by way gone,
and local views without their brightness and contrast, of which the paper does not speak."""


@dataclass(frozen=True)
class Leader:
    """All that a policy of place-action pairs is made of; goes to workers as it is."""

    system: System
    built: BuiltMap
    actions: Actions
    params: SteeringParams

    def __call__(self) -> PlaceAction:
        """A fresh policy."""
        memory = self.system.memory()
        memory.load(self.built.memory)
        return PlaceAction(self.system, memory, self.actions, self.params)


def homing_from_all_around(shop: Workshop, seed: int) -> Outcome:
    """B5, figure 6: home from all over the disc of 1.5 m, alone and with somebody about."""
    leader, goal = taught_ring(shop, seed)
    alone = home_trips(shop, seed, leader, goal, few(shop, TRIPS))
    crowded = home_trips(
        shop, seed, leader, goal, few(shop, TRIPS_AMONG_PEOPLE), AMONG_PEOPLE_S, people=1
    )
    metrics = [
        success("homing_success", ends_home(alone, goal)),
        success("homing_success_people", ends_home(crowded, goal)),
        *ended(ends_from(alone, goal)),
        within("action_within_45", alone, taught_home(alone, goal)),
        bumps("bumps", alone),
    ]
    title = "Figure 6 here: ways home"
    caption = "Each line a trip, from a dot to a cross; triangles are the places learned."
    places = leader.built.signatures.references["truth"]
    pictures = [
        Illustration("home", title, caption, partial(drawing.draw_home, alone, goal, places)),
        Illustration(
            "people",
            "The same with somebody walking about",
            caption,
            partial(drawing.draw_home, crowded, goal, places),
        ),
    ]
    return Outcome(metrics, pictures, {"preset": "fig3b", "trips": len(trips(alone))})


def closing_the_loop(shop: Workshop, seed: int) -> Outcome:
    """B6, figure 8: a loop of 100 m learned at five, driven at ten the next morning.

    Actions are judged on a log of the teacher's way that morning, and on the robot's own.
    """
    length = {"capture": {"length_m": 20.0}} if shop.small else {}
    learn = job_of("suburb", "loop", seed, LEARN, tables=length)
    leader = taught_way(shop, learn, choice("fig8", **OTHER_LIGHT))
    morning = job_of("suburb", "loop", seed, MORNING, tables=length)
    driven, way = drive(leader, morning)
    again = shop.run(shop.log(morning), choice("fig8", **OTHER_LIGHT))
    asked = asked_on_log(leader(), again.table)
    metrics = [
        success("route_closed", follows(driven, way)),
        within("action_within_45", asked, taught_along(asked, way)),
        within("action_within_45_driven", driven, taught_along(driven, way)),
        bumps("bumps", driven),
    ]
    title = "Figure 8 here: the loop in the morning"
    caption = "The way taught (grey) and the way driven; triangles are the places learned."
    places = _places(leader.built)
    picture = Illustration("loop", title, caption, partial(drawing.draw_way, driven, way, places))
    return Outcome(metrics, [picture], {"preset": "fig8", **OTHER_LIGHT, "places": len(places)})


def taught_ring(shop: Workshop, seed: int, names: Sequence[str] = ()) -> tuple[Leader, FloatArray]:
    """Places about a goal with the direction to it, all or those named, and the goal, (2,)."""
    tables: Tables = {"capture": {"length_m": RING_M}}
    log = shop.log(job_of("room", "homing", seed, LEARN, sensors=["panorama"], tables=tables))
    run = shop.run(log, choice("fig3b"))
    goal = next(s.reference for s in run.table if s.reference.label == "goal")
    _, built = make_map(
        labelled(run, names), [log], guided=True, close_loops=False, advance=lambda done: None
    )
    actions = towards(built.topomap, built.signatures, pose_of(goal))
    truth = np.array([goal.truth.x_m, goal.truth.y_m]) if goal.truth else np.zeros(2)
    return Leader(run.system, built, actions, SteeringParams()), truth


def taught_way(shop: Workshop, learn: Job, chosen: SystemChoice) -> Leader:
    """Places along a way with the direction in which it went on."""
    log = shop.log(learn)
    run = shop.run(log, chosen)
    _, built = make_map(run, [log], guided=False, close_loops=False, advance=lambda done: None)
    params = SteeringParams(speed_mps=LOOP_SPEED_MPS, blend=0.0)
    return Leader(run.system, built, along(built.topomap, built.signatures), params)


def home_trips(
    shop: Workshop,
    seed: int,
    leader: Leader,
    goal: FloatArray,
    count: int,
    seconds: float = HOMING_S,
    *,
    people: int = 0,
) -> NDArray[Any]:
    """Decisions of trips home from poses drawn about the goal, spread over the workers."""
    tables: Tables = {"world": {"people": people}}
    job = job_of("room", "homing", seed, TEST, sensors=["panorama", "scan"], tables=tables)
    order = Order(trips=count, seconds=seconds, period_s=PERIOD_S)
    whole = homing(stage_of(job.setting), job.rig, goal.tolist(), order)
    parts = [
        (job.setting, replace(whole, starts=whole.starts[at : at + TRIPS_AT_ONCE]), leader)
        for at in range(0, count, TRIPS_AT_ONCE)
    ]
    return _joined(list(shop.spread.ordered(_go, parts)))


def drive(leader: Leader, job: Job) -> tuple[NDArray[Any], FloatArray]:
    """Decisions of one trip along a job's route, and the way, (n, 2).

    The robot that drives by itself carries a scanner besides: the neural field takes it around
    what stands beside the way (section V-B).
    """
    stage = stage_of(job.setting)
    rig = structs.replace(job.rig, roles=tuple(dict.fromkeys([*job.rig.roles, "scan"])))
    expedition = following(stage, rig, job.route, leader.params.speed_mps, Order())
    way = resampled(np.array(expedition.route.points))
    return travel(stage, expedition, leader), way


def success(name: str, right: NDArray[np.bool_]) -> Metric:
    """Share of trips."""
    return Metric(name, float(right.mean()), int(right.sum()), len(right))


def ended(from_goal_m: FloatArray) -> list[Metric]:
    """How far from the goal trips end: half of them nearer than, and the farthest."""
    of = len(from_goal_m)
    return [
        Metric("end_median_m", float(np.median(from_goal_m)), of, of, "m"),
        Metric("end_farthest_m", float(from_goal_m.max()), of, of, "m"),
    ]


def within(name: str, actions: NDArray[Any], taught_rad: FloatArray) -> Metric:
    """Share of the decisions within 45 degrees of what is taught, where anything is."""
    known = np.isfinite(taught_rad)
    right = (error_of(actions, taught_rad) <= math.radians(45.0)) & known
    return Metric(
        name, float(right.sum() / max(1, known.sum())), int(right.sum()), int(known.sum())
    )


def bumps(name: str, actions: NDArray[Any]) -> Metric:
    """Share of the decision periods in which the robot touched something."""
    touched = actions["bumped"]
    return Metric(name, float(touched.mean()), int(touched.sum()), len(touched))


def _go(item: tuple[Setting, Expedition, Leader]) -> NDArray[Any]:
    """Trips of one part: the unit of work that is spread."""
    setting, expedition, leader = item
    return travel(stage_of(setting), expedition, leader)


def _joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Trips of all parts, numbered on."""
    first = 0
    for part in parts:
        count = int(part["trip"].max()) + 1
        part["trip"] += first
        first += count
    return np.concatenate([np.zeros(0, ACTION), *parts])


def _places(built: BuiltMap) -> FloatArray:
    """True pose (P, 3) of each place's first observation."""
    rows = [place.members[0] for place in built.topomap.places]
    return np.asarray(built.signatures.references["truth"][rows])


def few(shop: Workshop, count: int) -> int:
    """So many trips, or two in small."""
    return 2 if shop.small else count
