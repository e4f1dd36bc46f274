"""A map keeps its order, and one that breaks an invariant is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import networkx as nx
import pytest

from fpnav.errors import StoreError
from fpnav.topomap.graph import Edge, TopoMap, check_map
from fpnav.values import Place

A, B, C = Place(1, (0, 1), 2.0), Place(4, (2,), 0.0, label="hall"), Place(7, (3, 5), 1.0)
AB, BC, BA = Edge(1, 4, 1.0, 0.0, 3.0), Edge(4, 7, 2.0, math.nan, math.nan), Edge(4, 1, 1.0, 3.0, 0)


@pytest.fixture
def corridor() -> TopoMap:
    return TopoMap.of([C, A, B], [BC, BA, AB])


def test_places_and_edges_come_in_order_whatever_order_they_were_given(corridor: TopoMap) -> None:
    assert corridor.ids.tolist() == [1, 4, 7]
    assert corridor.places == (A, B, C)
    assert corridor.edges == (AB, BA, BC)
    assert len(corridor) == 3


def test_a_place_is_found_by_its_id(corridor: TopoMap) -> None:
    assert corridor.place(4) is B


def test_neighbours_are_one_edge_away_in_either_direction(corridor: TopoMap) -> None:
    assert [corridor.neighbours(place) for place in (1, 4, 7)] == [[4], [1, 7], [4]]


def test_every_signature_has_its_owner_or_none(corridor: TopoMap) -> None:
    assert corridor.owner(7).tolist() == [1, 1, 4, 7, -1, 7, -1]


def test_networkx_stays_visible(corridor: TopoMap) -> None:
    assert nx.shortest_path(corridor.graph, 1, 7) == [1, 4, 7]


def test_a_sound_map_passes(corridor: TopoMap) -> None:
    check_map(corridor, 6)


def test_two_places_with_one_id_are_refused() -> None:
    with pytest.raises(StoreError, match="two places have the id 1"):
        TopoMap.of([A, replace(B, id=1)], [])


def test_two_edges_between_the_same_places_are_refused() -> None:
    with pytest.raises(StoreError, match="two edges go from place 1 to 4"):
        TopoMap.of([A, B], [AB, AB])


@pytest.mark.parametrize(
    ("places", "edges", "said"),
    [
        ([], [], "map has no places"),
        ([replace(A, members=())], [], "place 1 has no signatures"),
        ([replace(A, members=(6,))], [], "place 1: member 6 of 6 signatures"),
        ([replace(A, members=(-1,))], [], "place 1: member -1 of 6 signatures"),
        ([A, replace(B, members=(1,))], [], "signature 1 belongs to two places"),
        ([replace(A, extent_m=math.nan)], [], "place 1: extent nan m"),
        ([replace(A, extent_m=-1.0)], [], r"place 1: extent -1\.0 m"),
        ([A], [AB], "edge to place 4, which does not exist"),
        ([A], [Edge(1, 1, 1.0, 0.0, 0.0)], "place 1 has an edge to itself"),
        ([A, B], [replace(AB, length_m=-1.0)], r"edge 1-4: length -1\.0 m"),
        ([A, B], [replace(AB, length_m=math.nan)], "edge 1-4: length nan m"),
        ([A, B], [replace(AB, length_m=math.inf)], "edge 1-4: length inf m"),
        ([A, B], [replace(AB, count=0)], "edge 1-4: travelled 0 times"),
        ([A, B], [replace(AB, bearing_out_rad=math.inf)], "edge 1-4: a bearing is infinite"),
    ],
)
def test_a_map_that_breaks_an_invariant_is_refused(
    places: list[Place], edges: list[Edge], said: str
) -> None:
    with pytest.raises(StoreError, match=said):
        check_map(TopoMap.of(places, edges), 6)
