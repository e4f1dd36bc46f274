"""The map of a subject as a networkx graph with plain attributes, for formats that take one."""

from __future__ import annotations

import math
import re
from typing import Any

import networkx as nx
import numpy as np

from fpnav.export.subject import Subject, places_of

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def graph_of(subject: Subject) -> nx.DiGraph:
    """Directed graph: nodes are place ids in order, arcs the travelled directions.

    Attributes are numbers and text; what is unknown is left out.

    Raises
    ------
    StoreError
        There are no places.
    """
    places_of(subject)
    graph = nx.DiGraph(name=subject.name, system=str(subject.header.get("system", "")))
    members = dict(zip(*np.unique(subject.owner, return_counts=True), strict=True))
    view = subject.view
    for row, place in enumerate(view.place_ids.tolist()):
        x, y, heading = view.place_pose[row].tolist()
        graph.add_node(
            place,
            **_known(
                x_m=x,
                y_m=y,
                heading_rad=heading,
                extent_m=float(view.extent_m[row]),
                observations=int(members.get(place, 0)),
                label=subject.labels[row],
                signature=subject.strip(row),
            ),
        )
    for edge in sorted(view.edges.tolist()):
        source, target, length_m, out_rad, in_rad, count = edge
        facts = _known(
            length_m=length_m, bearing_out_rad=out_rad, bearing_in_rad=in_rad, count=count
        )
        graph.add_edge(source, target, **facts)
    return graph


def _known(**values: Any) -> dict[str, Any]:
    """The values that say something, text without characters XML cannot hold."""
    kept = {}
    for name, value in values.items():
        if isinstance(value, str):
            value = _NOT_XML.sub("\ufffd", value)
        if value == "" or (isinstance(value, float) and not math.isfinite(value)):
            continue
        kept[name] = value
    return kept
