"""The 25 types of gateway as a table; the paper names four, the rest reconstruct its count
(systems.md 3.4). Another list may take this one's place: nothing else knows a type by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fpnav.sensing.passages import Passage
from fpnav.values import FloatArray

NONE = 0
"""Code of a place where no gateway was classified."""

IDENTICAL, CLOSING, SHARED = 1.0, 0.18, 0.07
"""Sonar likelihood of the same type, of one that differs only in whether one side closes (or in
an exit's shape), and of one with an open side in common: .06/.31 and .11/.61, .02/.31 and .04/.82
in the paper's table."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A type: ``left``, ``right`` W wall, O opening, N no closing, B to the blockage; an exit has
    ``where`` and ``shape`` instead."""

    name: str
    left: str = ""
    right: str = ""
    blocked: bool = False
    where: str = ""
    shape: str = ""

    @property
    def open_sides(self) -> frozenset[str]:
        """Sides of a hallway that are open."""
        sides = {"left": self.left, "right": self.right}
        return frozenset(side for side, state in sides.items() if state not in ("", "W"))


KINDS = (
    Kind("LEFT OPENING", "O", "W"),
    Kind("RIGHT OPENING", "W", "O"),
    Kind("LEFT ROOM", "N", "W"),
    Kind("RIGHT ROOM", "W", "N"),
    Kind("CROSS", "O", "O"),
    Kind("LEFT OPENING RIGHT ROOM", "O", "N"),
    Kind("LEFT ROOM RIGHT OPENING", "N", "O"),
    Kind("BOTH ROOM", "N", "N"),
    Kind("DEAD END", "W", "W", blocked=True),
    Kind("LEFT TURN", "B", "W", blocked=True),
    Kind("RIGHT TURN", "W", "B", blocked=True),
    Kind("T-SHAPE", "B", "B", blocked=True),
    Kind("LEFT OPENING RIGHT TURN", "O", "B", blocked=True),
    Kind("LEFT ROOM RIGHT TURN", "N", "B", blocked=True),
    Kind("RIGHT OPENING LEFT TURN", "B", "O", blocked=True),
    Kind("RIGHT ROOM LEFT TURN", "B", "N", blocked=True),
    Kind("LEFT CORNER EXIT", where="LEFT", shape="CORNER"),
    Kind("RIGHT CORNER EXIT", where="RIGHT", shape="CORNER"),
    Kind("FRONT CORNER EXIT", where="FRONT", shape="CORNER"),
    Kind("LEFT MID EXIT", where="LEFT", shape="MID"),
    Kind("RIGHT MID EXIT", where="RIGHT", shape="MID"),
    Kind("FRONT MID EXIT", where="FRONT", shape="MID"),
    Kind("LEFT WIDE EXIT", where="LEFT", shape="WIDE"),
    Kind("RIGHT WIDE EXIT", where="RIGHT", shape="WIDE"),
    Kind("FRONT WIDE EXIT", where="FRONT", shape="WIDE"),
)
"""G01 to G25 in order; the code of a type is its place in the table, from 1."""

NAMES = ("", *(kind.name for kind in KINDS))
_CODES = {
    (kind.left, kind.right, kind.blocked, kind.where, kind.shape): code
    for code, kind in enumerate(KINDS, start=1)
}


def code_of(passage: Passage) -> int:
    """Code of a passage's type; 0 where the table has none."""
    way_out = passage.exit
    if way_out is not None:
        return _CODES.get(("", "", False, way_out.where, way_out.shape), NONE)
    return _CODES.get((passage.left, passage.right, passage.blocked, "", ""), NONE)


def sonar_weights() -> FloatArray:
    """Weight of classifying a gateway of one type (row) as another (column), (26, 26).

    Row and column 0 stand for "no type": all ones, they say nothing.
    """
    table = np.ones((len(KINDS) + 1, len(KINDS) + 1))
    for i, first in enumerate(KINDS, start=1):
        for j, second in enumerate(KINDS, start=1):
            table[i, j] = _weight(first, second)
    return table


def _weight(first: Kind, second: Kind) -> float:
    if first == second:
        return IDENTICAL
    if first.where or second.where:
        return CLOSING if first.where == second.where else 0.0
    changed = [pair for pair in _sides(first, second) if pair[0] != pair[1]]
    if first.blocked == second.blocked and len(changed) == 1 and set(changed[0]) == {"O", "N"}:
        return CLOSING
    return SHARED if first.open_sides & second.open_sides else 0.0


def _sides(first: Kind, second: Kind) -> tuple[tuple[str, str], tuple[str, str]]:
    return (first.left, second.left), (first.right, second.right)
