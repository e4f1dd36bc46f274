"""A map, a system and a policy made ready for a task; and the policy asked on a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.execution.walk import SystemChoice
from fpnav.navigation.actions import place_named
from fpnav.navigation.base import Policy, Task
from fpnav.navigation.registry import policy_maker
from fpnav.params import Tables
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import ACTION, SignatureTable
from fpnav.systems.base import System


@dataclass(frozen=True, slots=True, eq=False)
class Guide:
    """Who is to lead where: ``goal`` names a place of the map, without one the route is taken."""

    header: Header
    built: BuiltMap
    system: System
    preset: str
    policy: str
    tables: Tables
    goal: str | None = None
    route: str = ""

    @property
    def choice(self) -> SystemChoice:
        """The system as the map has it, for the logs of the trips."""
        params = msgspec.to_builtins(self.system.params)
        return SystemChoice(self.system.NAME, self.preset, {self.system.NAME: params})

    def make_policy(self) -> Policy:
        """A fresh policy for the task."""
        task = Task(self.goal, self.route)
        return policy_maker(self.policy)(self.system, self.built, task, self.tables)

    def facts(self, *, driven: bool) -> dict[str, Any]:
        """What the protocol says of the task.

        Raises
        ------
        UsageError
            Nothing tells where in the world the goal is.
        """
        task: dict[str, Any] = {"policy": self.policy, "driven": driven}
        if self.goal is None:
            return {**task, "route": self.route}
        place = self.built.topomap.place(place_named(self.built.topomap, self.goal))
        truth = self.built.signatures.references["truth"][place.members[0]]
        if not np.isfinite(truth).all():
            raise UsageError(f"--goal {self.goal}: the map has no true pose to measure it by")
        return {**task, "goal": self.goal, "goal_m": [float(truth[0]), float(truth[1])]}


def asked_on_log(policy: Policy, table: SignatureTable) -> NDArray[Any]:
    """Decision of a policy at each signature of a run, (A,) ACTION; each session is a trip."""
    rows = np.zeros(len(table), ACTION)
    rows["trip"], rows["stamp_ns"] = table.references["session"], table.references["stamp_ns"]
    rows["truth"] = table.references["truth"]
    for row, signature in enumerate(table):
        decision = policy.decide(signature)
        rows["place"][row], rows["activity"][row] = decision.place, decision.activity
        rows["wanted_rad"][row] = decision.wanted_rad
    return rows
