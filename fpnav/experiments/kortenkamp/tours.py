"""The drives every experiment is made of: guided traversals of routes, and what they met."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np

from fpnav.errors import TruthError
from fpnav.evaluation.gateways import Gateways, Survey, gateways_met, surveyed
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.geometry import compose
from fpnav.params import Tables
from fpnav.sim.plan import THICKNESS_M
from fpnav.sim.record import Job, world_of
from fpnav.sim.truth import world_facts
from fpnav.systems.gateway.types import NAMES
from fpnav.values import Pose2, Signature

ROUTES = ("route-1", "route-2", "route-3")
TRAINING, TEST = (1, 2, 3, 4, 5), 6
"""Runs: each route is driven five times with a guide, once more to test."""

FEW = 2
"""Guided traversals of a small reproduction."""

NEAR: Tables = {"capture": {"images_near_m": 0.15, "images_every": 2}}
"""Pictures are rendered only near gateways, every ten centimetres: the robot looks where it
stops."""


OPEN_ENDED = ("LEFT ROOM", "RIGHT ROOM", "BOTH ROOM")


@dataclass(frozen=True, slots=True, eq=False)
class Traversal:
    """One drive: its signatures, and which gateway of the route each of them is."""

    route: str
    number: int
    run: Run
    survey: Survey

    def guided(self) -> Iterator[tuple[int, Signature]]:
        """What a guide tells: the number along the route of every gateway that is one."""
        for row, partner in enumerate(self.survey.partner.tolist()):
            if partner >= 0:
                yield partner, self.run.table[row]


def choice(preset: str = "paper", **changes: Any) -> SystemChoice:
    """The system with a preset's parameters and changes to them."""
    return SystemChoice("gateway", preset, {"gateway": changes})


def job(seed: int, route: str, run: int, tables: Tables = NEAR, world: str = "gateways") -> Job:
    """One traversal with both cameras and the sonar ring."""
    return job_of(world, route, seed, run, tables=tables)


def traversals(
    shop: Workshop,
    seed: int,
    chosen: SystemChoice,
    routes: Sequence[str] = ROUTES,
    runs: Sequence[int] = (*TRAINING, TEST),
    tables: Tables = NEAR,
) -> list[Traversal]:
    """Traversals of some routes in one world; fewer guided ones in a small reproduction."""
    kept = [run for run in runs if run == TEST or not shop.small or run <= FEW]
    drives = [(route, run) for route in routes for run in kept]
    made = shop.runs([job(seed, route, run, tables) for route, run in drives], chosen)
    return [
        Traversal(route, number, run, survey_of(run, route))
        for (route, number), run in zip(drives, made, strict=True)
    ]


def survey_of(run: Run, route: str) -> Survey:
    """The gateways a run found, against those its route meets."""
    return surveyed(found_in(run), edged(gateways_met(run.header["worlds"][0], route)))


def edged(met: Gateways) -> Gateways:
    """Gateways that never close counted from the edge of their wall, which sonar meets, instead of
    from its middle line, which the world's plan is drawn by."""
    poses = met.poses.copy()
    open_ended = np.array([kind in OPEN_ENDED for kind in met.types], dtype=bool)
    heading = poses[open_ended, 2]
    ahead = np.column_stack([np.cos(heading), np.sin(heading)])
    poses[open_ended, :2] += 0.5 * THICKNESS_M * ahead
    return replace(met, poses=poses)


def found_in(run: Run) -> Gateways:
    """The gateways of a run's signatures, in the frame of truth."""
    placed = [_centre(signature) for signature in run.table]
    poses = [(pose.x_m, pose.y_m, pose.heading_rad) for pose in placed]
    types = tuple(NAMES[int(code)] for code in run.table.records["type"])
    return Gateways(np.array(poses, dtype=np.float64).reshape(-1, 3), types, ("",) * len(types))


def _centre(signature: Signature) -> Pose2:
    record, truth = signature.record, signature.reference.truth
    if truth is None:
        raise TruthError("gateways are placed by the true pose of the robot; the log has none")
    seen = Pose2(float(record["x_m"]), float(record["y_m"]), float(record["axis_rad"]))
    return compose(truth, seen)


def world_of_job(job: Job) -> dict[str, Any]:
    """``world.json`` of a run, whether it was recorded or not."""
    facts: dict[str, Any] = msgspec.to_builtins(
        world_facts(world_of(job.setting), job.route), enc_hook=float
    )
    return facts
