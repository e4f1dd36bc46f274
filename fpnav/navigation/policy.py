"""A robot that goes where the place it recognises tells it to (PerAc)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from fpnav.geometry import wrap
from fpnav.navigation.actions import Actions, Winner
from fpnav.navigation.base import HALT, Command
from fpnav.navigation.field import heading_of
from fpnav.navigation.obstacles import obstacles_of
from fpnav.navigation.steering import SteeringParams, steer_to
from fpnav.systems.base import Features, Memory, Recall, System, Trace
from fpnav.values import Frame, Reference, Signature

WINDOW = 36
"""Frames kept to assemble the newest signature from."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What one frame led to: winner (-1 none), its activity, bearing wanted (NaN none)."""

    place: int
    activity: float
    wanted_rad: float
    agreement: float = 1.0


class PlaceAction:
    """Policy: recognise a place, go in the direction attached to it, around what is in the way.

    While no place is recognised the last direction is kept by odometry for a while. Obstacles and
    direction are merged by a dynamic neural field; without obstacles the field is not asked.
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
            self._decide(signature)
        return self._steered(frame)

    def _signature(self, frame: Frame) -> Signature | None:
        """The signature that ends with this frame, if one does."""
        self._seen.append((frame.reference, self._system.describe(frame)))
        last = None
        for signature in self._system.assemble(iter(self._seen)):
            last = signature
        return last if last is not None and last.reference == frame.reference else None

    def _decide(self, signature: Signature) -> None:
        places = len(self._memory.places)
        recall, self._trace = self._memory.recall([signature], places, None, self._trace)
        activity = {
            int(place): float(score)
            for place, score in zip(recall.places[0], recall.scores[0], strict=True)
            if place >= 0 and np.isfinite(score)
        }
        place = self._winner.choose(activity)
        wanted = math.nan
        if place in self._actions:
            turn = float(recall.headings_rad[0][recall.places[0] == place][0])
            wanted = wrap(self._actions[place] - turn)
        agreed = self._agreement(recall)
        self.decision = Decision(place, activity.get(place, 0.0), wanted, agreed)
        self._remember(signature.reference, wanted)

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
        arrived = self.decision.place >= 0 and self.decision.place not in self._actions
        if self._course is None or arrived:
            return HALT
        wanted = wrap(self._course - _heading(frame.reference))
        obstacles = obstacles_of(frame, self._params.reach_m, self._params.touch_m)
        if not obstacles:
            return steer_to(wanted, self._params, clear=self.decision.agreement)
        way = heading_of(wanted, obstacles)
        if way is None:
            return Command(0.0, math.copysign(self._params.turn_radps / 2.0, wanted))
        ahead = [close for bearing, close in obstacles if math.cos(bearing) > 0.7]
        return steer_to(way, self._params, clear=1.0 - 0.8 * max(ahead, default=0.0))


def _heading(reference: Reference) -> float:
    """Heading by odometry, which a course is kept by; without it the course is the robot's own."""
    return 0.0 if reference.odometry is None else reference.odometry.heading_rad
