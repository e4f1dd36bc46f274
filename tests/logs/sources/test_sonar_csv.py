"""Sonar rings in CSV."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fpnav.errors import LogError, LossError
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest

HEADER = "stamp_s,range_0,range_-90,range_-180,range_90.5"


def write(path: Path, *rows: str, header: str = HEADER) -> Path:
    path.write_text("\n".join([header, *rows, ""]))
    return path


def test_a_ring_stands_as_its_columns_say(tmp_path: Path) -> None:
    rows = ["0.0,1.0,2.0,5.0,5.0", "0.111111,1.1,,5.0,4.0", "", "0.222222,1.2,2.2,3.0,4.0"]
    done = ingest([write(tmp_path / "ring.csv", *rows)], tmp_path / "out.mcap")
    assert done.format == "sonar_csv"
    assert done.messages == {"sonar": 3}
    assert "readings of 5 m are nothing in range" in done.ledger.remarks["saturated"]
    with open_log(tmp_path / "out.mcap") as log:
        rings = [frame.sonar for frame in log.frames()]
        assert log.primary == "sonar"
        assert [r.stamp_ns for r in log.references()] == [0, 111_111_000, 222_222_000]
    assert np.array_equal(rings[0].ranges_m, np.array([1, 2, np.inf, np.inf], np.float32))
    assert math.isnan(rings[1].ranges_m[1])
    bearings = np.degrees(rings[0].mounts[:, 2])
    assert np.allclose(bearings[[0, 1, 3]], [0, -90, 90.5])
    assert abs(bearings[2]) == pytest.approx(180)
    assert not rings[0].mounts[:, :2].any()
    assert rings[0].field_of_view_rad == pytest.approx(math.pi / 2)
    assert rings[0].range_max_m == 5.0


def test_a_largest_reading_that_comes_once_is_a_reading(tmp_path: Path) -> None:
    ingest([write(tmp_path / "a.csv", "0.0,1.0,2.0,3.0,4.0")], tmp_path / "out.mcap")
    with open_log(tmp_path / "out.mcap") as log:
        ring = next(iter(log.frames())).sonar
    assert ring is not None
    assert ring.ranges_m.tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize("row", ["1.0,1,2,3", "soon,1,2,3,4", "1.0,a,2,3,4", "nan,1,2,3,4"])
def test_rows_that_are_none_are_counted(row: str, tmp_path: Path) -> None:
    with pytest.raises(LossError, match="1 of 2 messages lost"):
        ingest([write(tmp_path / "a.csv", "0.0,1,2,3,4", row)], tmp_path / "out.mcap")


def test_a_header_that_is_none_and_an_empty_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"first line is 'stamp_s,range_0,left'"):
        ingest([write(tmp_path / "a.csv", header="stamp_s,range_0,left")], tmp_path / "out.mcap")
    with pytest.raises(LogError, match="E206 no reading"):
        ingest([write(tmp_path / "b.csv")], tmp_path / "out.mcap")
