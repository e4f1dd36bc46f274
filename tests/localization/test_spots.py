"""What a run says of the spots of the mapping path: by places first, then by the views there."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.toy_system import Toy, mixed, signature_of

from fpnav.localization.filter import FilterParams
from fpnav.localization.recall import recall_all
from fpnav.localization.spots import (
    Along,
    along_spots,
    frame_scores,
    recall_spots,
    spread,
    view_likelihood,
)
from fpnav.mapping.places import learned, make_edges, make_places
from fpnav.topomap.graph import TopoMap
from fpnav.values import Pose2, Reference, Signature

OWNER = np.repeat(np.arange(5), 4)


def seen_at(row: int, index: int | None = None) -> Signature:
    """Half of what is seen is the place's, half is seen at this row only: a mean of the place holds
    a quarter of that for each of its rows, so that it tells none of them."""
    at = row if index is None else index
    pose = Pose2(0.5 * at, 0.0, 0.0)
    view = mixed(int(OWNER[row]), 5 + row, 0.5, bins=25)
    return signature_of(Reference(at, at, 0, 0.5 * at, pose), view)


MAPPED = [seen_at(row) for row in range(len(OWNER))]


def along(queries: list[Signature], **changes: float) -> Along:
    system, params = Toy(), FilterParams(**changes)
    graph = TopoMap.of(make_places(MAPPED, OWNER), make_edges(MAPPED, OWNER))
    memory = learned(system, MAPPED, OWNER)
    spots = recall_spots(memory, graph, MAPPED, params)
    assert spots is not None
    assert len(spots.rows) == len(MAPPED)
    recall = recall_all(memory, queries, len(graph), None, lambda done: None)
    return along_spots(system, graph, MAPPED, queries, recall, spots, params)


def test_the_views_of_a_place_tell_its_spots_apart_where_its_mean_does_not() -> None:
    queries = [seen_at(row, index) for index, row in enumerate([9, 10, 11])]
    by_means = along(queries, asked=0).likelihood
    assert np.ptp(by_means[1, OWNER == 2]) == pytest.approx(0.0)
    by_views = along(queries).likelihood
    assert by_views.argmax(axis=1).tolist() == [9, 10, 11]
    assert by_views[1, 10] > 10.0 * by_views[1, 9]


def test_without_weight_the_views_are_not_asked() -> None:
    queries = [seen_at(row, index) for index, row in enumerate([9, 10, 11])]
    np.testing.assert_array_equal(
        along(queries, seen=0.0).likelihood, along(queries, asked=0).likelihood
    )


def test_only_the_spots_that_are_asked_are_scored() -> None:
    asked = np.zeros((2, 3), bool)
    asked[0, [0, 2]] = asked[1, 1] = True
    rows = np.array([4, 8, 12])
    found = frame_scores(Toy(), MAPPED, [seen_at(8), seen_at(12)], rows, asked)
    assert np.isfinite(found).tolist() == asked.tolist()
    assert found[0, [0, 2]].tolist() == [0.0, 0.0]
    assert found[1, 1] == 0.0
    everywhere = frame_scores(Toy(), MAPPED, [seen_at(8)], rows, np.ones((1, 3), bool))
    assert everywhere.tolist() == [[0.0, 1.0, 0.0]]


def test_a_view_counts_by_how_far_scores_lie_apart() -> None:
    scores = np.array([[0.2, 0.7, np.nan]])
    told = view_likelihood(scores, 0.5, 6.0)
    np.testing.assert_allclose(told, [[np.exp(-6.0), 1.0, np.exp(-6.0)]])
    np.testing.assert_allclose(view_likelihood(100.0 * scores + 3.0, 50.0, 6.0), told)


@pytest.mark.parametrize("unit", [0.0, 0.5])
def test_views_that_were_not_asked_or_cannot_differ_say_nothing(unit: float) -> None:
    nothing = np.full((1, 3), np.nan) if unit else np.array([[0.4, 0.4, 0.4]])
    assert view_likelihood(nothing, unit, 6.0).tolist() == [[1.0, 1.0, 1.0]]


def test_the_spread_leaves_out_what_is_rare() -> None:
    scores = np.concatenate([np.linspace(0.0, 1.0, 1001), [np.nan, -np.inf]])
    assert spread(scores) == pytest.approx(0.95)
    assert spread(np.full(3, np.nan)) == 0.0


def test_a_robot_set_down_elsewhere_is_looked_for_by_its_view() -> None:
    """By belief alone it would be sought where it was, and 17 be told from no other spot there."""
    queries = [seen_at(row, index) for index, row in enumerate([*range(8), 17])]
    told = along(queries, asked=8, kidnap=1e-12).likelihood[-1]
    assert told.argmax() == 17
    assert told[17] > 10.0 * told[16]
