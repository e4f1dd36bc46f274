"""Belief along the mapping path: spots, steps between them, what a view says of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.toy_system import signature_of

from fpnav.localization.filter import FilterParams, filter_belief, smooth_belief
from fpnav.localization.path import Path, PathSteps, make_path, path_likelihood, spots_of
from fpnav.mapping.places import make_edges, make_places
from fpnav.topomap.graph import TopoMap
from fpnav.values import Pose2, Reference, Signature

PARAMS = FilterParams(kidnap=1e-6, spot_m=0.5, spread_m=0.1, astray=0.0)
OWNER = np.repeat(np.arange(5), 4)


def corridor(rows: int = 20, *, apart_m: float = 0.5, turned: float = 0.0) -> list[Signature]:
    """Signatures on a straight line of a robot that heads along it."""
    c, s = math.cos(turned), math.sin(turned)
    return [
        signature_of(
            Reference(
                row, row, 0, apart_m * row, Pose2(apart_m * row * c, apart_m * row * s, turned)
            ),
            [1.0],
        )
        for row in range(rows)
    ]


def map_of(rows: list[Signature], owner: np.ndarray = OWNER) -> TopoMap:
    return TopoMap.of(make_places(rows, owner), make_edges(rows, owner))


def path_of(
    rows: list[Signature], queries: list[Signature], profiles: np.ndarray | None = None
) -> Path:
    graph = map_of(rows)
    spots = spots_of(graph, rows, PARAMS)
    seen = np.eye(5)[OWNER] if profiles is None else profiles
    return make_path(graph, rows, spots, seen, [query.reference for query in queries], PARAMS)


def steps_of(path: Path, queries: list[Signature], heading: float) -> PathSteps:
    headings = np.full((len(queries), 5), heading)
    return PathSteps(path, [query.reference for query in queries], headings, PARAMS)


def at(spot: int) -> np.ndarray:
    belief = np.zeros(20)
    belief[spot] = 1.0
    return belief


def test_spots_lie_apart_and_every_stay_has_one() -> None:
    rows = corridor(apart_m=0.2)
    spots = spots_of(map_of(rows), rows, replace_params(spot_m=0.55))
    assert spots.tolist() == [0, 3, 4, 7, 8, 11, 12, 15, 16, 19]


def replace_params(**changes: float | bool) -> FilterParams:
    return FilterParams(**{**{name: getattr(PARAMS, name) for name in ("spot_m",)}, **changes})


@pytest.mark.parametrize("what", ["off", "no odometry", "two sessions", "few places"])
def test_there_is_no_path_where_it_could_not_be_followed(what: str) -> None:
    rows, owner = corridor(), OWNER
    if what == "no odometry":
        rows[7] = replace(rows[7], reference=replace(rows[7].reference, odometry=None))
    if what == "two sessions":
        rows[8:] = [replace(one, reference=replace(one.reference, session=1)) for one in rows[8:]]
    if what == "few places":
        owner = np.minimum(OWNER, 2)
    params = replace_params(along_path=what != "off")
    assert not len(spots_of(map_of(rows, owner), rows, params))


@pytest.mark.parametrize(("heading", "expected"), [(0.0, 11), (math.pi, 9)])
def test_a_step_moves_the_belief_the_way_the_robot_heads(heading: float, expected: int) -> None:
    queries = corridor(2, turned=1.2)  # odometry of another run has another origin
    path = path_of(corridor(), queries)
    moved = steps_of(path, queries, heading)[0].forward(at(10))
    assert np.argmax(moved) == expected
    assert moved[expected] > 0.9


def test_without_a_heading_both_ways_are_as_likely() -> None:
    queries = corridor(2)
    moved = steps_of(path_of(corridor(), queries), queries, math.nan)[0].forward(at(10))
    assert moved[9] == pytest.approx(moved[11])
    assert moved[9] + moved[11] > 0.9


def test_a_robot_that_stands_stays_in_its_spot() -> None:
    queries = corridor(2, apart_m=0.0)
    moved = steps_of(path_of(corridor(), queries), queries, 0.0)[0].forward(at(10))
    assert np.argmax(moved) == 10


def test_messages_go_back_the_way_belief_goes_forward() -> None:
    rng = np.random.default_rng(5)
    queries = corridor(2)
    step = steps_of(path_of(corridor(), queries), queries, 0.3)[0]
    belief, message = rng.uniform(size=20), rng.uniform(size=20)
    assert step.forward(belief) @ message == pytest.approx(belief @ step.backward(message))
    assert step.forward(belief).sum() == pytest.approx(belief.sum())


def test_a_place_passed_again_is_joined_to_the_spot_it_looks_like() -> None:
    """Odometry has drifted five metres when the robot is back after thirty."""
    rows = corridor()
    for row in range(16, 20):
        moved = replace(rows[row].reference, travelled_m=40.0 + row, odometry=Pose2(row, 5.0, 0.0))
        rows[row] = replace(rows[row], reference=moved)
    owner = np.concatenate([OWNER[:16], np.zeros(4, int)])
    rng = np.random.default_rng(2)
    profiles = rng.uniform(size=(20, 4))
    profiles[18] = 2.0 * profiles[2] + 1.0
    graph = map_of(rows, owner)
    path = make_path(
        graph, rows, np.arange(20), profiles, [one.reference for one in corridor(2)], PARAMS
    )
    joined = set(zip(path.source.tolist(), path.target.tolist(), strict=True))
    assert {(2, 18), (18, 2)} <= joined
    assert (3, 18) not in joined


def test_a_profile_is_told_whatever_its_unit() -> None:
    rng = np.random.default_rng(1)
    profiles = rng.uniform(size=(20, 5))
    path = path_of(corridor(), corridor(2), profiles)
    flat = np.ones((3, 5))
    seen = profiles[[4, 9, 17]]
    found = path_likelihood(path, profiles, seen, flat, 20.0)
    assert found.argmax(axis=1).tolist() == [4, 9, 17]
    assert path_likelihood(path, profiles, 7.0 * seen - 3.0, flat, 20.0) == pytest.approx(found)


def test_a_view_that_says_nothing_leaves_all_spots_alike() -> None:
    profiles = np.eye(5)[OWNER]
    path = path_of(corridor(), corridor(2), profiles)
    blind = path_likelihood(path, profiles, np.full((1, 5), -np.inf), np.ones((1, 5)), 20.0)
    assert np.ptp(blind) == 0.0


def test_the_smoother_knows_from_the_end_where_the_run_began() -> None:
    """Every spot looks the same but one, which it is at in the end."""
    queries = corridor(10)
    path = path_of(corridor(), queries)
    likelihood = np.ones((10, 20))
    likelihood[-1] = np.where(np.arange(20) == 15, 1.0, 1e-6)
    steps = steps_of(path, queries, 0.0)
    assert smooth_belief(likelihood, steps)[0].argmax() == 6
    assert filter_belief(likelihood, steps)[0].max() == pytest.approx(0.05)


def test_steps_are_a_sequence() -> None:
    queries = corridor(4)
    steps = steps_of(path_of(corridor(), queries), queries, 0.0)
    assert len(steps) == 3
    assert len(steps[1:]) == 2
    with pytest.raises(IndexError):
        steps[3]
