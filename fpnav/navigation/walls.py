"""A robot that follows walls by sonar and stops in the middle of every gateway it meets.

Kortenkamp and Weymouth: it aligns itself with the walls, keeps its distance, goes on where a side
opens until it closes, and then "positions itself in the middle of the gateway". Where the way
ahead is blocked it turns into what is open, left before right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fpnav.geometry import relative, wrap
from fpnav.navigation.base import HALT, Command, Decision, Task
from fpnav.params import Params, Tables, resolve
from fpnav.sensing.hallway import Hallway
from fpnav.sensing.openings import Evidence
from fpnav.sensing.passages import Passage, Rule
from fpnav.sensing.pseudo_sonar import Sides, ring_from_scan, sides
from fpnav.sensing.walls import LEFT, RIGHT
from fpnav.store.maps import BuiltMap
from fpnav.systems.base import System
from fpnav.values import ORIGIN, Frame, Pose2, Reference, Signature

NOWHERE = Decision(-1, 0.0, math.nan)


class WallParams(Params, frozen=True):
    """Block ``walls``.

    speed_mps : along walls; creep_mps : at least, on the way to a gateway's middle
    there_m : so near it the robot has reached it; still : decisions it stands there
    sideways : radians the robot turns for a metre it is off the middle, at most ``tilt_deg``
    settle_s : time in which a heading error would be turned away; turn_radps : at most
    side_deg, cone_deg : as in the gateway system
    """

    speed_mps: float = 0.3
    creep_mps: float = 0.04
    there_m: float = 0.015
    still: int = 4
    sideways: float = 0.7
    tilt_deg: float = 12.0
    settle_s: float = 0.6
    turn_radps: float = 0.8
    side_deg: float = 5.0
    cone_deg: float = 30.0


@dataclass(frozen=True, slots=True)
class Stop:
    """Where the robot stood in the middle of a gateway, by its frame, and what it is."""

    reference: Reference
    passage: Passage


class WallFollowing:
    """Policy: follow walls, stop in gateways, turn where the way is blocked."""

    def __init__(self, params: WallParams, rule: Rule) -> None:
        self._params = params
        self._hallway = Hallway(rule, lambda: Evidence(0.25, rule.noise, 5.0))
        self._row = 0
        self._course = math.nan
        self._half_m = math.nan
        self._target: Passage | None = None
        self._standing = 0
        self.stops: list[Stop] = []
        self.done = False
        self.decision = NOWHERE

    def decide(self, signature: Signature) -> Decision:
        """The last decision: signatures do not steer this robot."""
        return self.decision

    def act(self, frame: Frame) -> Command:
        """The command for what is seen now."""
        pose = frame.reference.odometry or ORIGIN
        seen = self._sides(frame)
        if seen is None or self.done:
            return HALT
        found = self._hallway.step(self._row, pose, seen)
        self._row += 1
        if self._target is None and found:
            self._target = found[-1]
        if self._target is not None:
            return self._approach(frame.reference, pose, self._target)
        return self._follow(pose, seen)

    def _sides(self, frame: Frame) -> Sides | None:
        ring = frame.sonar
        if ring is None and frame.scan is not None:
            ring = ring_from_scan(
                frame.scan, count=24, cone_rad=math.radians(self._params.cone_deg)
            )
        return None if ring is None else sides(ring, math.radians(self._params.side_deg))

    def _approach(self, reference: Reference, pose: Pose2, target: Passage) -> Command:
        """To the middle of a gateway, back or on; there the robot stands, then goes on."""
        left = relative(target.centre, pose).x_m
        error = wrap(target.centre.heading_rad - pose.heading_rad)
        self.decision = Decision(-1, 0.0, error, arrived=self._standing > 0)
        if self._standing == 0 and abs(left) > self._params.there_m:
            speed = max(self._params.creep_mps, min(self._params.speed_mps, 0.8 * abs(left)))
            return Command(-math.copysign(speed, left), self._turn(error))
        if self._standing == 0:
            self.stops.append(Stop(reference, target))
        self._standing += 1
        if self._standing > self._params.still:
            self._standing, self._target = 0, None
            self._leave(target)
        return HALT

    def _leave(self, target: Passage) -> None:
        """Which way to go on: ahead, or where it is open beside a blockage."""
        self._course = target.centre.heading_rad
        if target.blocked:
            way = {"left": math.pi / 2, "right": -math.pi / 2}
            open_sides = [name for name in way if getattr(target, name) != "W"]
            self.done = not open_sides
            self._course = wrap(self._course + (way[open_sides[0]] if open_sides else 0.0))

    def _follow(self, pose: Pose2, seen: Sides) -> Command:
        """Along the walls, in their middle, or as far from one of them as that was."""
        if math.isnan(self._course):
            self._course = pose.heading_rad
        axis = self._hallway.axis_rad if self._hallway.path.straight else math.nan
        if not math.isnan(axis) and abs(wrap(axis - self._course)) < math.radians(20.0):
            self._course = axis
        limit = math.radians(self._params.tilt_deg)
        tilt = max(-limit, min(limit, self._params.sideways * self._aside(seen)))
        error = wrap(self._course + tilt - pose.heading_rad)
        self.decision = Decision(-1, 0.0, error)
        if abs(error) > math.radians(30.0):
            return Command(0.0, self._turn(error))
        return Command(self._params.speed_mps * math.cos(error), self._turn(error))

    def _aside(self, seen: Sides) -> float:
        """How far the middle lies to the left, by the walls beside the robot; 0 unknown."""
        left, right = (self._wall(LEFT, seen.left_m), self._wall(RIGHT, seen.right_m))
        if not math.isnan(left + right):
            self._half_m = 0.5 * (left + right)
            return 0.5 * (left - right)
        if not math.isnan(left) and not math.isnan(self._half_m):
            return left - self._half_m
        if not math.isnan(right) and not math.isnan(self._half_m):
            return self._half_m - right
        return 0.0

    def _wall(self, key: int, range_m: float) -> float:
        """Distance of a wall beside the robot, NaN where that side is open."""
        side = self._hallway.sides[key]
        near = side.known and not side.opened and abs(range_m - side.wall_m) < 0.25
        return range_m if near else math.nan

    def _turn(self, error_rad: float) -> float:
        most = self._params.turn_radps
        return max(-most, min(most, error_rad / self._params.settle_s))


def wall_following(system: System, built: BuiltMap, task: Task, tables: Tables) -> WallFollowing:
    """The policy for any map: it goes where the walls lead."""
    return WallFollowing(resolve("walls", WallParams(), tables), Rule())
