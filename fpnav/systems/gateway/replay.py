"""From features in travel order to signatures: a scene at every gateway."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import relative, wrap
from fpnav.sensing.cues import CUE
from fpnav.sensing.hallway import Hallway
from fpnav.sensing.openings import Change, Evidence, Threshold
from fpnav.sensing.passages import Passage, Rule
from fpnav.systems.base import Features
from fpnav.systems.gateway.look import NOT_LOOKED, sides_of
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.record import record_of
from fpnav.systems.gateway.types import NONE, code_of
from fpnav.values import ORIGIN, Pose2, Reference, Signature

PICTURE_M = 1.0
"""A picture taken farther than this from the gateway's centre is not one of it."""

KEPT = 400
"""Frames remembered: the longest opening, and what may lie before it, at 2 cm a frame."""


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    row: int
    reference: Reference
    pose: Pose2
    facing: int
    cues: NDArray[np.void]


class Replay:
    """The gateways of one session."""

    def __init__(self, params: GatewayParams) -> None:
        self._params = params
        self._hallway = Hallway(rule_of(params), change_of(params))
        self._seen: deque[_Seen] = deque(maxlen=KEPT)
        self._last_row = -1
        self._kept_m = -math.inf
        self._ranged = False

    def step(self, row: int, reference: Reference, features: Features) -> list[Signature]:
        """Signatures that became certain with one more frame."""
        pose = self._pose(reference)
        facing = int(features["facing"][0])
        seen = _Seen(row, reference, pose, facing, features["cues"])
        self._seen.append(seen)
        ranges = sides_of(features["sides"])
        self._ranged = self._ranged or ranges is not None
        if not self._ranged or self._params.keep == "spacing":
            return self._spaced(seen)
        found = [] if ranges is None else self._hallway.step(row, pose, ranges)
        return [made for passage in found for made in self._at(passage)]

    def finish(self) -> list[Signature]:
        """Signatures left when the session ends."""
        return [made for passage in self._hallway.finish() for made in self._at(passage)]

    def _pose(self, reference: Reference) -> Pose2:
        """Odometry, else truth, else straight on at the speed assumed."""
        known = reference.odometry or reference.truth
        if known is not None:
            return known
        last = self._seen[-1] if self._seen else None
        if last is None:
            return ORIGIN
        seconds = (reference.stamp_ns - last.reference.stamp_ns) / 1e9
        return Pose2(last.pose.x_m + self._params.speed_mps * seconds, 0.0, 0.0)

    def _spaced(self, seen: _Seen) -> list[Signature]:
        """A scene every so much travel; every one where travel is not known."""
        travelled = seen.reference.travelled_m
        if seen.facing == NOT_LOOKED or travelled - self._kept_m < self._params.spacing_m:
            return []
        if not math.isnan(travelled):
            self._kept_m = travelled
        record = record_of(NONE, 1 << seen.facing, None, ORIGIN)
        return [Signature(seen.reference, record, {"cues": seen.cues})]

    def _at(self, passage: Passage) -> list[Signature]:
        """Signature of a passage, at the frame nearest to its centre; none before the last one."""
        later = [seen for seen in self._seen if seen.row > self._last_row]
        if not later:
            return []
        here = min(later, key=lambda seen: (abs(seen.row - passage.row), seen.row))
        self._last_row = here.row
        views = self._views(passage)
        facings = sum(1 << facing for facing in views)
        cues = np.concatenate([np.zeros(0, CUE), *(view.cues for view in views.values())])
        centre = relative(here.pose, passage.centre)
        record = record_of(code_of(passage), facings, passage, centre)
        return [Signature(here.reference, record, {"cues": cues})]

    def _views(self, passage: Passage) -> dict[int, _Seen]:
        """By direction, the picture taken nearest to the centre of those along the walls."""
        best: dict[int, tuple[float, _Seen]] = {}
        limit = math.radians(self._params.aligned_deg)
        for seen in self._seen:
            away = _away(seen.pose, passage.centre)
            turned = abs(wrap(seen.pose.heading_rad - passage.centre.heading_rad))
            if seen.facing == NOT_LOOKED or away > PICTURE_M or turned > limit:
                continue
            if seen.facing not in best or away < best[seen.facing][0]:
                best[seen.facing] = (away, seen)
        return {facing: best[facing][1] for facing in sorted(best)}


def signatures_of(
    stream: Iterable[tuple[Reference, Features]], params: GatewayParams
) -> Iterator[Signature]:
    """Signatures of a stream of described frames; every session begins anew."""
    replay, session = Replay(params), -1
    for row, (reference, features) in enumerate(stream):
        if session not in (-1, reference.session):
            yield from replay.finish()
            replay = Replay(params)
        session = reference.session
        yield from replay.step(row, reference, features)
    yield from replay.finish()


def rule_of(params: GatewayParams) -> Rule:
    """Distances of the detector."""
    return Rule(
        window=params.window_m,
        axis=params.axis_m,
        far=params.far_m,
        keep=params.open_rise_m,
        front=params.front_m,
        front_turn=params.front_turn_m,
        limit=params.limit_m,
        past=params.past_m,
        least=params.least_m,
        together=params.together_m,
        room=params.room_m,
        hall=params.hall_m,
        corner=params.corner_m,
        wide=params.wide_m,
        settle=params.settle_m,
        turn_rad=math.radians(params.turn_deg),
        noise=params.evidence_noise_m,
        aligned_rad=math.radians(params.aligned_deg),
    )


def change_of(params: GatewayParams) -> Callable[[], Change]:
    """Maker of the test that decides when a side opens and closes."""
    if params.detector == "evidence":
        return lambda: Evidence(
            params.evidence_rise_m, params.evidence_noise_m, params.evidence_limit
        )
    return lambda: Threshold(params.open_rise_m, params.close_rise_m, params.readings)


def _away(pose: Pose2, centre: Pose2) -> float:
    """Distance along the walls from the centre of a gateway."""
    return abs(relative(centre, pose).x_m)
