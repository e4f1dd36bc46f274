"""Node-link JSON, as ``networkx.node_link_graph(data, edges="edges")`` and d3 read it."""

from __future__ import annotations

import json

import networkx as nx

from fpnav.export.graph import graph_of
from fpnav.export.subject import Subject


def write(subject: Subject) -> bytes:
    """The map; keys sorted, no NaN."""
    data = nx.node_link_data(graph_of(subject), edges="edges")
    text = json.dumps(data, indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False)
    return text.encode() + b"\n"
