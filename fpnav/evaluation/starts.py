"""Where places start: at doors and changes of the world, or before doors that were closed.

A door stands in the wall. A robot that drives past it in the middle of a corridor is never within
1 m of it, open or closed, so that only doors it went through count by the distance to the door
itself. By the distance to the ``front`` of the door, the way through it as far as 1 m to either
side, doors that are driven past count too, closed ones as open ones.

Beside each figure stands what chance gives: as many starts, put anywhere on the ground of the same
run where it was driven for the first time, since on known ground no place can start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.accepted import Bools
from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import Absent, Measure, share
from fpnav.evaluation.topology import plan_of_case
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Metric

NEAR_M = 1.0

_NOTHING = Absent("no place starts along the way, or nothing is listed")
_NOT_PASSED = Absent("nothing that is listed lies within 1 m of the mapping path")


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """S starts and G poses on new ground, by the L landmarks each is within 1 m of.

    ``starts`` (S, L), ``ground`` (G, L), ``passed`` (L,) by any pose of the run;
    ``closed_starts`` (S,), ``closed_ground`` (G,): before a closed door and at no landmark.
    """

    starts: Bools
    ground: Bools
    passed: Bools
    closed_starts: Bools
    closed_ground: Bools


Told = Callable[[str, Met], Metric | Absent]


def starting(told: Told, *, front: bool = False) -> Measure:
    """A figure below as a measure; ``front`` : by the front of doors, not only the doors."""

    def measure(name: str, case: Case) -> Metric | Absent:
        met = _met(case, front)
        return met if isinstance(met, Absent) else told(name, met)

    return measure


def node_precision(name: str, met: Met) -> Metric | Absent:
    """Share of places that start within 1 m of a listed open door or change.

    The place a session starts in starts there for no reason of the world's and is left out.
    """
    if not met.starts.size:
        return _NOTHING
    near = np.asarray(met.starts.any(axis=1))
    return share(name, near, np.ones(len(near), bool), block=1)


def node_precision_chance(name: str, met: Met) -> Metric | Absent:
    """The share expected of starts anywhere on new ground."""
    if not met.starts.size:
        return _NOTHING
    near = np.asarray(met.ground.any(axis=1))
    return Metric(name, float(near.mean()), int(near.sum()), len(near))


def node_recall(name: str, met: Met) -> Metric | Absent:
    """Share of listed open doors and changes, within 1 m of the mapping path, that got a place."""
    if not met.passed.any():
        return _NOT_PASSED
    got = np.asarray(met.starts[:, met.passed].any(axis=0))
    return share(name, got, np.ones(len(got), bool), block=1)


def node_recall_chance(name: str, met: Met) -> Metric | Absent:
    """The share expected of as many starts anywhere on new ground."""
    if not met.passed.any() or not len(met.ground):
        return _NOT_PASSED
    missed = (1.0 - met.ground[:, met.passed].mean(axis=0)) ** len(met.starts)
    count = int(met.passed.sum())
    return Metric(name, float(1.0 - missed.mean()), count, count)


def nodes_at_closed_doors(name: str, met: Met) -> Metric | Absent:
    """Number of places that start within 1 m of a closed door, and of nothing else listed."""
    count = int(met.closed_starts.sum())
    return Metric(name, float(count), count, len(met.starts))


def nodes_at_closed_doors_chance(name: str, met: Met) -> Metric | Absent:
    """Their number expected of as many starts anywhere on new ground."""
    if not len(met.ground):
        return _NOTHING
    expected = float(met.closed_ground.mean()) * len(met.starts)
    return Metric(name, expected, len(met.starts), len(met.starts))


def _met(case: Case, front: bool) -> Met | Absent:
    plan = plan_of_case(case)
    if isinstance(plan, Absent):
        return plan
    at, new = _rows(case.result)
    xy = case.result.references["truth"][:, :2]
    near = _within(xy, plan.fronts if front else _points(plan.landmarks))
    closed = _within(xy, plan.closed_fronts if front else _points(plan.closed))
    only = np.asarray(closed.any(axis=1) & ~near.any(axis=1))
    return Met(near[at], near[new], np.asarray(near.any(axis=0)), only[at], only[new])


def _rows(result: Result) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows where places start, and rows on ground driven for the first time, of known position.

    The first row of a session is neither.
    """
    references, owner = result.references, result.owner
    opening = np.diff(references["session"], prepend=-1) != 0
    known = np.isfinite(references["truth"][:, :2]).all(axis=1) & ~opening
    _, first, place = np.unique(owner, return_index=True, return_inverse=True)
    stay = np.cumsum(opening | (np.diff(owner, prepend=-1) != 0))
    new = np.flatnonzero((stay == stay[first][place]) & known)
    at = np.sort(first)
    return at[known[at]], new


def _within(points: FloatArray, lines: FloatArray) -> Bools:
    """Whether each point (N, 2) lies within 1 m of each line from end to end (L, 2, 2), (N, L)."""
    near = np.zeros((len(points), len(lines)), bool)
    for number, (start, end) in enumerate(lines):
        along, off = end - start, points - start
        at = np.clip(off @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        away = off - at[:, None] * along
        near[:, number] = np.hypot(away[:, 0], away[:, 1]) <= NEAR_M
    return near


def _points(marks: FloatArray) -> FloatArray:
    """Points (L, 2) as lines of no length."""
    return np.repeat(marks[:, None, :], 2, axis=1)
