"""A robot that goes where the place it recognises tells it to (PerAc)."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np
from msgspec import structs

from fpnav.geometry import wrap
from fpnav.navigation.actions import Actions, Winner, actions_for
from fpnav.navigation.base import HALT, Command, Decision, Task
from fpnav.navigation.field import heading_of
from fpnav.navigation.obstacles import grazing, obstacles_of
from fpnav.navigation.steering import SteeringParams, steer_to
from fpnav.params import Tables, resolve
from fpnav.store.maps import BuiltMap
from fpnav.systems.base import Features, Memory, Recall, System, Trace
from fpnav.values import Frame, Reference, Signature

WINDOW = 36
"""Frames kept to assemble the newest signature from."""

PASSING = 0.5
"""Proximity at which the robot goes along what blocks its way."""


class PlaceAction:
    """Policy: recognise a place, go in the direction attached to it, around what is in the way.

    A place without a direction is where the task ends; the robot halts where that place is clearly
    more active than any other. While no place is recognised the last direction is kept by odometry
    for a while. Obstacles and direction are merged by a dynamic neural field; without obstacles the
    field is not asked. Where it finds no way the robot goes along what is in the way, on the side
    it faces, and in any case it leaves what it touches.
    """

    def __init__(
        self, system: System, memory: Memory, actions: Actions, params: SteeringParams
    ) -> None:
        self._system, self._memory = system, memory
        self._actions, self._params = actions, params
        self._winner = Winner(params.margin)
        self._seen: deque[tuple[Reference, Features]] = deque(maxlen=WINDOW)
        self._trace: Trace = None
        self._course: float | None = None
        self._lost = 0
        self.decision = Decision(-1, 0.0, math.nan)

    def act(self, frame: Frame) -> Command:
        """The command for what is seen now."""
        signature = self._signature(frame)
        if signature is not None:
            self.decide(signature)
        return self._steered(frame)

    def _signature(self, frame: Frame) -> Signature | None:
        """The signature that ends with this frame, if one does."""
        self._seen.append((frame.reference, self._system.describe(frame)))
        last = None
        for signature in self._system.assemble(iter(self._seen)):
            last = signature
        return last if last is not None and last.reference == frame.reference else None

    def decide(self, signature: Signature) -> Decision:
        """The decision that one more signature leads to."""
        places = len(self._memory.places)
        recall, self._trace = self._memory.recall([signature], places, None, self._trace)
        activity = {
            int(place): float(score)
            for place, score in zip(recall.places[0], recall.scores[0], strict=True)
            if place >= 0 and np.isfinite(score)
        }
        place, arrived = self._chosen(activity)
        wanted = math.nan
        if place in self._actions:
            turn = float(recall.headings_rad[0][recall.places[0] == place][0])
            wanted = wrap(self._actions[place] - turn)
        self.decision = Decision(
            place, activity.get(place, 0.0), wanted, self._agreement(recall), arrived
        )
        self._remember(signature.reference, wanted)
        return self.decision

    def _chosen(self, activity: Mapping[int, float]) -> tuple[int, bool]:
        """Winner among the places with a direction; an end, where one is clearly more active."""
        leading = self._winner.choose({k: v for k, v in activity.items() if k in self._actions})
        ends = {k: v for k, v in activity.items() if k not in self._actions and v > 0.0}
        if ends:
            end = min(ends, key=lambda place: (-ends[place], place))
            if ends[end] > self._params.end_ratio * activity.get(leading, 0.0):
                return end, True
        return leading, False

    def _agreement(self, recall: Recall) -> float:
        """Length of the mean direction that all active places tell, sharper ones counting more.

        1 where all agree; near 0 amid places that point at one goal from all around it.
        """
        if self._params.blend == 0.0:
            return 1.0
        x = y = total = 0.0
        best = float(recall.scores[0, 0])
        for place, score, turn in zip(
            recall.places[0], recall.scores[0], recall.headings_rad[0], strict=True
        ):
            if int(place) in self._actions and score > 0.0 and math.isfinite(turn):
                weight = (float(score) / best) ** self._params.blend
                way = self._actions[int(place)] - float(turn)
                x, y, total = x + weight * math.cos(way), y + weight * math.sin(way), total + weight
        return math.hypot(x, y) / total if total > 0.0 else 1.0

    def _remember(self, reference: Reference, wanted_rad: float) -> None:
        if math.isfinite(wanted_rad):
            self._course, self._lost = _heading(reference) + wanted_rad, 0
            return
        self._lost += 1
        if self._lost > self._params.hold:
            self._course = None

    def _steered(self, frame: Frame) -> Command:
        if self._course is None or self.decision.arrived:
            return HALT
        wanted = wrap(self._course - _heading(frame.reference))
        obstacles = obstacles_of(frame, self._params.reach_m, self._params.touch_m)
        if not obstacles:
            return steer_to(wanted, self._params, clear=self.decision.agreement)
        way = heading_of(wanted, obstacles)
        goal, near = (wanted / 2.0, PASSING) if way is None else (way, 1.0)
        way = grazing(goal, obstacles, near)
        if way is None:
            return Command(0.0, math.copysign(self._params.turn_radps / 2.0, wanted))
        ahead = [close for bearing, close in obstacles if math.cos(bearing) > 0.7]
        return steer_to(way, self._params, clear=1.0 - 0.8 * max(ahead, default=0.0))


def place_action(system: System, built: BuiltMap, task: Task, tables: Tables) -> PlaceAction:
    """The policy for a task on a map.

    Raises
    ------
    LogError
        The map's places have no poses to take directions from, or it has no such goal.
    """
    memory = system.memory()
    memory.load(built.memory)
    actions = actions_for(task, built.topomap, built.signatures)
    params = resolve("navigate", SteeringParams(), tables)
    if task.goal is None:
        params = structs.replace(params, blend=0.0)
    return PlaceAction(system, memory, actions, params)


def _heading(reference: Reference) -> float:
    """Heading by odometry, which a course is kept by; without it the course is the robot's own."""
    return 0.0 if reference.odometry is None else reference.odometry.heading_rad
