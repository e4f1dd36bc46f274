"""Loops close where the robot comes back, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.toy_system import Toy, ToyParams, drive

from fpnav.mapping.build import Built, build_map
from fpnav.mapping.loops import LoopParams, close_loops, old_places
from fpnav.values import Signature

BINS = 48


def stays(places: list[int], times: int = 6, session: int = 0) -> list[Signature]:
    return drive([place for place in places for _ in range(times)], bins=BINS, session=session)


def build(rows: list[Signature]) -> Built:
    return build_map(Toy(ToyParams()), rows, loops=LoopParams(), advance=lambda done: None)


def test_a_second_lap_is_merged_into_the_first() -> None:
    lap = list(range(30))
    built = build(stays(lap + lap))
    assert built.topomap.ids.tolist() == lap
    assert [place.merged_from for place in built.topomap.places] == [(i, i + 30) for i in lap]
    assert built.topomap.place(3).members == (*range(18, 24), *range(198, 204))
    assert [(edge.source, edge.target, edge.count) for edge in built.topomap.edges] == [
        *((i, i + 1, 2) for i in range(29)),
        (29, 0, 1),
    ]
    assert built.memory.places.tolist() == lap


def test_a_way_back_through_the_same_places_is_merged() -> None:
    built = build(stays([*range(30), *range(40, 46), *range(29, -1, -1)]))
    merged = [place.merged_from for place in built.topomap.places]
    assert merged[:29] == [(i, 65 - i) for i in range(29)]
    pairs = {(edge.source, edge.target) for edge in built.topomap.edges}
    assert {(i, i + 1) for i in range(28)} | {(i + 1, i) for i in range(28)} <= pairs


def test_what_only_leads_up_to_a_loop_is_not_merged_into_it() -> None:
    built = build(stays([*range(20), *range(25, 30), *range(10, 20)]))
    merged = [place.merged_from for place in built.topomap.places]
    assert merged == [()] * 10 + [(i, i + 15) for i in range(10, 20)] + [()] * 5


def test_a_second_session_on_the_same_way_is_merged() -> None:
    way = list(range(30))
    built = build(stays(way) + stays(way, session=1))
    assert built.topomap.ids.tolist() == way


def test_a_run_that_never_comes_back_has_no_loop() -> None:
    built = build(stays(list(range(40))))
    assert len(built.topomap) == 40
    assert all(place.merged_from == () for place in built.topomap.places)


def test_one_look_alike_on_new_ground_is_no_loop() -> None:
    built = build(stays([*range(30), 3, *range(30, 40)]))
    assert len(built.topomap) == 41


def test_the_owner_keeps_every_signature_and_ids_rise_with_the_first_visit() -> None:
    rows = stays([*range(30), *range(30)])
    owner = np.repeat(np.arange(60), 6)
    closed, merged = close_loops(Toy(), rows, owner, 0.5, LoopParams())
    assert len(closed) == len(owner)
    _, first = np.unique(closed, return_index=True)
    assert (np.diff(first) > 0).all()
    assert sorted(i for ids in merged.values() for i in ids) == list(range(60))


@pytest.mark.parametrize(("observations", "places"), [(0, 0), (3, 2)])
def test_a_place_is_old_when_it_was_left_long_enough_ago(observations: int, places: int) -> None:
    rows = np.array([0, 0, 1, 1, 2, 0, 0])
    params = LoopParams(recent_observations=observations, recent_places=places)
    old = old_places(rows, 3, params)
    assert not old[np.arange(7), rows].any()
    if observations == 0:
        assert old[4].tolist() == [True, True, False]
    else:
        # row 4: place 0 left at row 1, three observations and two changes ago
        assert old[4].tolist() == [False, False, False]
        assert old[5].tolist() == [False, False, False]
