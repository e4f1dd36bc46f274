"""g2o pose graphs that carry their scans: VERTEX_SE2, EDGE_SE2 and ROBOTLASER1 lines.

The scan behind a vertex was taken there. Vertices are optimised poses: truth, unless
``poses=odometry`` says otherwise. Edges from each vertex to the next are what the odometry
measured: their chain is the odometry, as far as it reaches. Plain, gzip, or a zip of one file.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from fpnav.errors import LogError, LossError
from fpnav.geometry import compose
from fpnav.logs.carmen_lines import parse
from fpnav.logs.ledger import InputFile, Ledger
from fpnav.logs.sources.base import Item, Motion, SourceOptions
from fpnav.logs.text import lines, text_facts
from fpnav.values import Pose2

SUMMARY = "g2o with ROBOTLASER1 lines, plain, .gz or .zip"

_SIGNS = (b"VERTEX_SE2", b"EDGE_SE2", b"VERTEX_SE3", b"FIX ", b"PARAMS_")
_SILENT = ("#", "FIX", "PARAMS_")
"""Lines that hold no measurement."""

_NONE, _BROKEN_ID = -(2**63), -(2**63) + 1
"""Instead of a vertex's id: scans before any vertex, and behind one that cannot be read."""

_VERTEX, _EDGE, _SCAN = "VERTEX_SE2 ", "EDGE_SE2 ", "ROBOTLASER1 "


@dataclass(slots=True)
class Graph:
    """Vertices by id, in the order of the file, and the edge from each to the next."""

    vertices: dict[int, Pose2] = field(default_factory=dict)
    edges: dict[tuple[int, int], Pose2] = field(default_factory=dict)
    scans: int = 0


def recognises(path: Path, head: bytes) -> bool:
    """A text whose first line that is no comment is one of g2o's."""
    first = next((line for line in head.splitlines() if line and not line.startswith(b"#")), b"")
    return first.startswith(_SIGNS)


def read(paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
    """Scans with truth and odometry of one graph after another."""
    for path in paths:
        facts = text_facts(path)
        ledger.inputs.append(facts)
        graph = _graph(path, facts, ledger)
        if graph.scans == 0 and facts.damage:
            raise LossError(f"{path}: {facts.damage}; no scan is left")
        if graph.scans == 0:
            raise LogError(f"{path}: E206 no ROBOTLASER1 line; a graph without scans has no places")
        yield from _items(path, facts, graph, options, ledger)


def _graph(path: Path, facts: InputFile, ledger: Ledger) -> Graph:
    """Vertices and edges of the whole file; lines that are not whole are counted."""
    graph = Graph()
    for number, text in lines(path, facts):
        if text.startswith(_SCAN):
            graph.scans += 1
        elif text.startswith((_VERTEX, _EDGE)):
            try:
                _take(graph, text.split())
            except (ValueError, IndexError) as error:
                ledger.topic(text.split(None, 1)[0]).skipped["E305"] += 1
                ledger.note("E305", f"{path.name} line {number}: {error}")
        elif text and not text.startswith(_SILENT):
            ledger.note("lines", f"line {number}: {text.split(' ', 1)[0]} is not read")
    return graph


def _take(graph: Graph, words: list[str]) -> None:
    if words[0] == _VERTEX.strip():
        graph.vertices[int(words[1])] = _pose(words[2:5])
    else:
        graph.edges.setdefault((int(words[1]), int(words[2])), _pose(words[3:6]))


def _pose(words: Sequence[str]) -> Pose2:
    x, y, heading = (float(word) for word in words)
    if not abs(x) + abs(y) + abs(heading) < float("inf"):
        raise ValueError(f"pose {x} {y} {heading}")
    return Pose2(x, y, heading)


def _odometry(graph: Graph, ledger: Ledger) -> dict[int, Pose2]:
    """Dead-reckoned pose of each vertex, from the first one on, until an edge is missing."""
    ids = list(graph.vertices)
    found = {ids[0]: Pose2(0.0, 0.0, 0.0)} if ids else {}
    for before, after in pairwise(ids):
        step = graph.edges.get((before, after))
        if step is None:
            ledger.note("E505", f"no edge from vertex {before} to {after}; odometry ends there")
            break
        found[after] = compose(found[before], step)
    return found


def _items(
    path: Path, facts: InputFile, graph: Graph, options: SourceOptions, ledger: Ledger
) -> Iterator[Item]:
    truth_role = options.poses != "odometry"
    odometry = _odometry(graph, ledger) if truth_role else {}
    count = ledger.topic("ROBOTLASER1")
    vertex = _NONE
    for number, text in lines(path, facts):
        if text.startswith(_VERTEX):
            vertex = _id(text)
        if not text.startswith(_SCAN):
            continue
        try:
            line = parse(text)
        except (ValueError, IndexError) as error:
            count.skipped["E305"] += 1
            ledger.note("E305", f"{path.name} line {number}: {error}")
            continue
        count.used += 1
        pose = graph.vertices.get(vertex, line.robot if vertex == _NONE else None)
        if truth_role:
            if pose is not None:
                yield Item("truth", line.stamp_ns, pose)
            if vertex in odometry:
                yield Item("odometry", line.stamp_ns, Motion(odometry[vertex]))
        elif pose is not None:
            yield Item("odometry", line.stamp_ns, Motion(pose))
        yield Item("scan", line.stamp_ns, line.scan)


def _id(text: str) -> int:
    """Id on a VERTEX_SE2 line; one that no vertex has where it cannot be read."""
    word = next(iter(text.split()[1:]), "")
    return int(word) if word.removeprefix("-").isdecimal() else _BROKEN_ID
