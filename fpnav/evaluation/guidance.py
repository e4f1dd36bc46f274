"""How well a policy led: homing, following a route, its actions beside the teacher's (B5, B6).

The task stands in the protocol of the result under ``task``: ``goal_m`` x, y of the goal in the
world, or ``way_m`` the points of the route; without either the way is that of the mapping run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.bootstrap import BLOCK
from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import Absent, Measure, share
from fpnav.geometry import angular_distance
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Metric

HOME_M = 0.3
"""A trip is home when it ends so near the goal; nearer, no direction is judged."""

ASTRAY_M = 5.0
"""A trip that is ever farther from its route has left it: the width of a street."""

CLOSED_M = 3.0
"""A trip along a route ends where the route ends, to so many metres."""

AHEAD_M = 1.0
SAMPLE_M = 0.1

NO_ACTIONS = Absent("no policy decided anything: made by another command than navigate")


def homing_success(name: str, case: Case) -> Metric | Absent:
    """Trips that end within 0.3 m of the goal."""
    goal = goal_of(case.result)
    if not len(case.result.actions):
        return NO_ACTIONS
    if goal is None:
        return Absent("the task was to follow a route, not to come to a goal")
    if not driven(case.result):
        return Absent("the policy was asked on a log and moved nobody")
    home = ends_home(case.result.actions, goal)
    return share(name, home, np.ones(len(home), bool), block=1)


def route_closed(name: str, case: Case) -> Metric | Absent:
    """Trips that come to the end of the route without ever leaving it."""
    if not len(case.result.actions):
        return NO_ACTIONS
    if goal_of(case.result) is not None:
        return Absent("the task was to come to a goal, not to follow a route")
    if not driven(case.result):
        return Absent("the policy was asked on a log and moved nobody")
    closed = follows(case.result.actions, way_of(case.result))
    return share(name, closed, np.ones(len(closed), bool), block=1)


def action_within(limit_deg: float) -> Measure:
    """Measure: decisions whose direction is within so many degrees of the teacher's."""

    def measured(name: str, case: Case) -> Metric | Absent:
        actions = case.result.actions
        if not len(actions):
            return NO_ACTIONS
        error, known = action_error(case.result), np.isfinite(taught(case.result))
        if not known.any():
            return Absent("no decision has a pose in truth and a direction of the teacher")
        return share(name, error <= math.radians(limit_deg), known, BLOCK)

    return measured


def action_error(result: Result) -> FloatArray:
    """Angle (A,) between what was wanted and what the teacher would do, rad; pi where nothing."""
    return error_of(result.actions, taught(result))


def taught(result: Result) -> FloatArray:
    """Direction (A,) of the teacher at each decision, in the world; NaN where there is none."""
    goal = goal_of(result)
    if goal is not None:
        return taught_home(result.actions, goal)
    return taught_along(result.actions, way_of(result))


def taught_home(actions: NDArray[Any], goal: FloatArray) -> FloatArray:
    """Direction (A,) to the goal; NaN within HOME_M of it."""
    apart = goal - actions["truth"][:, :2]
    direction = np.arctan2(apart[:, 1], apart[:, 0])
    return np.asarray(np.where(np.hypot(*apart.T) > HOME_M, direction, np.nan))


def taught_along(actions: NDArray[Any], way: FloatArray) -> FloatArray:
    """Direction (A,) of the way from the point nearest to each position; NaN astray of it."""
    at = actions["truth"][:, :2]
    if len(way) < 2:
        return np.full(len(at), np.nan)
    ahead = max(1, round(AHEAD_M / SAMPLE_M))
    later = way[np.minimum(np.arange(len(way)) + ahead, len(way) - 1)]
    earlier = np.where((later == way).all(axis=1)[:, None], way[max(0, len(way) - 2)], way)
    direction = np.arctan2(*(later - earlier).T[::-1])
    nearest, apart = _nearest(at, way)
    return np.asarray(np.where(apart <= ASTRAY_M, direction[nearest], np.nan))


