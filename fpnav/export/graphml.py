"""GraphML, as networkx, Gephi and yEd read it."""

from __future__ import annotations

import io

import networkx as nx

from fpnav.export.graph import graph_of
from fpnav.export.subject import Subject


def write(subject: Subject) -> bytes:
    """The map with scalar attributes on nodes and edges."""
    buffer = io.BytesIO()
    nx.write_graphml_xml(graph_of(subject), buffer, named_key_ids=True)
    return buffer.getvalue() + b"\n"
