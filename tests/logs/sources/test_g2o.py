"""g2o graphs with scans: vertices are truth, the chain of edges is odometry."""

from __future__ import annotations

import gzip
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fpnav.errors import LogError, LossError
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.sources.base import SourceOptions
from fpnav.logs.text import lines
from fpnav.values import Pose2


def laser(stamp: float, pose: str = "9 9 0", range_m: float = 2.0) -> str:
    ranges = " ".join([str(range_m)] * 4 + ["50.0"])
    head = "ROBOTLASER1 0 -1.0 2.0 0.5 50.0 0.1 0 5"
    return f"{head} {ranges} 0 {pose} {pose} 0 0 0 0 0 {stamp} host 5.0"


def graph() -> list[str]:
    """Three vertices a metre apart on a line; the odometry measured 1.1 m each and drifts left."""
    body = ["# a graph", "FIX 7"]
    for i in range(3):
        body += [f"VERTEX_SE2 {7 + i} {i}.0 0.0 0.0", laser(100.0 + i, range_m=1.0 + i)]
    body += ["#SEQUENTIAL"]
    body += [f"EDGE_SE2 {7 + i} {8 + i} 1.1 0.0 0.1 1 0 0 1 0 1" for i in range(2)]
    return [*body, "EDGE_SE2 7 9 2.0 0.0 0.0 1 0 0 1 0 1", ""]


@pytest.mark.parametrize("packing", [".g2o", ".g2o.gz", ".g2o.zip"])
def test_a_graph_gives_scans_truth_and_odometry(packing: str, tmp_path: Path) -> None:
    path = tmp_path / f"hall{packing}"
    text = "\n".join(graph()).encode()
    if packing.endswith(".zip"):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("__MACOSX/._hall.g2o", b"noise")
            archive.writestr("hall.g2o", text)
    else:
        path.write_bytes(gzip.compress(text) if packing.endswith(".gz") else text)
    done = ingest([path], tmp_path / "out.mcap")
    assert done.format == "g2o"
    assert done.messages == {"odometry": 3, "scan": 3, "truth": 3}
    with open_log(tmp_path / "out.mcap") as log:
        frames = list(log.frames())
    assert [frame.reference.truth.x_m for frame in frames if frame.reference.truth] == [0, 1, 2]
    odometry = frames[2].reference.odometry
    assert odometry is not None
    assert odometry.x_m == pytest.approx(1.1 + 1.1 * np.cos(0.1))
    assert odometry.heading_rad == pytest.approx(0.2)
    assert frames[1].scan is not None
    assert frames[1].scan.ranges_m.tolist() == [2, 2, 2, 2, np.inf]
    assert frames[1].reference.stamp_ns == 101 * 10**9


def test_vertices_are_odometry_when_the_user_says_so(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_text("\n".join(graph()))
    options = SourceOptions(poses="odometry")
    done = ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap", options=options)
    assert done.messages == {"odometry": 3, "scan": 3}
    with open_log(tmp_path / "out.mcap") as log:
        assert log.references()[2].odometry == Pose2(2.0, 0.0, 0.0)


def test_odometry_ends_where_an_edge_is_missing(tmp_path: Path) -> None:
    rows = [row for row in graph() if not row.startswith("EDGE_SE2 8 9")]
    (tmp_path / "a.g2o").write_text("\n".join(rows))
    done = ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap")
    assert done.messages["odometry"] == 2
    assert "no edge from vertex 8 to 9" in done.ledger.remarks["E505"]


def test_damaged_lines_are_counted(tmp_path: Path) -> None:
    rows = [*graph(), "VERTEX_SE2 10 here 0 0", "ROBOTLASER1 0 -1.0 2.0", "EDGE_SE2 1"]
    (tmp_path / "a.g2o").write_text("\n".join(rows))
    with pytest.raises(LossError, match="messages lost"):
        ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap")


@pytest.mark.parametrize("line", ["VERTEX_SE2 ", "VERTEX_SE2 - 0 0 0", "VERTEX_SE2 9x 0 0 0"])
def test_scans_of_a_vertex_that_cannot_be_read_have_no_truth(line: str, tmp_path: Path) -> None:
    rows = [line if row.startswith("VERTEX_SE2 9") else row for row in graph()]
    (tmp_path / "a.g2o").write_text("\n".join(rows))
    budget = Budget(max_loss=1.0)
    done = ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap", budget=budget)
    assert done.messages["scan"] == 3
    assert done.messages["truth"] == 2


def test_lines_of_other_kinds_are_noted(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_text("\n".join([*graph(), "VERTEX_XY 4 1 1", "# end"]))
    done = ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap")
    assert done.ledger.notes["lines"] == 1
    assert "VERTEX_XY is not read" in done.ledger.remarks["lines"]


def test_a_graph_without_scans_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_text("VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n")
    with pytest.raises(LogError, match="E206 no ROBOTLASER1 line"):
        ingest([tmp_path / "a.g2o"], tmp_path / "out.mcap")


def test_zips_that_are_not_one_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "two.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.g2o", "FIX 1")
        archive.writestr("../b.g2o", "FIX 2")
    with pytest.raises(LogError, match="E100 a zip of 2 files, expected one"):
        ingest([path], tmp_path / "out.mcap")
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(LogError, match="cut off or damaged"):
        list(lines(path))


def test_text_has_bounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "long.txt"
    path.write_bytes(b"x" * 2**20 + b"\n")
    with pytest.raises(LogError, match="line 1 is over the limit"):
        list(lines(path))
    monkeypatch.setattr("fpnav.logs.limits.TEXT_BYTES", 10)
    path.write_bytes(b"short\n" * 3)
    with pytest.raises(LogError, match="line 2 is over the limit"):
        list(lines(path))
    assert Ledger().notes == {}
