"""Furnishing of a rectangular room: pieces along its walls, and the lane they leave free."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fpnav.sim.furniture import STANDING, Palette, Piece, hanging
from fpnav.sim.plan import OPEN_KINDS, THICKNESS_M, Opening, Run, belongs
from fpnav.sim.solids import Face, placed
from fpnav.sim.world import Change, Point, Space

CLEARANCE_M = 0.38
"""Least distance kept between the robot's centre and furniture."""

DOOR_SWING_M = 1.1
ENTRY_SIDE_M, ENTRY_DEPTH_M = 1.8, 1.8
"""Side walls nearer than this to a door's middle are kept free for this far from its wall."""
LANE_M = (0.5, 0.5)
"""Least width of a lane along x and along y."""

ADDED_KINDS = ("cartons", "bin", "plant")
DRAB = Palette((0.8, 0.7, 0.6), (0.6, 0.6, 0.6), (0.5, 0.5, 0.45), (0.6, 0.55, 0.5))
"""Colours of what people leave standing about."""


@dataclass(slots=True)
class Furnished:
    """A room being filled: ``inset_m`` per wall (south, east, north, west), pieces placed."""

    space: Space
    taken: list[list[tuple[float, float]]] = field(default_factory=lambda: [[], [], [], []])
    inset_m: list[float] = field(default_factory=lambda: [0.0] * 4)
    placed: list[tuple[Piece, int, float]] = field(default_factory=list)

    def wall_length(self, wall: int) -> float:
        """Free length of a wall between its corners."""
        s = self.space
        return (s.x1 - s.x0 if wall % 2 == 0 else s.y1 - s.y0) - THICKNESS_M

    def lane(self) -> tuple[float, float, float, float]:
        """Rectangle (x0, y0, x1, y1) in which the robot's centre may be anywhere."""
        s, half = self.space, THICKNESS_M / 2 + CLEARANCE_M
        south, east, north, west = self.inset_m
        return s.x0 + half + west, s.y0 + half + south, s.x1 - half - east, s.y1 - half - north

    def faces(self) -> list[Face]:
        """All pieces where they stand."""
        made: list[Face] = []
        for piece, wall, at in self.placed:
            made += lean(piece.faces, self.space, wall, at)
        return made

    def reserve(self, wall: int, at: float, width: float) -> None:
        """Keep a stretch of a wall free."""
        self.taken[wall].append((at - width / 2, at + width / 2))

    def fits(self, wall: int, at: float, piece: Piece, least_lane_m: Point) -> bool:
        """Whether the piece has room on the wall and leaves the lane wide enough."""
        low, high = at - piece.width_m / 2, at + piece.width_m / 2
        left, right = self.inset_m[(wall + 1) % 4], self.inset_m[(wall - 1) % 4]
        if low < min(0.05 + left, 0.9) or high > self.wall_length(wall) - right:
            return False
        if any(low < b + 0.05 and high > a - 0.05 for a, b in self.taken[wall]):
            return False
        across = self.wall_length((wall + 1) % 4) - 2 * CLEARANCE_M - self.inset_m[(wall + 2) % 4]
        return across - max(self.inset_m[wall], piece.depth_m) >= least_lane_m[1 - wall % 2]

    def put(self, wall: int, at: float, piece: Piece) -> None:
        """Place a piece against a wall."""
        self.taken[wall].append((at - piece.width_m / 2, at + piece.width_m / 2))
        self.inset_m[wall] = max(self.inset_m[wall], piece.depth_m)
        self.placed.append((piece, wall, at))


def reserve_openings(
    room: Furnished, runs: Sequence[Run], openings: Sequence[Opening], side_m: float = 0.25
) -> None:
    """Keep the wall free at doors (with their swing) and windows."""
    for hole in openings:
        if room.space.name not in (hole.a, hole.b):
            continue
        run = next(r for r in runs if belongs(hole, r))
        wall, at = wall_of(room.space, run, hole.at)
        room.reserve(wall, at, hole.width_m + 2 * side_m)
        if hole.kind == "door" and hole.a == room.space.name and room.space.kind != "corridor":
            room.inset_m[wall] = max(room.inset_m[wall], DOOR_SWING_M - CLEARANCE_M)
            _reserve_entry(room, wall, at)


def _reserve_entry(room: Furnished, wall: int, at: float) -> None:
    """Keep the side walls free where they are near the way from a door into the lane."""
    left, right = (wall + 1) % 4, (wall - 1) % 4
    if at < ENTRY_SIDE_M:
        room.reserve(left, room.wall_length(left) - ENTRY_DEPTH_M / 2, ENTRY_DEPTH_M)
    if room.wall_length(wall) - at < ENTRY_SIDE_M:
        room.reserve(right, ENTRY_DEPTH_M / 2, ENTRY_DEPTH_M)


def reserve_open_sides(room: Furnished, spaces: Sequence[Space]) -> None:
    """Nothing stands where a corridor goes on without a wall."""
    s = room.space
    for other in spaces:
        if other.name == s.name or not {other.kind, s.kind} <= OPEN_KINDS:
            continue
        x0, x1 = max(s.x0, other.x0), min(s.x1, other.x1)
        y0, y1 = max(s.y0, other.y0), min(s.y1, other.y1)
        if x1 - x0 > 0.1 and math.isclose(y0, y1):
            at = s.x1 - (x0 + x1) / 2 if math.isclose(y0, s.y0) else (x0 + x1) / 2 - s.x0
            room.reserve(0 if math.isclose(y0, s.y0) else 2, at, x1 - x0 + 0.3)
        if y1 - y0 > 0.1 and math.isclose(x0, x1):
            at = (y0 + y1) / 2 - s.y0 if math.isclose(x0, s.x0) else s.y1 - (y0 + y1) / 2
            room.reserve(3 if math.isclose(x0, s.x0) else 1, at, y1 - y0 + 0.3)


