"""Passages met while driving along walls: the replay of Kortenkamp and Weymouth's gateway
detector (systems.md 3.3), one step at a time.

Each side opens, and closes where the wall goes on (E), at a blockage ahead (B), where the robot
turns (T), or after some travel (N). Openings of both sides that go together are one passage.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from fpnav.geometry import compose, wrap
from fpnav.sensing.front import Front
from fpnav.sensing.openings import Change, Side
from fpnav.sensing.passages import (
    Opening,
    Passage,
    Rule,
    centre_of,
    exit_beside,
    grouped,
    state_of,
    width_of,
)
from fpnav.sensing.path import Path
from fpnav.sensing.pseudo_sonar import Sides
from fpnav.sensing.rooms import Exit, Pinch, Room, Shape
from fpnav.sensing.walls import LEFT, RIGHT, Wall, wall_direction
from fpnav.values import Pose2

TRAIL_M = 5.0
"""Steps remembered beyond the longest opening."""

ENTRY_M = 1.5
"""Travel past a passage within which the robot still turns into it."""


@dataclass(frozen=True, slots=True)
class _Step:
    row: int
    at_m: float
    pose: Pose2


class Hallway:
    """Finds the passages of a drive."""

    def __init__(self, rule: Rule, change: Callable[[], Change]) -> None:
        self.path = Path(rule.turn_rad, rule.settle)
        self.sides = {
            side: Side(Wall(side, rule.window, rule.axis, rule.far), change(), rule.keep)
            for side in (LEFT, RIGHT)
        }
        self.room = Room(rule.room, rule.hall)
        self._rule = rule
        self._leg = self._bends = 0
        self._half_beam = 0.0
        self._aligned_m = math.nan
        self._front, self._front_turn = Front(), Front()
        self._ended = False
        self._began_m = {LEFT: math.nan, RIGHT: math.nan}
        self._behind_m = {LEFT: math.nan, RIGHT: math.nan}
        self._pending: list[Opening] = []
        self._trail: deque[_Step] = deque()
        self._last: Passage | None = None

    def step(self, row: int, pose: Pose2, seen: Sides) -> list[Passage]:
        """Passages that became certain with one more step; ``row`` names it."""
        straight = self.path.straight
        self.path.move(pose)
        self._half_beam = math.tan(seen.beam_rad / 2.0)
        if not self.path.straight:
            return self._turned() if straight else []
        if self.path.leg != self._leg:
            self._begin()
        if self.path.bends != self._bends:
            self._bends = self.path.bends
            for side in self.sides.values():
                side.wall.bend()
        self._remember(row, pose)
        if not self.path.advancing:
            return []
        at = self.path.at_m
        if abs(wrap(pose.heading_rad - self._axis())) <= self._rule.aligned_rad:
            self._aligned_m = at
            self._front_turn.see(at, seen.ahead_m)
        pinch = self.room.through(at, seen.left_m, seen.right_m)
        if pinch is not None or self.room.pinched:
            return [] if pinch is None else [self._ahead(pinch)]
        self._watch(at, seen)
        self._front.see(at, seen.front_m)
        front = self._front.wall_m
        ends = self._blocked(front) if front - at < self._rule.front else []
        return self._settled() + ends

    def finish(self) -> list[Passage]:
        """Passages that are certain though the drive ends; what is open is given up."""
        self._lose()
        return self._settled()

    @property
    def axis_rad(self) -> float:
        """Direction of the walls; that of the leg where they do not tell, NaN before the first."""
        return self._axis()

    def _begin(self) -> None:
        self._leg, self._ended, self._aligned_m = self.path.leg, False, math.nan
        self._front.forget()
        self._front_turn.forget()
        self._trail.clear()
        self.room.leg()
        for side in self.sides.values():
            side.lose()
            side.wall.turn()

    def _lose(self) -> None:
        for side in self.sides.values():
            side.lose()

    def _remember(self, row: int, pose: Pose2) -> None:
        self._trail.append(_Step(row, self.path.at_m, pose))
        while self.path.at_m - self._trail[0].at_m > self._rule.limit + TRAIL_M:
            self._trail.popleft()

    def _watch(self, at: float, seen: Sides) -> None:
        """Readings of both sides: openings that end where the wall goes on, or are given up."""
        for key, range_m in ((LEFT, seen.left_m), (RIGHT, seen.right_m)):
            side = self.sides[key]
            hidden = side.hidden_m(self._half_beam, seen.apex_m)
            edge = side.update(at, self.path.lateral_m, range_m)
            if edge is not None and edge.opens:
                self._began_m[key] = edge.at_m - hidden
                self._behind_m[key] = at - seen.behind_m
                side.wall.ends(edge.at_m - hidden)
            elif edge is not None:
                self._add(key, edge.at_m + hidden, "E", at + seen.ahead_m)
                side.wall.begins(edge.at_m + hidden)
            elif side.opened and at - side.opened_m > self._rule.limit:
                self._add(key, math.nan, "N", at + seen.ahead_m)
                side.lose()
        walls = any(side.known for side in self.sides.values())
        self.room.look(at, seen.left_m, seen.right_m, walls=walls)

    def _add(self, key: int, ended: float, cause: str, ahead: float) -> None:
        wall, began = self.sides[key].wall_m, self._began_m[key]
        opening = Opening(key, began, ended, cause, wall, (self._behind_m[key], ahead))
        if not opening.width_m < self._rule.least:
            self._pending.append(opening)

    def _close(self, cause: str, ended: Callable[[float], float], ahead: float) -> None:
        """End every opening there is; ``ended`` says where, from where it began."""
        for key, side in self.sides.items():
            if side.opened:
                self._add(key, ended(self._began_m[key]), cause, ahead)
                side.lose()

    def _blocked(self, front: float) -> list[Passage]:
        """The way ahead ends, and so do openings; without any it is a dead end."""
        walled = all(side.known and not side.opened for side in self.sides.values())
        self._close("B", lambda began: front, front)
        dead = walled and not self._ended and not self._pending and not self.room.on
        self._ended = True
        return [self._passage([], front - self._rule.front, None, blocked=True)] if dead else []

    def _turned(self) -> list[Passage]:
        """The leg ends before a wall, or in the middle of what is open."""
        at = self.path.at_m if math.isnan(self._aligned_m) else self._aligned_m
        front = self._front_turn.wall_m
        ends = self._blocked(front) if front - at <= self._rule.front_turn else []
        self._close("T", lambda began: 2.0 * at - began, math.nan)
        found = self._settled() + ends
        self._go_in_or_out(at)
        return found

    def _go_in_or_out(self, at: float) -> None:
        """A turn into an opening that did not close enters a room, one into an exit leaves it."""
        last, left = self._last, self.path.turned_rad > 0.0
        if last is None or abs(at - last.at_m) > self._rule.limit + ENTRY_M:
            return
        if last.exit is None and (last.left if left else last.right) == "N":
            self.room.enter()
        elif last.exit is not None and last.exit.where == ("LEFT" if left else "RIGHT"):
            self.room.leave()

    def _settled(self) -> list[Passage]:
        """Openings that no other can still join, as passages."""
        latest = max((o.end_m(self._rule.limit) for o in self._pending), default=math.nan)
        if any(side.opened and self._began_m[key] < latest for key, side in self.sides.items()):
            return []
        groups, self._pending = grouped(self._pending, self._rule), []
        return [self._of_group(group) for group in groups]

    def _of_group(self, group: Sequence[Opening]) -> Passage:
        way_out = exit_beside(group[0], self._rule) if self.room.on else None
        blocked = any(opening.cause == "B" for opening in group)
        return self._passage(group, centre_of(group, self._rule), way_out, blocked=blocked)

    def _ahead(self, pinch: Pinch) -> Passage:
        """The exit ahead that was driven through."""
        self._pending.clear()
        self._lose()
        wide, corner = pinch.width_m > self._rule.wide, pinch.corner_m < self._rule.corner
        shape: Shape = "WIDE" if wide else "CORNER" if corner else "MID"
        middle = Opening(LEFT, pinch.open_m, pinch.close_m, "E").centre_m(self._rule.past)
        return replace(
            self._passage([], middle, Exit("FRONT", shape), blocked=False), width_m=pinch.width_m
        )

    def _passage(
        self, group: Sequence[Opening], at: float, way_out: Exit | None, *, blocked: bool
    ) -> Passage:
        axis = self._axis()
        near = self._nearest(at, axis)
        centre = compose(Pose2(near.pose.x_m, near.pose.y_m, axis), Pose2(at - near.at_m, 0.0, 0.0))
        walls = {side: self.sides[side].wall_m for side in (LEFT, RIGHT)}
        walls |= {opening.side: opening.wall_m for opening in group}
        self._last = Passage(
            state_of(group, LEFT),
            state_of(group, RIGHT),
            blocked,
            way_out,
            at,
            width_of(group),
            centre,
            near.row,
            walls[LEFT],
            walls[RIGHT],
        )
        return self._last

    def _axis(self) -> float:
        """Direction of the walls; that of the leg where they do not tell."""
        walls = [side.wall.points() for side in self.sides.values()]
        turn = wall_direction(walls, least_m=0.5, noise_m=self._rule.noise)
        return wrap(self.path.axis_rad + (0.0 if math.isnan(turn) else turn))

    def _nearest(self, at: float, axis: float) -> _Step:
        """Step nearest to a place along the path, of those headed along the axis if any is."""
        along = [
            step
            for step in self._trail
            if abs(wrap(step.pose.heading_rad - axis)) <= self._rule.aligned_rad
        ]
        return min(along or self._trail, key=lambda step: (abs(step.at_m - at), step.row))
