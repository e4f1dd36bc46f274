"""``fpnav report`` through the real command line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.results import header, recognition

from fpnav.store.results import write_result

SCORES = [[0.9, 0.2], [0.3, 0.8], [0.7, 0.6]]


def fpnav(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    code = "from fpnav.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONWARNINGS": "error"},
        check=False,
    )


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("home")
    (home / "other").mkdir()
    result = recognition(SCORES, pairs={0: [0], 1: [1], 2: [1]})
    write_result(home / "run.h5", result)
    write_result(home / "other" / "run.h5", result)
    return home


def test_the_path_of_the_page_is_printed_and_nothing_else(home: Path) -> None:
    done = fpnav(
        "report", "run.h5", "-o", "out", "--fail-under", "recall_at_1=0.5",
        "--stats-json", "stats.json", cwd=home,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "out: report on run\n")
    assert json.loads((home / "stats.json").read_text())["wall_s"] > 0
    assert done.stdout == "out/index.html\n"
    assert (home / "out" / "index.html").is_file()


def test_a_gate_missed_ends_with_4_after_the_report_is_written(home: Path) -> None:
    done = fpnav(
        "report", "run.h5", "other/run.h5", "-o", "gated", "--json",
        "--fail-under", "recall_at_1=0.9", "--fail-under", "ece=0.1", cwd=home,
    )  # fmt: skip
    assert done.returncode == 4
    said = json.loads(done.stdout)
    assert (said["page"], said["results"]) == ("gated/index.html", ["run", "run-2"])
    assert done.stderr.startswith("fpnav: error: gate not met: run: recall_at_1 is 0.6667 (2 of 3)")
    assert "run-2: ece is absent: no probabilities are stated" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--fail-under", "recall=1"], 2, "expected METRIC=VALUE"),
        (["--fail-under", "recall_at_1=high"], 2, "'high' is not a number"),
        (["--fail-under", "recall_at_1=nan"], 2, "'nan' is not a number"),
        (["nowhere.h5"], 1, "nowhere.h5"),
        (["--threshold-from", "nowhere.h5"], 1, "nowhere.h5"),
    ],
)
def test_wrong_words_and_missing_files_are_one_known_error(
    home: Path, arguments: list[str], code: int, message: str
) -> None:
    done = fpnav("report", "run.h5", *arguments, "-o", "none", cwd=home)
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (home / "none").exists()


def test_a_report_that_exists_is_kept_where_asked(home: Path) -> None:
    (home / "kept").mkdir()
    (home / "kept" / "index.html").write_text("mine")
    done = fpnav("report", "run.h5", "-o", "kept", "--no-clobber", cwd=home)
    assert done.returncode == 2
    assert "kept/index.html: exists and --no-clobber is set" in done.stderr
    assert [path.name for path in (home / "kept").iterdir()] == ["index.html"]


def test_thresholds_of_another_run_are_reported_and_can_be_a_gate(home: Path) -> None:
    facts = header("recognize", sources=[{"name": "day 1"}])
    scores = [[0.9, 0.2], [0.3, 0.8]]
    write_result(home / "day1.h5", recognition(scores, pairs={0: [0], 1: [1]}, header=facts))
    done = fpnav(
        "report", "run.h5", "-o", "carried", "--threshold-from", "day1.h5",
        "--fail-under", "precision_at_carried_100=0.9", cwd=home,
    )  # fmt: skip
    assert done.returncode == 4
    (result,) = json.loads((home / "carried" / "report.json").read_text())["results"]
    found = result["metrics"]["precision_at_carried_100"]
    assert (found["n"], found["of"]) == (2, 3)
    assert "threshold for 100 % on day1" in (home / "carried" / "index.html").read_text()
