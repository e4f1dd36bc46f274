"""Place-action pairs read from a map."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.errors import LogError
from fpnav.navigation.actions import Winner, along, place_named, towards
from fpnav.topomap.graph import TopoMap
from fpnav.values import Place, Pose2, Reference, Signature

NOTHING = np.zeros(1, [("n", "<i4")])[0]


def signature(x: float, y: float, heading: float = 0.0, session: int = 0) -> Signature:
    pose = Pose2(x, y, math.radians(heading))
    return Signature(Reference(0, 0, session=session, odometry=pose), NOTHING, {})


def square() -> tuple[TopoMap, list[Signature]]:
    """Four places driven past counter-clockwise."""
    run = [
        signature(0, 0, 0),
        signature(2, 0, 90),
        signature(2, 2, 180),
        signature(0, 2, -90),
    ]
    names = ("a", "b", "c", "")
    return TopoMap.of([Place(i, (i,), 0.0, names[i]) for i in range(4)], []), run


def degrees(actions: dict[int, float]) -> list[float]:
    return [round(math.degrees(actions[place]), 6) for place in sorted(actions)]


def test_every_place_points_at_the_goal_in_its_own_frame() -> None:
    topomap, run = square()
    assert degrees(towards(topomap, run, Pose2(1.0, 1.0, 0.0))) == [45.0, 45.0, 45.0, 45.0]


def test_the_goal_itself_is_an_end() -> None:
    topomap, run = square()
    assert sorted(towards(topomap, run, Pose2(2.0, 2.0, 0.0))) == [0, 1, 3]


def test_the_teacher_went_on_to_the_next_place() -> None:
    topomap, run = square()
    assert degrees(along(topomap, run, 1.0)) == [0.0, 0.0, 0.0]


def test_the_way_ahead_is_taken_so_far_as_asked() -> None:
    run = [signature(0, 0), signature(0.5, 0.5), signature(0.5, 2.0)]
    topomap = TopoMap.of([Place(0, (0, 1, 2), 0.0)], [])
    assert degrees(along(topomap, run, 0.5)) == [45.0]
    assert degrees(along(topomap, run, 1.9))[0] == pytest.approx(75.96, abs=0.01)


def test_the_teacher_does_not_go_on_in_another_session() -> None:
    run = [signature(0, 0), signature(1, 0, session=1)]
    topomap = TopoMap.of([Place(0, (0,), 0.0), Place(1, (1,), 0.0)], [])
    assert along(topomap, run) == {}


def test_places_are_named_by_label_or_number() -> None:
    topomap, _ = square()
    assert place_named(topomap, "b") == 1
    assert place_named(topomap, "3") == 3
    with pytest.raises(LogError, match="it has a, b, c"):
        place_named(topomap, "kitchen")


def test_a_map_without_poses_gives_no_directions() -> None:
    topomap = TopoMap.of([Place(0, (0,), 0.0)], [])
    with pytest.raises(LogError, match="neither odometry nor truth"):
        towards(topomap, [Signature(Reference(0, 0), NOTHING, {})], Pose2(0, 0, 0))


def test_the_winner_stays_until_a_rival_is_clearly_better() -> None:
    winner = Winner(0.02)
    assert winner.choose({1: 0.5, 2: 0.4}) == 1
    assert winner.choose({1: 0.5, 2: 0.51}) == 1
    assert winner.choose({1: 0.5, 2: 0.53}) == 2
    assert winner.choose({1: 0.53, 2: 0.53}) == 2


def test_without_activity_nobody_wins() -> None:
    winner = Winner()
    assert winner.choose({1: 0.5}) == 1
    assert winner.choose({1: 0.0}) == -1
    assert winner.choose({3: 0.2, 2: 0.2}) == 2
