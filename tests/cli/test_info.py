"""``fpnav info`` on logs: one screen, or JSON."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import pytest
from helpers import mcaps, stores
from helpers.commands import run
from helpers.logs import START_NS, STEP_NS, drive, log_bytes, scan, write_log
from helpers.toy_system import Toy, ToyParams
from helpers.toy_system import drive as toy_drive

from fpnav.logs.writer import LogWriter
from fpnav.mapping.build import build_map
from fpnav.mapping.loops import LoopParams
from fpnav.store.maps import BuiltMap, write_map
from fpnav.store.results import write_result
from fpnav.store.signatures import collect, write_signatures


def test_a_log_is_told_on_one_screen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = run(capsys, "info", write_log(tmp_path / "a.mcap"))
    lines = outcome.out.splitlines()
    assert outcome.code == 0
    assert outcome.err == ""
    assert lines[0].startswith("a.mcap: MCAP log, ")
    assert lines[0].endswith("1.1 s, verified")
    assert lines[1] == "written by fpnav, profile ros2, 1 chunk zstd"
    assert any(line.split() == ["scan", "/scan", "sensor_msgs/msg/LaserScan", "12", "10"]
               for line in lines)  # fmt: skip
    assert "frames stand at the stamps of panorama" in lines
    assert "path 1.1 m by odometry" in lines
    assert "fingerprint: can run" in lines


def test_what_a_system_lacks_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_log(tmp_path / "a.mcap", lambda w: w.heading(START_NS, 0.5))
    outcome = run(capsys, "info", path)
    assert "fingerprint: lacks scan or panorama or omni or camera" in outcome.out


def test_lines_to_paste_are_offered_where_several_topics_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def fill(writer: LogWriter) -> None:
        for i in range(3):
            writer.scan(START_NS + i * STEP_NS, scan(), topic="/rear/scan")
            writer.scan(START_NS + i * STEP_NS, scan(), topic="/scan")

    outcome = run(capsys, "info", write_log(tmp_path / "a.mcap", fill))
    assert "scan is /scan; others:\n  --topic scan=/rear/scan\n" in outcome.out


def test_a_damaged_log_is_described_and_named_damaged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "cut.mcap").write_bytes(log_bytes(drive, "none")[:-12000])
    outcome = run(capsys, "info", tmp_path / "cut.mcap")
    assert outcome.code == 0
    assert outcome.out.splitlines()[0].endswith("damaged")
    assert "damage: E102 truncated in" in outcome.out


def test_names_from_a_log_do_no_harm_to_a_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = [mcaps.channel(1, "/a\n\x1b[31mred\u202e"), mcaps.message(1, 5, b"x")]
    (tmp_path / "a.mcap").write_bytes(mcaps.whole(*parts))
    outcome = run(capsys, "info", tmp_path / "a.mcap")
    assert r"/a\n\x1b[31mred\u202e" in outcome.out
    assert "\x1b" not in outcome.out


def test_json_holds_the_same_facts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_log(tmp_path / "a.mcap")
    outcome = run(capsys, "info", path, path, "--json")
    first, second = (json.loads(line) for line in outcome.out.splitlines())
    assert first == second
    assert first["kind"] == "log"
    assert first["integrity"] == "verified"
    assert first["roles"]["sonar"] == ["/sonar/0", "/sonar/1", "/sonar/2", "/sonar/3"]
    assert first["travelled_m"] == pytest.approx(1.1)
    assert first["systems"]["fingerprint"] == []


def stored(folder: Path) -> dict[str, Path]:
    """A file of each kind that the pipeline stores."""
    paths = {kind: folder / f"{kind}.h5" for kind in ("signatures", "map", "result")}
    write_signatures(paths["signatures"], stores.SIGNATURES_HEADER, stores.table())
    write_map(paths["map"], {**stores.MAP_HEADER, "guided": True}, stores.built_map())
    write_result(paths["result"], stores.result())
    return paths


@pytest.mark.parametrize(
    ("kind", "line"),
    [
        ("signatures", "3 signatures, 0.0 m, 2 sessions"),
        ("map", "3 places, 1 edge, 0 merged by closing loops"),
        ("result", "by filter against a map of 2 places"),
    ],
)
def test_a_stored_file_is_told_on_one_screen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, line: str
) -> None:
    outcome = run(capsys, "info", stored(tmp_path)[kind])
    lines = outcome.out.splitlines()
    assert outcome.code == 0
    assert lines[0].startswith(f"{kind}.h5: {kind}, ")
    assert lines[0].endswith(" kB, toy, preset default")
    assert lines[1].startswith("made by fpnav ")
    assert lines[1].endswith("from drive.mcap")
    assert line in lines
    assert lines[-2:] == ["parameters", "  theta = 0.5"]


def test_json_of_a_stored_file_holds_the_same_facts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = stored(tmp_path)
    outcome = run(capsys, "info", *paths.values(), "--json")
    signatures, built, result = (json.loads(line) for line in outcome.out.splitlines())
    assert (signatures["kind"], built["kind"], result["kind"]) == tuple(paths)
    assert signatures["sources"] == ["drive.mcap"]
    assert built["places"] == 3
    assert result["method"] == "filter"


def test_an_hdf5_file_of_others_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1
    outcome = run(capsys, "info", tmp_path / "other.h5")
    assert outcome.code == 1
    assert "other.h5" in outcome.err


def test_a_map_of_laps_says_how_long_a_lap_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = toy_drive([place for place in [*range(30), *range(30)] for _ in range(6)], bins=48)
    found = build_map(Toy(ToyParams()), rows, loops=LoopParams(), advance=lambda done: None)
    table = collect(rows, stores.RECORD, stores.PARTS)
    made = BuiltMap(found.topomap, table, found.novelty, found.threshold, found.memory.save())
    write_map(tmp_path / "laps.h5", stores.MAP_HEADER | {"guided": False}, made)
    outcome = run(capsys, "info", tmp_path / "laps.h5", "--json")
    facts = json.loads(outcome.out)
    assert facts["returns"] == 30
    assert facts["return_m"] == 180.0
    assert "median of 30 returns" in run(capsys, "info", tmp_path / "laps.h5").out
