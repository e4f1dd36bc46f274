"""The map beside the floor plan: rooms merged, doors told from open passages, landmarks met."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.results import header, on_map, recognition

from fpnav.evaluation.evaluate import Evaluation, evaluate
from fpnav.evaluation.plan import inside, plan_of

# A corridor of two pieces from x = 0 to 8 along y = 0 .. 2, a room above each piece:
#
#   +----- west -----+----- east -----+   y = 6
#   |                |                |
#   +----door 2------+------door 6----+   y = 2
#   |  hall-1        :   hall-2       |
#   +----------------+----------------+   y = 0


def room(name: str, x0: float, y0: float, x1: float, y1: float) -> dict[str, Any]:
    return {"name": name, "kind": "room", "polygon": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]}


def door(x_m: float, spaces: list[str], is_open: bool) -> dict[str, Any]:
    return {
        "name": "|".join(spaces), "x_m": x_m, "y_m": 2.0, "axis_rad": np.pi / 2, "width_m": 0.8,
        "open": is_open, "spaces": spaces,
    }  # fmt: skip


WORLD: dict[str, Any] = {
    "rooms": [
        room("hall-1", 0, 0, 4, 2),
        room("hall-2", 4, 0, 8, 2),
        room("west", 0, 2, 4, 6),
        room("east", 4, 2, 8, 6),
    ],
    "doors": [door(2, ["west", "hall-1"], True), door(6, ["east", "hall-2"], False)],
    "changes": [
        {"kind": "colour", "what": "wall", "x_m": 4.0, "y_m": 1.0},
        {"kind": "removed", "what": "bin", "x_m": 7.0, "y_m": 1.0},
    ],
    "walls": [[0.0, 2.0, 8.0, 2.0], [4.0, 2.0, 4.0, 6.0]],
}
# down from the room through its door, then along the corridor
PATH = [[2, 5 - 0.5 * i, 0] for i in range(9)] + [[2 + 0.5 * i, 1, 0] for i in range(1, 12)]


def measured(owner: list[int], edges: list[tuple[int, int]], world: Any = WORLD) -> Evaluation:
    signatures = {"format": "fpnav/signatures", "worlds": [world], "chain": []}
    chain = [{"format": "fpnav/map", "chain": [signatures]}]
    facts = header("match", chain=chain)
    return evaluate(on_map(PATH, owner, [[2, 5, 0]], [[0]], edges=edges, header=facts))


ROOM_THEN_HALLS = [0] * 6 + [1] * 7 + [2] * 7
CHAIN = [(0, 1), (1, 2)]


def figure(found: Evaluation, name: str) -> tuple[float, int, int]:
    metric = found.metrics[name]
    return metric.value, metric.n, metric.of


def test_places_of_one_room_merge_and_corridor_pieces_are_one_room() -> None:
    assert figure(measured(ROOM_THEN_HALLS, CHAIN), "topology_equal") == (1.0, 1, 1)


def test_a_missing_edge_breaks_the_shape() -> None:
    assert figure(measured(ROOM_THEN_HALLS, [(1, 2)]), "topology_equal") == (0.0, 0, 1)


def test_an_edge_through_a_wall_breaks_the_shape() -> None:
    path_in_the_east = [0] * 6 + [1] * 7 + [2] * 7
    found = measured(path_in_the_east, [*CHAIN, (0, 2)])
    # places 1 and 2 are both in the corridor: room to corridor is the one passage there is
    assert figure(found, "topology_equal") == (1.0, 1, 1)


def test_a_room_without_a_place_is_a_passage_missing() -> None:
    all_in_one = [0] * 20
    value, same, either = figure(measured(all_in_one, []), "topology_equal")
    assert (value, same) == (0.0, 0)
    assert either == 2


def test_places_are_judged_by_where_they_start() -> None:
    found = measured(ROOM_THEN_HALLS, CHAIN)
    # place 0 starts the run and is left out; place 1 starts at the door (2, 2), place 2 at (4.5, 1)
    assert figure(found, "node_precision") == (1.0, 2, 2)
    assert figure(found, "node_recall") == (1.0, 2, 2)
    elsewhere = measured([0] * 3 + [1] * 15 + [2] * 2, CHAIN)
    assert figure(elsewhere, "node_precision") == (0.0, 0, 2)
    assert figure(elsewhere, "node_recall") == (0.0, 0, 2)


def test_closed_doors_and_removed_things_are_no_landmarks() -> None:
    signatures = {"format": "fpnav/signatures", "worlds": [None, WORLD]}
    plan = plan_of({"chain": [{"format": "fpnav/map", "chain": [signatures]}]})
    assert plan is not None
    assert plan.landmarks.tolist() == [[2.0, 2.0], [4.0, 1.0]]
    assert plan.door_rooms == {(0, 2), (1, 3)}


def test_walls_stand_open_where_their_open_doors_are() -> None:
    plan = plan_of({"chain": [{"format": "fpnav/map", "chain": [{"worlds": [WORLD]}]}]})
    assert plan is not None
    assert plan.walls.tolist() == [[[0, 2], [8, 2]], [[4, 2], [4, 6]]]
    np.testing.assert_allclose(plan.openings, [[[2.4, 2.0], [1.6, 2.0]]], atol=1e-12)


def test_the_front_of_a_door_is_the_way_through_it() -> None:
    plan = plan_of({"chain": [{"format": "fpnav/map", "chain": [{"worlds": [WORLD]}]}]})
    assert plan is not None
    change = [[4.0, 1.0], [4.0, 1.0]]
    np.testing.assert_allclose(plan.fronts, [[[2.0, 1.0], [2.0, 3.0]], change], atol=1e-12)
    np.testing.assert_allclose(plan.closed_fronts, [[[6.0, 1.0], [6.0, 3.0]]], atol=1e-12)


def test_points_lie_in_the_room_around_them() -> None:
    plan = plan_of({"chain": [{"format": "fpnav/map", "chain": [{"worlds": [WORLD]}]}]})
    assert plan is not None
    points = np.array([[1, 1], [5, 1], [1, 3], [9, 9], [np.nan, 1]])
    assert plan.room_of(points).tolist() == [0, 1, 2, -1, -1]


def test_a_polygon_may_be_hollowed() -> None:
    corner = np.array([[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]], dtype=float)
    points = np.array([[0.5, 3], [3, 0.5], [3, 3], [-1, 0.5]])
    assert inside(points, corner).tolist() == [True, True, False, False]


@pytest.mark.parametrize(
    "world",
    [
        {},
        {"rooms": 3},
        {**WORLD, "rooms": [{"name": "a", "polygon": [[1, 2, 3]]}]},
        {**WORLD, "doors": [{"spaces": ["nowhere", "west"], "open": True}]},
        {**WORLD, "doors": [{"spaces": ["east"], "open": True, "x_m": 1, "y_m": 1}]},
        {**WORLD, "walls": [[0.0, 1.0, 2.0]]},
        {**WORLD, "changes": [{"kind": "corner", "x_m": "left", "y_m": 1}]},
        [WORLD],
    ],
)
def test_a_world_of_another_form_counts_as_none(world: Any) -> None:
    found = measured(ROOM_THEN_HALLS, CHAIN, world)
    assert found.absent["topology_equal"].startswith("the mapping log carries no world.json")


def test_without_a_map_there_is_no_shape() -> None:
    found = evaluate(recognition([[1.0]], pairs={0: [0]}))
    assert found.absent["node_recall"] == "made without a map of places"