def wall_of(space: Space, run: Run, at: float) -> tuple[int, float]:
    """Wall of the space a run is, and the place ``at`` counted from that wall's left end."""
    half = THICKNESS_M / 2
    if run.along == 0:
        south = math.isclose(run.at, space.y0, abs_tol=1e-6)
        return (0, space.x1 - half - at) if south else (2, at - space.x0 - half)
    west = math.isclose(run.at, space.x0, abs_tol=1e-6)
    return (3, at - space.y0 - half) if west else (1, space.y1 - half - at)


def furnish(
    room: Furnished,
    rng: np.random.Generator,
    palette: Palette,
    kinds: Sequence[str],
    *,
    clutter: float,
    posters: float,
    deepest_m: float = 2.0,
    least_lane_m: Point = LANE_M,
) -> None:
    """Fill walls with pieces of the given kinds, then hang pictures on what is left free."""
    for kind in kinds:
        if rng.random() > clutter:
            continue
        piece = STANDING[kind](rng, palette)
        if piece.depth_m <= deepest_m:
            _try(room, rng, piece, least_lane_m)
    for wall in range(4):
        for _ in range(int(rng.poisson(posters * room.wall_length(wall) / 2.0))):
            kind = str(rng.choice(["poster", "poster", "poster", "notes", "whiteboard"]))
            _try(room, rng, hanging(rng, kind, 24), least_lane_m, walls=(wall,))


def hang(room: Furnished, rng: np.random.Generator, piece: Piece, wall: int) -> None:
    """Put a flat piece somewhere on a wall, if there is room."""
    _try(room, rng, piece, LANE_M, walls=(wall,))


def _try(
    room: Furnished,
    rng: np.random.Generator,
    piece: Piece,
    least_lane_m: Point,
    walls: Sequence[int] = (0, 1, 2, 3),
) -> None:
    """Place the piece at the first of a few random spots that fits, else leave it out."""
    for _ in range(16):
        wall = int(rng.choice(walls))
        slack = room.wall_length(wall) - piece.width_m
        if slack <= 0.1:
            continue
        at = piece.width_m / 2 + slack * float(rng.random())
        if room.fits(wall, at, piece, least_lane_m):
            room.put(wall, at, piece)
            return


def rearranged(room: Furnished, rng: np.random.Generator, share: float) -> list[Change]:
    """Move, take away and leave behind what is movable; returns what went and what came."""
    kept, changes = [], []
    for piece, wall, at in room.placed:
        if not piece.movable or rng.random() >= share:
            kept.append((piece, wall, at))
        elif rng.random() < 0.5:
            changes.append(_change("removed", room, piece, wall, at))
        else:
            kept.append((piece, wall, at + float(rng.uniform(-0.06, 0.06))))
    room.placed = kept
    for kind in ADDED_KINDS:
        if rng.random() < share / len(ADDED_KINDS):
            piece = STANDING[kind](rng, DRAB)
            if piece.depth_m <= max(room.inset_m):
                count = len(room.placed)
                _try(room, rng, piece, LANE_M)
                changes += [_change("added", room, *new) for new in room.placed[count:]]
    return changes


def _change(kind: str, room: Furnished, piece: Piece, wall: int, at: float) -> Change:
    x, y = standing_place(room.space, wall, at, piece.depth_m / 2)
    return Change(kind, piece.kind, x, y)


def standing_place(space: Space, wall: int, at: float, out_m: float) -> tuple[float, float]:
    """Point ``at`` along a wall from its left end, ``out_m`` into the room."""
    (x, y), angle = _corner(space, wall)
    c, s = math.cos(angle), math.sin(angle)
    return x + at * c + out_m * s, y + at * s - out_m * c


def lean(faces: Iterable[Face], space: Space, wall: int, at: float) -> list[Face]:
    """Faces built with their back at y = 0, put against a wall of a space.

    ``wall`` 0 south, 1 east, 2 north, 3 west; ``at`` counts from the wall's left end as seen from
    inside, to x = 0 of the faces. Built things stand in y <= 0 with their front to -y.
    """
    (x, y), angle = _corner(space, wall)
    c, sine = math.cos(angle), math.sin(angle)
    rotation = np.array([[c, -sine, 0.0], [sine, c, 0.0], [0.0, 0.0, 1.0]])
    return placed(faces, rotation, np.array([x + at * c, y + at * sine, 0.0]))


def _corner(space: Space, wall: int) -> tuple[tuple[float, float], float]:
    """Left end of a wall as seen from inside, and the direction from there along it."""
    half = THICKNESS_M / 2
    corners = (
        (space.x1 - half, space.y0 + half),
        (space.x1 - half, space.y1 - half),
        (space.x0 + half, space.y1 - half),
        (space.x0 + half, space.y0 + half),
    )
    return corners[wall], (math.pi, -math.pi / 2, 0.0, math.pi / 2)[wall]
