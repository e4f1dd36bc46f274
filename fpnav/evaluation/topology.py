"""Does the map have the shape of the building?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.case import Case
from fpnav.evaluation.measure import NO_MAP, NO_POSES, Absent
from fpnav.evaluation.plan import Plan, plan_of
from fpnav.values import Metric

_NO_PLAN = Absent("the mapping log carries no world.json: rooms, doors and changes are unknown")
_LARGEST = 10**9


def topology_equal(name: str, case: Case) -> Metric | Absent:
    """1 where the map, places of one room merged, joins the rooms that the mapping run joined.

    Rooms are told apart by listed doors; spaces that the run crossed between without a listed door
    are one room. A place lies in the room of its centre. ``n`` of ``of``: passages in both of those
    in either; a room without a place counts as one passage missing.
    """
    plan = plan_of_case(case)
    if isinstance(plan, Absent):
        return plan
    result = case.result
    visited = plan.room_of(result.references["truth"][:, :2])
    room_of = one_room(plan, visited)
    driven = _passages(room_of[visited], result.references["session"])
    centre = room_of[plan.room_of(result.view.place_pose[:, :2])]
    at = dict(zip(result.view.place_ids.tolist(), centre.tolist(), strict=True))
    edges = result.view.edges
    joined = _pairs([at[s] for s in edges["source"].tolist()],
                    [at[t] for t in edges["target"].tolist()])  # fmt: skip
    lost = set(room_of[visited].tolist()) - {-1} - set(at.values())
    same, either = len(driven & joined), len(driven | joined) + len(lost)
    return Metric(name, float(same == either), same, either)


def plan_of_case(case: Case) -> Plan | Absent:
    """The plan a map can be compared with, or why there is none."""
    if not case.has_map:
        return NO_MAP
    if np.isnan(case.result.references["truth"]).any(axis=1).all():
        return NO_POSES
    plan = plan_of(case.result.header)
    if plan is None:
        return _NO_PLAN
    if len(plan.rooms) * len(case.result.references) > _LARGEST:
        return Absent("the plan is too large to compare room by room")
    return plan


def one_room(plan: Plan, visited: NDArray[np.int64]) -> NDArray[np.int64]:
    """Room number of each space, pieces crossed between without a listed door sharing one; the
    last entry, for -1, is -1."""
    room = np.append(np.arange(len(plan.rooms)), -1)
    steps = zip(visited[:-1].tolist(), visited[1:].tolist(), strict=True)
    for a, b in sorted({(min(step), max(step)) for step in steps if step[0] != step[1]}):
        if a >= 0 and (a, b) not in plan.door_rooms:
            room[room == room[b]] = room[a]
    return room


def _passages(rooms: NDArray[np.int64], session: NDArray[np.int32]) -> set[tuple[int, int]]:
    """Pairs of rooms driven between within one session; positions in no room are skipped."""
    pairs: set[tuple[int, int]] = set()
    for number in np.unique(session):
        known = rooms[(session == number) & (rooms >= 0)].tolist()
        pairs |= _pairs(known[:-1], known[1:])
    return pairs


def _pairs(first: list[int], second: list[int]) -> set[tuple[int, int]]:
    """Unordered pairs of different rooms, nowhere left out."""
    steps = zip(first, second, strict=True)
    return {(min(a, b), max(a, b)) for a, b in steps if a != b and min(a, b) >= 0}
