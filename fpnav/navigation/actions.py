"""Place-action pairs (PerAc): in which direction to go from each place of a map.

A direction is given in the frame of its place, which is the robot's frame at the place's first
observation, so that no compass is needed to follow it: recall says how far the robot is turned.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fpnav.errors import LogError
from fpnav.geometry import distance, relative
from fpnav.navigation.base import Task
from fpnav.topomap.graph import TopoMap
from fpnav.values import Pose2, Reference, Signature

Actions = Mapping[int, float]
"""Place id -> direction to go (rad) in the place's frame; a place without one is an end."""

AHEAD_M = 1.0


def actions_for(task: Task, topomap: TopoMap, signatures: Sequence[Signature]) -> dict[int, float]:
    """Actions of a task: towards its goal, or along the way of the mapping run.

    Raises
    ------
    LogError
        A place has neither odometry nor truth, or the map has no such goal.
    """
    if task.goal is None:
        return along(topomap, signatures)
    goal = task.goal
    if isinstance(goal, str):
        first = topomap.place(place_named(topomap, goal)).members[0]
        goal = pose_of(signatures[first].reference)
    return towards(topomap, signatures, goal)


def towards(
    topomap: TopoMap, signatures: Sequence[Signature], goal: Pose2, arrived_m: float = 0.3
) -> dict[int, float]:
    """Actions that lead straight to a goal, given in the frame of the mapping run's poses.

    Places within ``arrived_m`` of it are ends: their field reaches past the goal, where their
    direction would lead away from it.

    Raises
    ------
    LogError
        A place has neither odometry nor truth.
    """
    actions = {}
    for place in topomap.places:
        here = pose_of(signatures[place.members[0]].reference)
        way = relative(here, goal)
        if math.hypot(way.x_m, way.y_m) > arrived_m:
            actions[place.id] = math.atan2(way.y_m, way.x_m)
    return actions


def along(
    topomap: TopoMap, signatures: Sequence[Signature], ahead_m: float = AHEAD_M
) -> dict[int, float]:
    """Actions of the teacher: where the mapping run went on from each place, ``ahead_m`` further.

    Raises
    ------
    LogError
        A place has neither odometry nor truth.
    """
    references = [signature.reference for signature in signatures]
    actions = {}
    for place in topomap.places:
        first = place.members[0]
        here = pose_of(references[first])
        later = _further(references, first, ahead_m)
        if later is not None:
            way = relative(here, later)
            actions[place.id] = math.atan2(way.y_m, way.x_m)
    return actions


def place_named(topomap: TopoMap, name: str) -> int:
    """Id of the place with that label or number.

    Raises
    ------
    LogError
        There is no such place.
    """
    for place in topomap.places:
        if name in (place.label, str(place.id)):
            return place.id
    labels = sorted({place.label for place in topomap.places if place.label})
    known = ", ".join(labels) or f"places 0 to {len(topomap) - 1}"
    raise LogError(f"the map has no place {name!r}; it has {known}")


def pose_of(reference: Reference) -> Pose2:
    """Pose of a mapping frame: odometry where it has it, else truth.

    Raises
    ------
    LogError
        It has neither.
    """
    pose = reference.odometry if reference.odometry is not None else reference.truth
    if pose is None:
        raise LogError("the map has no poses to take directions from: neither odometry nor truth")
    return pose


def _further(references: Sequence[Reference], row: int, ahead_m: float) -> Pose2 | None:
    """Pose of the first frame of the session at least so far from a row's, else its last one."""
    here, last = pose_of(references[row]), None
    for reference in references[row + 1 :]:
        if reference.session != references[row].session:
            break
        last = pose_of(reference)
        if distance(here, last) >= ahead_m:
            return last
    return last


@dataclass(slots=True)
class Winner:
    """Winner take all over places, with hysteresis: a rival must be better by ``margin``."""

    margin: float = 0.02
    place: int = -1

    def choose(self, activity: Mapping[int, float]) -> int:
        """The winner given each place's activity; -1 where none is active. Ties by id."""
        active = {place: value for place, value in activity.items() if value > 0.0}
        if not active:
            self.place = -1
            return -1
        best = min(active, key=lambda place: (-active[place], place))
        if self.place not in active or active[best] > active[self.place] + self.margin:
            self.place = best
        return self.place
