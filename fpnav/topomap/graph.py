"""Places and directed edges over networkx; the graph stays visible as ``TopoMap.graph``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.values import Place


@dataclass(frozen=True, slots=True)
class Edge:
    """One travelled direction between two places.

    ``length_m`` : mean odometric length between the places' middle members;
    ``bearing_out_rad`` : direction of travel on leaving, in the frame of the source place;
    ``bearing_in_rad`` : direction one came from on arriving, in the frame of the target place;
    NaN where there is no odometry. ``count`` : how often it was travelled.
    """

    source: int
    target: int
    length_m: float
    bearing_out_rad: float
    bearing_in_rad: float
    count: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class TopoMap:
    """A topological map: nodes are place ids with ``place``, arcs carry ``edge``."""

    graph: nx.DiGraph

    @staticmethod
    def of(places: Iterable[Place], edges: Iterable[Edge]) -> TopoMap:
        """Map of the given places and edges; ids ascending, so that equal maps are equal files.

        Raises
        ------
        StoreError
            Two places with one id, or two edges between the same places.
        """
        graph = nx.DiGraph()
        for place in sorted(places, key=lambda place: place.id):
            if place.id in graph:
                raise StoreError(f"two places have the id {place.id}")
            graph.add_node(place.id, place=place)
        for edge in sorted(edges, key=lambda edge: (edge.source, edge.target)):
            if graph.has_edge(edge.source, edge.target):
                raise StoreError(f"two edges go from place {edge.source} to {edge.target}")
            graph.add_edge(edge.source, edge.target, edge=edge)
        return TopoMap(graph)

    def __len__(self) -> int:
        return int(self.graph.number_of_nodes())

    @property
    def ids(self) -> NDArray[np.int64]:
        """Place ids, ascending."""
        return np.array(list(self.graph.nodes), dtype=np.int64)

    @property
    def places(self) -> tuple[Place, ...]:
        """Places by ascending id."""
        return tuple(place for _, place in self.graph.nodes(data="place"))

    @property
    def edges(self) -> tuple[Edge, ...]:
        """Edges by (source, target)."""
        return tuple(edge for _, _, edge in self.graph.edges(data="edge"))

    def place(self, place_id: int) -> Place:
        """The place with that id."""
        found: Place = self.graph.nodes[place_id]["place"]
        return found

    def neighbours(self, place_id: int) -> list[int]:
        """Places one edge away in either direction, ascending."""
        return sorted({*self.graph.successors(place_id), *self.graph.predecessors(place_id)})

    def owner(self, signatures: int) -> NDArray[np.int64]:
        """Place id that owns each of so many signatures, -1 where none does."""
        owner = np.full(signatures, -1, dtype=np.int64)
        for place in self.places:
            owner[list(place.members)] = place.id
        return owner


def check_map(topomap: TopoMap, signatures: int) -> None:
    """Refuse a map that breaks an invariant.

    Raises
    ------
    StoreError
        No places, a self-loop, an edge without its places, a member that is not a signature or
        belongs to two places, a length that is negative or not finite.
    """
    if len(topomap) == 0:
        raise StoreError("map has no places")
    seen: set[int] = set()
    for node, place in topomap.graph.nodes(data="place"):
        if place is None:
            raise StoreError(f"edge to place {node}, which does not exist")
        _check_place(place, signatures, seen)
        seen.update(place.members)
    for edge in topomap.edges:
        _check_edge(edge)


def _check_place(place: Place, signatures: int, seen: set[int]) -> None:
    if not place.members:
        raise StoreError(f"place {place.id} has no signatures")
    for member in place.members:
        if not 0 <= member < signatures:
            raise StoreError(f"place {place.id}: member {member} of {signatures} signatures")
        if member in seen:
            raise StoreError(f"signature {member} belongs to two places")
    if not 0 <= place.extent_m < math.inf:
        raise StoreError(f"place {place.id}: extent {place.extent_m} m")


def _check_edge(edge: Edge) -> None:
    name = f"edge {edge.source}-{edge.target}"
    if edge.source == edge.target:
        raise StoreError(f"place {edge.source} has an edge to itself")
    if not 0 <= edge.length_m < math.inf:
        raise StoreError(f"{name}: length {edge.length_m} m")
    if edge.count < 1:
        raise StoreError(f"{name}: travelled {edge.count} times")
    if math.isinf(edge.bearing_out_rad) or math.isinf(edge.bearing_in_rad):
        raise StoreError(f"{name}: a bearing is infinite")
