"""Each format read back by the tool that reads it, or by its own rules; nothing guessed, no NaN."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import networkx as nx
import numpy as np
import pytest
from helpers.results import header, office_run, on_map, recognition, rows

from fpnav.errors import StoreError
from fpnav.export.subject import Subject, estimates
from fpnav.export.table import FORMATS, export
from fpnav.store.tables import Result

LINE = [[x, 0.0, 0.5] for x in range(4)]


def subject(result: Result | None = None, **fields: Any) -> Subject:
    """Three places in a line: 0 -> 1 travelled both ways, 1 -> 2 one way."""
    base = on_map(
        LINE, [0, 1, 2, 2], [[0.1, 0, 0.5], [2.9, 0, 0.5]], [[0], [2]],
        edges=[(0, 1), (1, 0), (1, 2)],
    )  # fmt: skip
    if result is not None:
        base = result
    whole = Subject(
        name="map.h5",
        header=header(),
        view=replace(base.view, strips=("ab", "=c", "")[: len(base.view.place_ids)]),
        labels=("hall", "\x1b[31m", "")[: len(base.view.place_ids)],
        references=base.references,
        owner=base.owner,
        result=result,
    )
    return replace(whole, **fields)


def test_graphml_comes_back_with_places_edges_and_what_is_known_of_them() -> None:
    graph = nx.read_graphml(io.BytesIO(export(subject(), "graphml")), node_type=int)
    assert sorted(graph.nodes) == [0, 1, 2]
    assert sorted(graph.edges) == [(0, 1), (1, 0), (1, 2)]
    assert graph.nodes[2]["x_m"] == 2.5
    assert graph.nodes[2]["observations"] == 2
    assert graph.nodes[0]["label"] == "hall"
    assert graph.nodes[1]["label"] == "\ufffd[31m"
    assert "label" not in graph.nodes[2]
    assert graph.edges[0, 1]["length_m"] == 1.0


def test_unknown_bearings_are_left_out_of_graphml() -> None:
    plain = subject()
    edges = plain.view.edges.copy()
    edges["bearing_out_rad"] = np.nan
    text = export(replace(plain, view=replace(plain.view, edges=edges)), "graphml")
    assert b"bearing_out_rad" not in text
    assert b"bearing_in_rad" in text
    ElementTree.fromstring(text)


def test_node_link_json_comes_back_equal() -> None:
    data = json.loads(export(subject(), "json"), parse_constant=pytest.fail)
    graph = nx.node_link_graph(data, edges="edges")
    assert graph.is_directed()
    assert sorted(graph.edges) == [(0, 1), (1, 0), (1, 2)]
    assert graph.nodes[0]["signature"] == "ab"


def test_geojson_keeps_the_rules_of_the_route_server() -> None:
    data = json.loads(export(subject(), "geojson"), parse_constant=pytest.fail)
    points = [f for f in data["features"] if f["geometry"]["type"] == "Point"]
    lines = [f for f in data["features"] if f["geometry"]["type"] == "MultiLineString"]
    ids = [f["properties"]["id"] for f in data["features"]]
    assert len(set(ids)) == len(ids)
    assert all(isinstance(number, int) and number >= 0 for number in ids)
    directed = {(f["properties"]["startid"], f["properties"]["endid"]) for f in lines}
    assert directed == {(0, 1), (1, 0), (1, 2), (2, 1)}
    known = {f["properties"]["id"] for f in points}
    assert {end for pair in directed for end in pair} <= known
    assert all(f["properties"]["cost"] == 1.0 for f in lines)
    assert "null" not in json.dumps(data)
    assert points[2]["geometry"]["coordinates"] == [2.5, 0.0]


def test_a_route_server_needs_edges_and_positions() -> None:
    plain = subject()
    lonely = replace(plain, view=replace(plain.view, edges=plain.view.edges[:0]))
    with pytest.raises(StoreError, match=r"map.h5: the map has no edge"):
        export(lonely, "geojson")
    poses = plain.view.place_pose.copy()
    poses[1] = np.nan
    with pytest.raises(StoreError, match=r"place 1 has no position"):
        export(replace(plain, view=replace(plain.view, place_pose=poses)), "geojson")


@pytest.mark.parametrize("name", ["graphml", "json", "geojson"])
def test_a_result_without_a_map_has_no_graph(name: str) -> None:
    found = subject(recognition([[1.0]], pairs={0: [0]}))
    with pytest.raises(StoreError, match="holds no map of places"):
        export(found, name)


def tum_rows(data: bytes) -> list[list[str]]:
    return [line.split(" ") for line in data.decode().splitlines()]


def test_tum_of_a_map_is_the_mapping_run_with_exact_stamps() -> None:
    references = rows(LINE)
    references["stamp_ns"] += 1_700_000_000_123_456_789
    lines = tum_rows(export(subject(references=references), "tum"))
    assert [line[0] for line in lines[:2]] == ["1700000000.123456789", "1700000001.123456789"]
    assert [len(line) for line in lines] == [8] * 4
    assert float(lines[3][1]) == 3.0
    assert 2 * math.atan2(float(lines[0][6]), float(lines[0][7])) == pytest.approx(0.5)


def test_a_query_that_was_not_localized_has_no_line() -> None:
    result = on_map(LINE, [0, 1, 2, 2], LINE, [[0], [1], [2], [2]],
                    decision=np.array([0, -1, 2, -1]))  # fmt: skip
    lines = tum_rows(export(subject(result), "tum"))
    assert [line[0] for line in lines] == ["0.000000000", "2.000000000"]
    assert [float(line[1]) for line in lines] == [0.0, 2.0]


def test_a_verified_relative_pose_moves_the_estimate() -> None:
    result = on_map(LINE, [0, 1, 2, 2], [[0.5, 0.2, 0]], [[0]],
                    relative=np.array([[0.5, 0.0, 0.1]]))  # fmt: skip
    ((_, pose),) = estimates(result)
    assert (pose.x_m, pose.y_m) == pytest.approx((0.5 * math.cos(0.5), 0.5 * math.sin(0.5)))
    assert pose.heading_rad == pytest.approx(0.6)


def test_no_pose_at_all_is_said() -> None:
    references = rows(np.full((2, 3), np.nan))
    for name in ("tum", "g2o"):
        with pytest.raises(StoreError, match="neither truth nor odometry"):
            export(subject(references=references), name)


def test_g2o_holds_the_run_and_verified_poses_with_their_information() -> None:
    covariance = np.diag([0.04, 0.01, 0.0025])[None]
    result = on_map(LINE, [0, 1, 2, 2], [[2.9, 0, 0.5]], [[2]],
                    relative=np.array([[0.9, 0.0, 0.0]]), covariance=covariance)  # fmt: skip
    lines = [line.split() for line in export(subject(result), "g2o").decode().splitlines()]
    vertices = [line for line in lines if line[0] == "VERTEX_SE2"]
    edges = [line for line in lines if line[0] == "EDGE_SE2"]
    assert [line[1] for line in vertices] == ["0", "1", "2", "3", "4"]
    assert all(len(line) == 5 for line in vertices)
    assert all(len(line) == 12 for line in edges)
    assert edges[-1][1:3] == ["2", "4"]
    assert [float(x) for x in edges[-1][6:]] == pytest.approx([25, 0, 0, 100, 0, 400])
    step = [float(x) for x in edges[0][3:6]]
    assert step == pytest.approx([math.cos(0.5), -math.sin(0.5), 0.0])
    assert lines[-1] == ["FIX", "0"]


def test_g2o_joins_no_two_sessions() -> None:
    references = rows(LINE)
    references["session"] = [0, 0, 1, 1]
    text = export(subject(references=references), "g2o").decode()
    edges = [line.split()[1:3] for line in text.splitlines() if line.startswith("EDGE")]
    assert edges == [["0", "1"], ["2", "3"]]


def test_csv_of_a_map_has_a_row_per_place_and_no_formula() -> None:
    table = list(csv.DictReader(export(subject(), "csv").decode().splitlines()))
    assert [row["place"] for row in table] == ["0", "1", "2"]
    assert table[1]["signature"] == "'=c"
    assert table[2]["observations"] == "2"


def test_csv_of_a_result_has_a_row_per_query() -> None:
    run = office_run(step_m=2.0)
    table = list(csv.DictReader(export(subject(run), "csv").decode().splitlines()))
    assert len(table) == len(run.queries)
    assert {"outcome", "decision", "score"} <= set(table[0])


@pytest.mark.parametrize("name", [name for name in FORMATS if FORMATS[name].text])
def test_the_same_subject_gives_the_same_bytes(name: str) -> None:
    assert export(subject(), name) == export(subject(), name)
