"""``fpnav ingest`` as a person or a Makefile meets it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from helpers.commands import run
from helpers.logs import drive, log_bytes, write_log

from fpnav.logs.frames import open_log


def test_a_log_goes_in_and_one_line_says_what_came_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_log(tmp_path / "a.mcap")
    outcome = run(capsys, "ingest", source, "-o", tmp_path / "out.mcap")
    assert outcome.code == 0
    assert outcome.out == ""
    assert outcome.err == (
        f"{tmp_path}/out.mcap: 111 messages from mcap: heading 12, label 2, odometry 12, "
        "panorama 12, scan 12, sonar 48, truth 12\n"
    )


def test_the_summary_is_one_json_line_when_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_log(tmp_path / "a.mcap")
    outcome = run(capsys, "ingest", source, "-o", tmp_path / "out.mcap", "--json")
    facts = json.loads(outcome.out)
    assert outcome.err == ""
    assert facts["output"] == "out.mcap"
    assert facts["format"] == "mcap"
    assert facts["messages"]["scan"] == 12
    assert facts["ledger"]["schema"] == "fpnav.ledger/1"
    for topic in facts["ledger"]["topics"]:
        assert topic["used"] + sum(topic["skipped"].values()) + topic["unread"] == topic["in_file"]


def test_ingesting_twice_gives_the_same_bytes_and_what_was_ingested_comes_out_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_log(tmp_path / "a.mcap")
    for name in ("one.mcap", "two.mcap"):
        assert run(capsys, "ingest", source, "-o", tmp_path / name, "-q").code == 0
    assert (tmp_path / "one.mcap").read_bytes() == (tmp_path / "two.mcap").read_bytes()
    with open_log(source) as before, open_log(tmp_path / "one.mcap") as after:
        assert before.references() == after.references()
        assert before.calibrations == after.calibrations


def test_a_damaged_log_ends_with_3_and_nothing_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "cut.mcap"
    source.write_bytes(log_bytes(drive, "none")[:-12000])
    refused = run(capsys, "ingest", source, "-o", tmp_path / "out.mcap")
    assert refused.code == 3
    assert refused.err.startswith("fpnav: error: cut.mcap: E102 truncated in ")
    assert refused.err.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.mcap"]
    allowed = run(capsys, "ingest", source, "-o", tmp_path / "out.mcap", "--allow-truncated")
    assert allowed.code == 0
    assert (tmp_path / "out.mcap").exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["{a}", "-o", "{a}"], 2, "output is also an input"),
        (["{a}", "-o", "{gone}/out.mcap"], 2, "does not exist; make it first"),
        (["{a}", "-o", "{out}", "--format", "dvd"], 2, "no such format"),
        (["{a}", "-o", "{out}", "--topic", "lidar=/scan"], 2, "expected role=/name"),
        (["{a}", "-o", "{out}", "--topic", "scan=/laser"], 1, "the log has /compass"),
        (["{gone}", "-o", "{out}"], 1, "no such file"),
        (["{a}", "-o", "{out}", "--role", "sonar"], 2, "is not one of"),
    ],
)  # fmt: skip
def test_a_wrong_request_is_one_line_and_its_code(
    words: list[str], code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = {
        "a": write_log(tmp_path / "a.mcap"),
        "out": tmp_path / "out.mcap",
        "gone": tmp_path / "gone",
    }
    outcome = run(capsys, "ingest", *(word.format(**names) for word in words))
    assert outcome.code == code
    assert said in outcome.err
    assert outcome.out == ""
    assert not (tmp_path / "out.mcap").exists()


def test_no_clobber_keeps_what_is_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = write_log(tmp_path / "a.mcap")
    (tmp_path / "out.mcap").write_bytes(b"mine")
    outcome = run(capsys, "ingest", source, "-o", tmp_path / "out.mcap", "--no-clobber")
    assert outcome.code == 2
    assert (tmp_path / "out.mcap").read_bytes() == b"mine"


def test_missing_calibration_is_given_by_hand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = write_log(tmp_path / "a.mcap")
    words = ["--vfov", "75", "--horizon-row", "6.5", "--role", "panorama"]
    run(capsys, "ingest", source, "-o", tmp_path / "out.mcap", *words)
    with open_log(tmp_path / "out.mcap") as log:
        found = log.calibrations["panorama"]
    assert found.vertical_fov_rad == pytest.approx(math.radians(75))
    assert found.horizon_row == pytest.approx(6.5)
