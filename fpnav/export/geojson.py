"""GeoJSON as the Nav2 route server loads it: points with ids, directed edges, one id space.

The server knows directed edges alone, so every edge is written both ways; the cost is its length.
Positions are planar metres in the map's frame.
"""

from __future__ import annotations

import json
import math
from typing import Any

import networkx as nx

from fpnav.errors import StoreError
from fpnav.export.graph import graph_of
from fpnav.export.subject import Subject

FRAME = "map"


def write(subject: Subject) -> bytes:
    """The map as a FeatureCollection.

    Raises
    ------
    StoreError
        A place has no position, or there is no edge: the server refuses both.
    """
    graph = graph_of(subject)
    _check(subject, graph)
    features = [_point(place, facts) for place, facts in graph.nodes(data=True)]
    pairs = sorted({pair for a, b in graph.edges for pair in ((a, b), (b, a))})
    first = max(graph.nodes) + 1
    features += [_line(graph, first + row, *pair) for row, pair in enumerate(pairs)]
    collection = {
        "type": "FeatureCollection",
        "name": subject.name,
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}},
        "features": features,
    }
    text = json.dumps(collection, indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False)
    return text.encode() + b"\n"


def _check(subject: Subject, graph: nx.DiGraph) -> None:
    if not graph.number_of_edges():
        raise StoreError(f"{subject.name}: the map has no edge; a route server needs one")
    for place, facts in graph.nodes(data=True):
        if "x_m" not in facts or "y_m" not in facts:
            raise StoreError(
                f"{subject.name}: place {place} has no position: the mapping run had neither truth "
                "nor odometry"
            )


def _point(place: int, facts: dict[str, Any]) -> dict[str, Any]:
    kept = {name: facts[name] for name in ("extent_m", "label", "observations") if name in facts}
    return {
        "type": "Feature",
        "properties": {"id": place, "frame": FRAME, "metadata": kept},
        "geometry": {"type": "Point", "coordinates": [facts["x_m"], facts["y_m"]]},
    }


def _line(graph: nx.DiGraph, number: int, start: int, end: int) -> dict[str, Any]:
    ends = [[graph.nodes[place]["x_m"], graph.nodes[place]["y_m"]] for place in (start, end)]
    travelled = graph.edges[start, end] if graph.has_edge(start, end) else graph.edges[end, start]
    cost = travelled.get("length_m", math.dist(*ends))
    return {
        "type": "Feature",
        "properties": {
            "id": number,
            "startid": start,
            "endid": end,
            "cost": cost,
            "overridable": True,
        },
        "geometry": {"type": "MultiLineString", "coordinates": [ends]},
    }
