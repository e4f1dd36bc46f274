"""What every building of hallways and gateways is described by."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fpnav.params import Params
from fpnav.sim.plan import THICKNESS_M
from fpnav.sim.world import Gateway, Mark, Point, Route, Space

Range = tuple[float, float]
EAST, NORTH, WEST, SOUTH = 0.0, math.pi / 2, math.pi, -math.pi / 2
NOTICED_M = 0.88
"""A wall in front is noticed when the robot's middle is this near."""

PAST_M = 0.5
"""The centre of a gateway that never closes lies this far past its opening edge."""


class GatewaysParams(Params, frozen=True):
    """Ranges are drawn from once per seed; gateways.toml says what each is for."""

    hall_m: Range
    height_m: Range
    opening_m: Range
    alike_m: float
    depth_m: Range
    gap_m: Range
    room_m: Range
    saturation: float
    posters: float
    doors: float
    people: int
    moved_share: float
    lamps_off: float
    lamp_spread: float
    warmth_spread: float
    speed_mps: float
    closed: tuple[str, ...] = ()
    gateways: int = 7
    alike: int = 3


@dataclass(frozen=True, slots=True)
class Layout:
    """A building: its spaces, its gateways as each route meets them, the ways of the routes."""

    spaces: tuple[Space, ...]
    gateways: tuple[Gateway, ...]
    ways: dict[str, list[Point]]
    wide: float

    def routes(self, speed_mps: float) -> dict[str, Route]:
        """The routes, each following the walls of its hallways."""
        return {name: self._route(name, speed_mps) for name in self.ways}

    def _route(self, name: str, speed_mps: float) -> Route:
        own = [gateway for gateway in self.gateways if gateway.route == name]
        return Route(
            name,
            tuple(self.ways[name]),
            speed_mps=speed_mps,
            step_m=0.05,
            lookahead_m=0.25,
            half_width_m=(self.wide - THICKNESS_M) / 2,
            stops=tuple(gateway.name for gateway in own),
            marks=tuple(Mark(g.name, g.x_m, g.y_m, 0.45) for g in own),
        )


def past_middle(wide: float) -> float:
    """How far past the middle of a crossing hallway the robot goes before it turns there."""
    return max(0.0, wide / 2 - THICKNESS_M / 2 - NOTICED_M)
