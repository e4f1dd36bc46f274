"""Where places start: at doors driven through and driven past, open and closed, and by chance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.results import header, on_map

from fpnav.evaluation.evaluate import Evaluation, evaluate

# A corridor along y = 0 .. 2 that the robot drives at y = 0.5, a door in its wall at (2, 2)


def door(x_m: float, *, is_open: bool = True) -> dict[str, Any]:
    return {
        "name": f"door-{x_m}", "x_m": x_m, "y_m": 2.0, "axis_rad": np.pi / 2, "width_m": 0.8,
        "open": is_open, "spaces": ["hall", "room"],
    }  # fmt: skip


def world(*doors: dict[str, Any], changes: tuple[dict[str, Any], ...] = ()) -> dict[str, Any]:
    rooms = [
        {"name": "hall", "kind": "corridor", "polygon": [[-1, 0], [9, 0], [9, 2], [-1, 2]]},
        {"name": "room", "kind": "office", "polygon": [[-1, 2], [9, 2], [9, 6], [-1, 6]]},
    ]
    return {"rooms": rooms, "doors": list(doors), "changes": list(changes)}


ALONG = [[0.5 * i, 0.5, 0.0] for i in range(16)]


def measured(found: dict[str, Any], owner: list[int], path: list[list[float]]) -> Evaluation:
    signatures = {"format": "fpnav/signatures", "worlds": [found], "chain": []}
    facts = header("match", chain=[{"format": "fpnav/map", "chain": [signatures]}])
    return evaluate(on_map(path, owner, [[0, 0.5, 0]], [[0]], edges=[(0, 1)], header=facts))


def starting_at(row: int) -> list[int]:
    return [0] * row + [1] * (len(ALONG) - row)


def figure(found: Evaluation, name: str) -> tuple[float, int, int]:
    metric = found.metrics[name]
    return metric.value, metric.n, metric.of


def test_a_door_driven_past_counts_by_its_front_only() -> None:
    found = measured(world(door(2.0)), starting_at(4), ALONG)
    assert figure(found, "node_precision") == (0.0, 0, 1)
    assert "node_recall" in found.absent
    assert figure(found, "node_precision_front") == (1.0, 1, 1)
    assert figure(found, "node_recall_front") == (1.0, 1, 1)


def test_the_front_of_a_door_ends_beside_it() -> None:
    found = measured(world(door(2.0)), starting_at(6), ALONG)
    assert figure(found, "node_precision_front") == (0.0, 0, 1)
    assert figure(found, "node_recall_front") == (0.0, 0, 1)


def test_a_change_has_no_front() -> None:
    change = {"kind": "colour", "what": "wall", "x_m": 2.0, "y_m": 2.0}
    found = measured(world(changes=(change,)), starting_at(4), ALONG)
    assert figure(found, "node_precision_front") == (0.0, 0, 1)


def test_a_start_in_front_of_a_closed_door_is_at_one() -> None:
    closed = world(door(2.0, is_open=False))
    assert figure(measured(closed, starting_at(4), ALONG), "nodes_at_closed_doors_front") == (
        1.0,
        1,
        1,
    )
    assert figure(measured(closed, starting_at(7), ALONG), "nodes_at_closed_doors_front") == (
        0.0,
        0,
        1,
    )


def test_a_closed_door_itself_is_out_of_reach_from_the_middle_of_a_corridor() -> None:
    closed = measured(world(door(2.0, is_open=False)), starting_at(4), ALONG)
    assert figure(closed, "nodes_at_closed_doors") == (0.0, 0, 1)


def test_a_start_between_an_open_and_a_closed_door_has_a_reason() -> None:
    both = world(door(2.0, is_open=False), door(2.5))
    assert figure(measured(both, starting_at(4), ALONG), "nodes_at_closed_doors_front") == (
        0.0,
        0,
        1,
    )


@pytest.mark.parametrize("name", ["node_precision_front", "node_recall_front"])
def test_chance_is_the_mean_over_all_starts(name: str) -> None:
    found = [measured(world(door(2.0)), starting_at(row), ALONG) for row in range(1, len(ALONG))]
    mean = np.mean([one.metrics[name].value for one in found])
    assert mean == pytest.approx(3 / 15)  # within 1 m of (2, 1): 1.5, 2 and 2.5 m along
    for one in found:
        assert one.metrics[f"{name}_chance"].value == pytest.approx(mean)


def test_chance_of_closed_doors_is_the_mean_over_all_starts() -> None:
    closed = world(door(2.0, is_open=False), door(7.0))
    found = [measured(closed, starting_at(row), ALONG) for row in range(1, len(ALONG))]
    mean = np.mean([one.metrics["nodes_at_closed_doors_front"].value for one in found])
    assert mean == pytest.approx(3 / 15)
    for one in found:
        assert one.metrics["nodes_at_closed_doors_front_chance"].value == pytest.approx(mean)


def test_more_starts_meet_more_by_chance() -> None:
    owner = [0] * 5 + [1] * 5 + [2] * 6
    found = measured(world(door(2.0)), owner, ALONG)
    assert found.metrics["node_precision_front_chance"].value == pytest.approx(3 / 15)
    assert found.metrics["node_recall_front_chance"].value == pytest.approx(1 - (12 / 15) ** 2)


def test_no_place_can_start_on_known_ground() -> None:
    there = [0] * 4 + [1] * 4 + [2] * 8
    found = measured(world(door(2.0)), there + there[::-1], ALONG + ALONG[::-1])
    # the way back past the door, in places known by then, is left out; that within place 2 is not
    assert figure(found, "node_precision_front_chance") == (pytest.approx(3 / 23), 3, 23)
