"""The floor plan behind a simulated mapping run, from the ``world.json`` its log carries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

PASSING = ("added", "removed")
"""Kinds of listed changes that are no landmark: what differs from another run."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Rooms and what is of note between and in them.

    ``rooms`` : one (N, 2) polygon each; ``door_rooms`` : pairs of room numbers joined by a listed
    door, open or not; ``landmarks`` (L, 2): open doors and listed changes that stay;
    ``closed`` (D, 2): doors that were closed; ``walls`` (W, 2, 2) and ``openings`` (D, 2, 2),
    where doors stand open in them, from end to end.
    """

    rooms: tuple[FloatArray, ...]
    door_rooms: frozenset[tuple[int, int]]
    landmarks: FloatArray
    closed: FloatArray
    walls: FloatArray
    openings: FloatArray

    def room_of(self, points: FloatArray) -> NDArray[np.int64]:
        """Room each point (N, 2) lies in, -1 for none; of overlapping rooms the first."""
        found = np.full(len(points), -1, dtype=np.int64)
        for number in reversed(range(len(self.rooms))):
            found[inside(points, self.rooms[number])] = number
        return found


def plan_of(header: Mapping[str, Any]) -> Plan | None:
    """Plan of the world the map of a result was recorded in, None where there is none.

    A world that is not of the form of ``world.json`` counts as none: it comes from a log.
    """
    for mapped in header.get("chain", ()):
        if mapped.get("format") == "fpnav/map":
            for signatures in mapped.get("chain", ()):
                worlds = [world for world in signatures.get("worlds", ()) if world]
                return _plan(worlds[0]) if worlds else None
    return None


def inside(points: FloatArray, polygon: FloatArray) -> NDArray[np.bool_]:
    """Whether each point (N, 2) lies in a polygon (M, 2), by counting crossings."""
    x, y = points[:, :1], points[:, 1:2]
    x0, y0 = polygon.T
    x1, y1 = np.roll(polygon, -1, axis=0).T
    with np.errstate(all="ignore"):
        crossing = (y0 <= y) != (y1 <= y)
        at = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
        return np.asarray((crossing & (x < at)).sum(axis=1) % 2 == 1)


def _plan(world: Any) -> Plan | None:
    try:
        names = {str(room["name"]): number for number, room in enumerate(world["rooms"])}
        rooms = tuple(np.array(room["polygon"], dtype=np.float64) for room in world["rooms"])
        if any(room.ndim != 2 or room.shape[1] != 2 for room in rooms):
            return None
        pairs = [sorted(names[space] for space in door["spaces"]) for door in world["doors"]]
        marks = [door for door in world["doors"] if door["open"]]
        marks += [change for change in world["changes"] if change["kind"] not in PASSING]
        joined = frozenset((a, b) for a, b in pairs)
        landmarks = _points(marks)
        closed = _points([door for door in world["doors"] if not door["open"]])
        walls = np.array(world.get("walls", ()), dtype=np.float64).reshape(-1, 2, 2)
        openings = [_opening(door) for door in world["doors"] if door["open"]]
    except (KeyError, TypeError, ValueError, AttributeError):
        return None
    drawn = np.array(openings, dtype=np.float64).reshape(-1, 2, 2)
    return Plan(rooms, joined, landmarks, closed, walls, drawn)


def _points(marks: Sequence[Mapping[str, Any]]) -> FloatArray:
    found = [[mark["x_m"], mark["y_m"]] for mark in marks]
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def _opening(door: Mapping[str, Any]) -> FloatArray:
    """Ends of a door's opening, across the way through it, (2, 2)."""
    along, half = float(door["axis_rad"]), float(door["width_m"]) / 2.0
    across = half * np.array([-np.sin(along), np.cos(along)])
    middle = np.array([door["x_m"], door["y_m"]], dtype=np.float64)
    return np.array([middle - across, middle + across])
