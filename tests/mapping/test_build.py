"""The incremental builder on drives whose places are known."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from helpers.toy_system import Toy, ToyParams, drive, mixed, one_hot, signature_of
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import LogError
from fpnav.mapping.build import (
    Built,
    absorb_small,
    build_map,
    consecutive_novelty,
    places_by_label,
)
from fpnav.topomap.graph import check_map
from fpnav.values import Reference, Signature


def build(signatures: Sequence[Signature], *, guided: bool = False, **params: object) -> Built:
    system = Toy(ToyParams(**params))  # type: ignore[arg-type]
    return build_map(system, signatures, guided=guided, advance=lambda done: None)


def members(built: Built) -> list[list[int]]:
    return [list(place.members) for place in built.topomap.places]


def looks(*histograms: Sequence[float], session: int = 0) -> list[Signature]:
    return [
        signature_of(Reference(row, row, session=session, travelled_m=row), histogram)
        for row, histogram in enumerate(histograms)
    ]


def test_a_place_starts_where_the_world_changes() -> None:
    built = build(drive([0, 0, 0, 1, 1, 2, 2, 2]))
    assert members(built) == [[0, 1, 2], [3, 4], [5, 6, 7]]
    assert [place.extent_m for place in built.topomap.places] == [2.0, 1.0, 2.0]
    assert [(e.source, e.target, e.length_m) for e in built.topomap.edges] == [(0, 1, 3), (1, 2, 2)]
    assert built.novelty[1:].tolist() == [0, 0, 1, 0, 1, 0, 0]
    assert np.isnan(built.novelty[0])
    assert built.threshold == 0.5


def test_a_place_seen_again_is_a_new_place_until_loops_are_closed() -> None:
    assert members(build(drive([0, 0, 1, 1, 0, 0]))) == [[0, 1], [2, 3], [4, 5]]


def test_a_novelty_that_equals_the_threshold_starts_a_place() -> None:
    assert members(build(looks(one_hot(0), mixed(0, 1, 0.5)), theta=0.5)) == [[0], [1]]
    assert members(build(looks(one_hot(0), mixed(0, 1, 0.25)), theta=0.5)) == [[0, 1]]


def test_the_memory_has_learned_the_places_of_the_map() -> None:
    built = build(drive([0, 0, 1, 1]))
    assert built.memory.places.tolist() == built.topomap.ids.tolist() == [0, 1]
    assert built.memory.save()["counts"].tolist() == [2, 2]


def test_auto_finds_the_threshold_that_gives_so_many_places() -> None:
    slow = looks(*(mixed(0, 1, share) for share in (0.0, 0.1, 0.5, 0.6, 0.9, 1.0)))
    # novelties .1 .4 .1 .3 .1: three places are cut at the two largest
    assert members(build(slow, theta="auto", nodes=3)) == [[0, 1], [2, 3], [4, 5]]
    assert members(build(slow, theta="auto", nodes=1)) == [[0, 1, 2, 3, 4, 5]]


def test_small_runs_join_the_neighbour_they_are_more_like() -> None:
    rows = looks(one_hot(0), one_hot(0), mixed(0, 2, 0.8), one_hot(2), one_hot(2))
    assert members(build(rows, theta=0.15, min_observations=1)) == [[0, 1], [2], [3, 4]]
    assert members(build(rows, theta=0.15, min_observations=2)) == [[0, 1], [2, 3, 4]]


def test_a_small_run_between_equals_joins_the_earlier() -> None:
    rows = looks(one_hot(0), one_hot(0), one_hot(1), one_hot(2), one_hot(2))
    assert members(build(rows, min_observations=2)) == [[0, 1, 2], [3, 4]]


def test_small_runs_grow_together_until_they_are_large_enough() -> None:
    rows = looks(*(mixed(base, base + i, 0.3) for base in (0, 4) for i in (1, 2, 3)))
    assert members(build(rows, theta=0.1)) == [[0], [1], [2], [3], [4], [5]]
    assert members(build(rows, theta=0.1, min_observations=3)) == [[0, 1, 2], [3, 4, 5]]


def test_a_small_run_alone_in_its_session_stays() -> None:
    rows = drive([0, 0]) + drive([1], session=1) + drive([1, 1], session=2)
    assert members(build(rows, min_observations=2)) == [[0, 1], [2], [3, 4]]


def test_a_new_session_starts_a_new_place_without_an_edge() -> None:
    built = build(drive([0, 0]) + drive([0, 0, 1], session=1))
    assert members(built) == [[0, 1], [2, 3], [4]]
    assert [(edge.source, edge.target) for edge in built.topomap.edges] == [(1, 2)]
    assert np.isnan(built.novelty[[0, 2]]).all()


def test_novelty_across_sessions_is_not_a_novelty() -> None:
    rows = drive([0, 0]) + drive([1, 2], session=1)
    assert consecutive_novelty(Toy(), rows).tolist() == [0.0, 1.0]


def test_labels_decide_the_places_where_training_is_guided() -> None:
    labels = ["", "lab", "", "hall", "lab", "lab"]
    built = build(drive([0, 1, 2, 3, 4, 5], labels=labels), guided=True)
    assert members(built) == [[0, 1, 2, 4, 5], [3]]
    assert [place.label for place in built.topomap.places] == ["lab", "hall"]
    assert [(edge.source, edge.target) for edge in built.topomap.edges] == [(0, 1), (1, 0)]
    assert np.isnan(built.threshold)


def test_a_label_does_not_hold_over_into_the_next_session() -> None:
    rows = drive([0, 0], labels=["lab", ""]) + drive([0, 0], session=1, labels=["", "hall"])
    assert places_by_label(rows).tolist() == [0, 0, 1, 1]


def test_guided_training_of_a_session_without_labels_is_refused() -> None:
    rows = drive([0], labels=["lab"]) + drive([0], session=1)
    with pytest.raises(LogError, match="session 1 has no label"):
        build(rows, guided=True)


def test_a_map_of_nothing_is_refused() -> None:
    with pytest.raises(LogError, match="no signatures"):
        build([])


def test_progress_counts_every_signature_once() -> None:
    for guided in (False, True):
        done: list[int] = []
        rows = drive([0, 0, 1], labels=["a", "b", "b"])
        build_map(Toy(), rows, guided=guided, advance=done.append)
        assert sum(done) == 3


runs = st.lists(st.tuples(st.integers(0, 5), st.integers(1, 4)), min_size=1, max_size=6)


@given(st.lists(runs, min_size=1, max_size=3), st.integers(1, 4))
def test_every_map_keeps_its_invariants(sessions: list[list[tuple[int, int]]], least: int) -> None:
    rows: list[Signature] = []
    for session, stays in enumerate(sessions):
        rows += drive([place for place, times in stays for _ in range(times)], session=session)
    built = build(rows, min_observations=least)
    check_map(built.topomap, len(rows))
    owner = built.topomap.owner(len(rows))
    session_of = np.array([row.reference.session for row in rows])
    assert built.topomap.ids.tolist() == list(range(len(built.topomap)))
    assert (np.diff(owner) >= 0).all()
    assert owner[0] == 0
    for place in built.topomap.places:
        (session,) = set(session_of[list(place.members)].tolist())
        alone = len(place.members) == int((session_of == session).sum())
        assert len(place.members) >= least or alone
    joined = [
        (int(a), int(b))
        for (a, s), (b, t) in pairwise(zip(owner, session_of, strict=True))
        if a != b and s == t
    ]
    assert [(edge.source, edge.target) for edge in built.topomap.edges] == joined


@given(runs, st.integers(1, 5))
def test_absorbing_changes_nothing_where_no_run_is_small(
    stays: list[tuple[int, int]], least: int
) -> None:
    rows = drive([place for place, times in stays for _ in range(times)])
    owner = np.repeat(np.arange(len(stays)), [times for _, times in stays])
    absorbed = absorb_small(Toy(), rows, owner, least)
    if all(times >= least for _, times in stays):
        assert absorbed.tolist() == owner.tolist()
    assert absorb_small(Toy(), rows, absorbed, least).tolist() == absorbed.tolist()