def error_of(actions: NDArray[Any], taught_rad: FloatArray) -> FloatArray:
    """Angle (A,) between what was wanted and what is taught, rad; pi where either is unknown."""
    error = angular_distance(actions["truth"][:, 2] + actions["wanted_rad"], taught_rad)
    return np.asarray(np.where(np.isfinite(error), error, math.pi))


def ends_home(actions: NDArray[Any], goal: FloatArray) -> Bools:
    """Whether each trip ends within HOME_M of the goal, (T,)."""
    return np.asarray(ends_from(actions, goal) <= HOME_M)


def ends_from(actions: NDArray[Any], goal: FloatArray) -> FloatArray:
    """How far from the goal each trip ends, metres, (T,)."""
    ends = np.array([trip["truth"][-1, :2] for trip in trips(actions)])
    return np.asarray(np.hypot(*(ends - goal).T))


def follows(actions: NDArray[Any], way: FloatArray) -> Bools:
    """Whether each trip passes all of a way, stays on it and ends where it ends, (T,)."""
    return np.array([_closed(trip["truth"], way) for trip in trips(actions)], bool)


def trips(actions: NDArray[Any]) -> list[NDArray[Any]]:
    """Decisions of each trip, in order."""
    return [actions[actions["trip"] == trip] for trip in np.unique(actions["trip"])]


def goal_of(result: Result) -> FloatArray | None:
    """Goal in the world, (2,), None where the task was a route."""
    goal = task_of(result).get("goal_m")
    return None if goal is None else np.array(goal, dtype=np.float64)


def way_of(result: Result) -> FloatArray:
    """Route in the world, (n, 2), points SAMPLE_M apart: the task's, else the mapping run's."""
    way = task_of(result).get("way_m")
    points = result.references["truth"][:, :2] if way is None else np.array(way, dtype=np.float64)
    return resampled(points[np.isfinite(points).all(axis=1)])


def resampled(points: FloatArray) -> FloatArray:
    """A way (n, 2) with points SAMPLE_M apart."""
    if len(points) < 2:
        return np.asarray(points)
    marks = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.arange(0.0, marks[-1] + SAMPLE_M / 2, SAMPLE_M)
    return np.column_stack([np.interp(at, marks, points[:, k]) for k in (0, 1)])


def driven(result: Result) -> bool:
    """Whether the policy moved the robot, rather than being asked on a log."""
    return bool(task_of(result).get("driven", False))


def task_of(result: Result) -> Mapping[str, Any]:
    """The task of a result of ``navigate``, empty elsewhere."""
    task: Mapping[str, Any] = result.header.get("protocol", {}).get("task", {})
    return task


def _nearest(at: FloatArray, way: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
    """Row of the nearest point of the way, and its distance, for each position."""
    if not len(at):
        return np.zeros(0, np.int64), np.zeros(0)
    apart = np.hypot(at[:, None, 0] - way[:, 0], at[:, None, 1] - way[:, 1])
    nearest = np.argmin(apart, axis=1)
    return nearest, apart[np.arange(len(at)), nearest]


def _closed(truth: FloatArray, way: FloatArray) -> bool:
    """Whether a trip stays on the way, passes all of it, and ends where it ends."""
    if len(way) < 2:
        return False
    nearest, apart = _nearest(truth[:, :2], way)
    end = float(np.hypot(*(truth[-1, :2] - way[-1])))
    passed = np.unique(nearest // max(1, round(1.0 / SAMPLE_M)))
    whole = len(passed) >= 0.9 * math.ceil(len(way) * SAMPLE_M)
    return bool(apart.max() <= ASTRAY_M and end <= CLOSED_M and whole)


MEASURES: dict[str, Measure] = {
    "homing_success": homing_success,
    "route_closed": route_closed,
    "action_within_45": action_within(45.0),
}
