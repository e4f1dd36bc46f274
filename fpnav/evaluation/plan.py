"""The floor plan behind a simulated mapping run, from the ``world.json`` its log carries."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

PASSING = ("added", "removed")
"""Kinds of listed changes that are no landmark: what differs from another run."""

FRONT_M = 1.0
"""How far to either side of a door its front reaches: to about the middle of a corridor."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Rooms and what is of note between and in them.

    ``rooms`` : one (N, 2) polygon each; ``door_rooms`` : pairs of room numbers joined by a listed
    door, open or not; ``landmarks`` (L, 2): open doors and listed changes that stay; ``fronts``
    (L, 2, 2): the way through each of those doors, ``FRONT_M`` to either side of it, from end to
    end, and each change as a line of no length; ``closed`` (D, 2) and ``closed_fronts`` (D, 2, 2)
    the same of doors that were closed; ``walls`` (W, 2, 2) and ``openings`` (D, 2, 2), where doors
    stand open in them, from end to end.
    """

    rooms: tuple[FloatArray, ...]
    door_rooms: frozenset[tuple[int, int]]
    landmarks: FloatArray
    fronts: FloatArray
    closed: FloatArray
    closed_fronts: FloatArray
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
                return plan_of_world(worlds[0]) if worlds else None
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


def plan_of_world(world: Any) -> Plan | None:
    """Plan a ``world.json`` describes, None where it is not of that form."""
    try:
        names = {str(room["name"]): number for number, room in enumerate(world["rooms"])}
        rooms = tuple(np.array(room["polygon"], dtype=np.float64) for room in world["rooms"])
        if any(room.ndim != 2 or room.shape[1] != 2 for room in rooms):
            return None
        pairs = [sorted(names[space] for space in door["spaces"]) for door in world["doors"]]
        opened = [door for door in world["doors"] if door["open"]]
        shut = [door for door in world["doors"] if not door["open"]]
        changes = _points([one for one in world["changes"] if one["kind"] not in PASSING])
        return Plan(
            rooms=rooms,
            door_rooms=frozenset((a, b) for a, b in pairs),
            landmarks=np.concatenate([_points(opened), changes]),
            fronts=np.concatenate([_lines(opened, _front), np.stack([changes, changes], axis=1)]),
            closed=_points(shut),
            closed_fronts=_lines(shut, _front),
            walls=np.array(world.get("walls", ()), dtype=np.float64).reshape(-1, 2, 2),
            openings=_lines(opened, _opening),
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        return None


def _points(marks: Sequence[Mapping[str, Any]]) -> FloatArray:
    found = [[mark["x_m"], mark["y_m"]] for mark in marks]
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def _lines(
    doors: Sequence[Mapping[str, Any]], line: Callable[[Mapping[str, Any]], FloatArray]
) -> FloatArray:
    """A line of each door from end to end, (D, 2, 2)."""
    return np.array([line(door) for door in doors], dtype=np.float64).reshape(-1, 2, 2)


def _opening(door: Mapping[str, Any]) -> FloatArray:
    """Ends of a door's opening, across the way through it, (2, 2)."""
    along, half = float(door["axis_rad"]), float(door["width_m"]) / 2.0
    across = half * np.array([-np.sin(along), np.cos(along)])
    middle = np.array([door["x_m"], door["y_m"]], dtype=np.float64)
    return np.array([middle - across, middle + across])


def _front(door: Mapping[str, Any]) -> FloatArray:
    """Ends of a door's front, along the way through it, (2, 2)."""
    along = float(door["axis_rad"])
    reach = FRONT_M * np.array([np.cos(along), np.sin(along)])
    middle = np.array([door["x_m"], door["y_m"]], dtype=np.float64)
    return np.array([middle - reach, middle + reach])
