"""``info`` and ``check`` on whatever a person has: folders, and formats that are no containers."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from helpers import encodings
from helpers import robot_logs as robot
from helpers.commands import run

LINES = "".join(
    f"ODOM {i * 0.1} 0 0 0.1 0 0 {i}.1 host {i}.1\n"
    f"FLASER 5 1.0 2.0 81.83 3.0 4.0 {i * 0.1} 0 0 {i * 0.1} 0 0 {i}.2 host {i}.2\n"
    for i in range(400)
)


def test_every_file_of_a_folder_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for part in (10, 9):
        sent = [(robot.at(part), robot.scan(robot.at(part)))]
        robot.write(tmp_path / f"run_{part}.mcap", sent)
    told = run(capsys, "info", tmp_path, "--json")
    names = [json.loads(line)["name"] for line in told.out.splitlines()]
    assert names == ["run_9.mcap", "run_10.mcap"]
    checked = run(capsys, "check", tmp_path)
    assert checked.code == 0
    assert [line for line in checked.out.splitlines() if line.endswith(":")] == [
        f"{tmp_path / name}:" for name in names
    ]


@pytest.mark.parametrize("write", [encodings.write_db3, None], ids=["db3", "bag"])
def test_folders_of_bags_are_read_in_place(
    write: object, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"
    if write is None:
        folder.mkdir()
        encodings.write_bag(folder / "a.bag")
    else:
        encodings.write_db3(folder)
    told = run(capsys, "info", folder)
    assert told.code == 0
    assert "bag" in told.out.splitlines()[0] or "db3" in told.out.splitlines()[0]
    assert run(capsys, "ingest", folder, "-o", tmp_path / "a.mcap").code == 0


def test_a_text_log_is_told_as_it_would_be_ingested(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "drive.log"
    path.write_text(LINES)
    told = run(capsys, "info", path)
    assert told.out.startswith("drive.log: carmen recording, ")
    assert "unverified" in told.out.splitlines()[0]
    assert "path 39.9 m by odometry" in told.out
    assert "note poses: scan poses are odometry" in told.out
    assert run(capsys, "check", path).code == 0
    assert sorted(tmp_path.iterdir()) == [path]


def test_damage_of_a_text_log_is_told_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = gzip.compress(LINES.encode(), mtime=0)
    path = tmp_path / "drive.log.gz"
    path.write_bytes(whole[: len(whole) // 2])
    told = run(capsys, "info", path)
    assert told.out.splitlines()[0].endswith("damaged")
    assert "damage: E102 packed text is cut off" in told.out
    assert run(capsys, "check", path).code == 3
    assert run(capsys, "check", path, "--allow-truncated").code == 0
    done = run(capsys, "ingest", path, "-o", tmp_path / "a.mcap", "--allow-truncated", "--json")
    assert 100 < json.loads(done.out)["messages"]["scan"] < 400


@pytest.mark.parametrize("kept", [3, 12, 25])
def test_a_packed_log_cut_in_its_first_bytes_is_not_called_empty(
    kept: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "drive.log.gz"
    path.write_bytes(gzip.compress(LINES.encode(), mtime=0)[:kept])
    done = run(capsys, "ingest", path, "-o", tmp_path / "a.mcap")
    assert done.code in (1, 3)
    assert "E102" in done.err
    assert len(done.err.splitlines()) == 1
