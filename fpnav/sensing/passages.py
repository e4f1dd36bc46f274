"""Openings along a path, and which of them are one passage (systems.md 3.3)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fpnav.sensing.rooms import Exit, Shape
from fpnav.sensing.walls import LEFT
from fpnav.values import Pose2


@dataclass(frozen=True, slots=True)
class Rule:
    """Distances of the detector in metres; defaults are those of systems.md 3.3.

    window, axis : travel over which a wall's distance is the median and its direction is fitted
    far : farther than that is no wall; keep : a reading that much beyond it still belongs to it
    front, front_turn : nearer ahead is blocked, twice in a row or where the robot turns away
    limit : an opening longer than that does not close; past : its centre lies that far into it
    least : passable width; together : openings that start so near each other are one
    room : both sides farther is a room; hall : both together nearer is a corridor again
    corner, wide : exits so near a corner, so wide
    settle, turn_rad : straight travel that begins a leg, and the turn that ends it
    noise : of a reading; aligned_rad : a robot so well along the walls may take a picture
    """

    window: float = 1.5
    axis: float = 1.5
    far: float = 2.5
    keep: float = 0.5
    front: float = 0.8
    front_turn: float = 1.6
    limit: float = 3.0
    past: float = 0.5
    least: float = 0.85
    together: float = 0.5
    room: float = 2.5
    hall: float = 2.6
    corner: float = 0.8
    wide: float = 2.0
    settle: float = 0.3
    turn_rad: float = math.radians(25.0)
    noise: float = 0.05
    aligned_rad: float = math.radians(5.0)


@dataclass(frozen=True, slots=True)
class Opening:
    """Opening of one side between two places along the path, the beam's width allowed for.

    ``cause`` it ended by: E the wall went on, B the way was blocked, T the robot turned in its
    middle, N it was given up (``close_m`` NaN). ``wall_m`` : distance of the wall before it;
    ``corners_m`` : where walls across the path were
    seen, behind where it began and ahead where it ended.
    """

    side: int
    open_m: float
    close_m: float
    cause: str
    wall_m: float = math.nan
    corners_m: tuple[float, float] = (math.nan, math.nan)

    @property
    def width_m(self) -> float:
        """Width, NaN where it was given up."""
        return self.close_m - self.open_m

    @property
    def state(self) -> str:
        """O (it ends), N (it does not), B (at a blockage)."""
        return {"E": "O", "T": "O", "N": "N", "B": "B"}[self.cause]

    def centre_m(self, past_m: float) -> float:
        """Middle, or ``past_m`` into one that was given up."""
        if math.isnan(self.close_m):
            return self.open_m + past_m
        return (self.open_m + self.close_m) / 2.0

    def end_m(self, limit_m: float) -> float:
        """Where it ends, or was given up."""
        return self.open_m + limit_m if math.isnan(self.close_m) else self.close_m


@dataclass(frozen=True, slots=True)
class Passage:
    """What was found at one place.

    ``left``, ``right`` : W (wall), O, N, B; ``exit`` : set where it leads out of a room
    ``centre`` : pose of the middle, heading along the walls, in the frame the poses are given in
    ``row`` : the step nearest to it among those headed along the walls
    ``width_m`` : NaN where nothing closed; ``wall_left_m``, ``wall_right_m`` : NaN where none
    """

    left: str
    right: str
    blocked: bool
    exit: Exit | None
    at_m: float
    width_m: float
    centre: Pose2
    row: int
    wall_left_m: float
    wall_right_m: float


def grouped(openings: Sequence[Opening], rule: Rule) -> list[list[Opening]]:
    """Openings that are one passage: of different sides, and they overlap by half of the shorter
    or start near each other. Groups in the order they start."""
    rest = sorted(openings, key=lambda opening: (opening.open_m, -opening.side))
    groups: list[list[Opening]] = []
    for opening in rest:
        last = groups[-1] if groups else []
        if len(last) == 1 and last[0].side != opening.side and _one(last[0], opening, rule):
            last.append(opening)
        else:
            groups.append([opening])
    return groups


def _one(first: Opening, second: Opening, rule: Rule) -> bool:
    if abs(first.open_m - second.open_m) <= rule.together:
        return True
    ends = first.end_m(rule.limit), second.end_m(rule.limit)
    overlap = min(ends) - max(first.open_m, second.open_m)
    return overlap >= 0.5 * min(ends[0] - first.open_m, ends[1] - second.open_m)


def state_of(group: Sequence[Opening], side: int) -> str:
    """State of one side of a passage; W where it has no opening."""
    return next((opening.state for opening in group if opening.side == side), "W")


def centre_of(group: Sequence[Opening], rule: Rule) -> float:
    """Mean of the openings' middles; one that was given up counts where none closed."""
    closed = [opening for opening in group if not math.isnan(opening.close_m)]
    middles = [opening.centre_m(rule.past) for opening in closed or group]
    return sum(middles) / len(middles)


def width_of(group: Sequence[Opening]) -> float:
    """Width of the widest opening that closed; NaN where none did."""
    widths = [o.width_m for o in group if not math.isnan(o.width_m)]
    return max(widths, default=math.nan)


def exit_beside(opening: Opening, rule: Rule) -> Exit:
    """Exit that an opening in the wall of a room is."""
    behind, ahead = opening.corners_m
    gaps = opening.open_m - behind, ahead - opening.end_m(rule.limit)
    wide = opening.end_m(rule.limit) - opening.open_m > rule.wide
    # A robot that the corner stops does not see how wide the exit is.
    corner = opening.cause == "B" or (not wide and any(gap < rule.corner for gap in gaps))
    shape: Shape = "CORNER" if corner else "WIDE" if wide else "MID"
    return Exit("LEFT" if opening.side == LEFT else "RIGHT", shape)
