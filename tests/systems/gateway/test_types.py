"""The table of 25 types, and every one of them from an episode made by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from fpnav.sensing.hallway import Hallway
from fpnav.sensing.openings import Evidence, Threshold
from fpnav.sensing.passages import Rule
from fpnav.sensing.pseudo_sonar import Sides
from fpnav.systems.gateway.types import KINDS, NAMES, NONE, code_of, sonar_weights
from fpnav.values import Pose2

WALL, FAR, STEP = 1.0, 4.0, 0.1
BEAM_RAD = math.radians(30.0)
Episode = list[tuple[float, float, float, float]]
"""Left, right, ahead, behind at every step of ten centimetres."""


def hall(left: str, right: str, blocked: bool) -> Episode:
    """Ten steps of corridor, then what the type says of either side."""
    front = 100.0 if not blocked else 5.0 if "N" in (left, right) else 4.0
    rows: Episode = []
    for step in range(48):
        at = step * STEP
        ahead = front - at
        if ahead < 0.5:
            break
        rows.append((side(left, at, blocked), side(right, at, blocked), ahead, 1.0 + at))
    return rows


def side(state: str, at: float, blocked: bool) -> float:
    start = 1.7 if blocked and state != "N" else 1.0
    if state == "N" and blocked:
        start = 0.8
    opens = {"W": (9.0, 9.0), "O": (start, start + 1.2), "N": (start, 99.0), "B": (start, 99.0)}
    begin, end = opens[state]
    if blocked and state == "O":
        begin, end = 1.7, 2.8
    return FAR if begin <= at < end else WALL


def beside(where: str, shape: str) -> Episode:
    """Along one wall of a room eight metres long, the other far away."""
    width = 2.6 if shape == "WIDE" else 1.2
    begin = 5.8 - width if shape == "CORNER" else 3.0
    rows: Episode = []
    for step in range(62):
        at = step * STEP
        near = FAR if begin <= at < begin + width else 0.7
        other = 5.5
        left, right = (near, other) if where == "LEFT" else (other, near)
        rows.append((left, right, 6.55 - at, 0.8 + at))
    return rows


def ahead(shape: str) -> Episode:
    """Towards and through an exit in the wall ahead."""
    before = {"CORNER": (0.9, 4.5), "MID": (3.0, 3.0), "WIDE": (3.0, 3.0)}[shape]
    half = 1.15 if shape == "WIDE" else 0.5
    rows: Episode = []
    for step in range(60):
        at = step * STEP
        if at < 3.0:
            rows.append((*before, 8.0 - at, 1.0 + at))
        elif at < 3.5:
            rows.append((half, half, 5.0, 4.0))
        else:
            rows.append((6.0, 6.0, 5.0, 4.0))
    return rows


def episodes() -> Iterator[tuple[str, Episode, bool]]:
    for kind in KINDS:
        if kind.where == "FRONT":
            yield kind.name, ahead(kind.shape), True
        elif kind.where:
            yield kind.name, beside(kind.where, kind.shape), True
        else:
            yield kind.name, hall(kind.left, kind.right, kind.blocked), False


def classify(rows: Episode, change: Callable[[], object], in_room: bool) -> list[str]:
    hallway = Hallway(Rule(), change)  # type: ignore[arg-type]
    if in_room:
        hallway.room.enter()
    found = []
    for number, (left, right, front, behind) in enumerate(rows):
        seen = Sides(left, right, front, front, behind, BEAM_RAD)
        found += hallway.step(number, Pose2(STEP * number, 0.0, 0.0), seen)
    found += hallway.finish()
    return [NAMES[code_of(passage)] for passage in found]


@pytest.mark.parametrize(
    ("name", "rows", "in_room"), list(episodes()), ids=lambda v: v if isinstance(v, str) else ""
)
@pytest.mark.parametrize("detector", ["threshold", "evidence"])
def test_every_type_is_classified_from_its_episode(
    name: str, rows: Episode, in_room: bool, detector: str
) -> None:
    changes = {
        "threshold": lambda: Threshold(0.5, 0.25, 2),
        "evidence": lambda: Evidence(0.25, 0.05, 5.0),
    }
    assert classify(rows, changes[detector], in_room) == [name]


def test_there_are_25_types_and_the_paper_names_four() -> None:
    assert len(KINDS) == len({kind.name for kind in KINDS}) == 25
    codes = {name: NAMES.index(name) for name in NAMES if name}
    assert codes["T-SHAPE"] == 12
    assert codes["RIGHT ROOM"] == 4
    assert codes["RIGHT CORNER EXIT"] == 18
    assert codes["RIGHT OPENING"] == 2


def test_the_weights_are_the_ratios_of_the_papers_table() -> None:
    weights = sonar_weights()
    opening, room, shape = (NAMES.index(n) for n in ("RIGHT OPENING", "RIGHT ROOM", "T-SHAPE"))
    assert weights[opening, opening] == 1.0
    assert weights[opening, room] == pytest.approx(0.06 / 0.31, abs=0.02)
    assert weights[opening, shape] == pytest.approx(0.02 / 0.31, abs=0.01)
    assert weights[room, opening] == pytest.approx(0.11 / 0.61, abs=0.01)
    assert np.array_equal(weights, weights.T)
    assert np.diag(weights) == pytest.approx(np.ones(26))


def test_unlike_types_exclude_each_other_and_no_type_says_nothing() -> None:
    weights = sonar_weights()
    right, left, dead = (NAMES.index(n) for n in ("RIGHT OPENING", "LEFT OPENING", "DEAD END"))
    assert weights[right, left] == 0.0
    assert weights[right, dead] == 0.0
    assert weights[right, NAMES.index("RIGHT MID EXIT")] == 0.0
    corner, mid = NAMES.index("RIGHT CORNER EXIT"), NAMES.index("RIGHT MID EXIT")
    assert weights[corner, mid] == pytest.approx(0.18)
    assert (weights[NONE] == 1.0).all()


def test_the_papers_second_table_follows_from_the_types() -> None:
    """Rows A and B: a T-shape, three right openings, a right room, two types unlike them."""
    names = ["T-SHAPE", *["RIGHT OPENING"] * 3, "RIGHT ROOM", "LEFT ROOM", "DEAD END"]
    codes = [NAMES.index(name) for name in names]
    rows = sonar_weights()[np.ix_(codes, codes)]
    rows[0, 5] = rows[5, 0] = 0.0
    table = rows / rows.sum(axis=1, keepdims=True)
    assert table[0, :5] == pytest.approx([0.82, 0.04, 0.04, 0.04, 0.04], abs=0.04)
    assert table[1, :5] == pytest.approx([0.02, 0.31, 0.31, 0.31, 0.06], abs=0.01)
    assert table[4, :5] == pytest.approx([0.06, 0.11, 0.11, 0.11, 0.61], abs=0.02)
