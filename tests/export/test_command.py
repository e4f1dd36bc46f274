"""``fpnav export`` through the real command line."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.results import on_map

from fpnav.cli.export import FORMATS as OFFERED
from fpnav.export.table import FORMATS
from fpnav.store.results import write_result


def fpnav(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    code = "from fpnav.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        check=False,
    )


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("home")
    line = [[float(x), 0.0, 0.0] for x in range(4)]
    write_result(home / "r.h5", on_map(line, [0, 0, 1, 1], line, [[0]] * 4, edges=[(0, 1)]))
    return home


def test_every_format_is_offered() -> None:
    assert tuple(FORMATS) == OFFERED


def test_text_goes_to_stdout_for_a_dash(home: Path) -> None:
    done = fpnav("export", "r.h5", "--to", "json", "-o", "-", cwd=home)
    assert (done.returncode, done.stderr) == (0, "")
    assert [node["id"] for node in json.loads(done.stdout)["nodes"]] == [0, 1]


def test_a_file_is_published_and_said_on_stderr(home: Path) -> None:
    done = fpnav("export", "r.h5", "--to", "tum", "-o", "path.tum", cwd=home)
    assert (done.returncode, done.stdout) == (0, "")
    assert done.stderr.startswith("path.tum: ")
    assert len((home / "path.tum").read_text().splitlines()) == 4


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["r.h5", "--to", "mcap", "-o", "-"], 2, "--to mcap is not text"),
        (["r.h5", "--to", "csv", "-o", "r.h5"], 2, "output is also an input"),
        (["none.h5", "--to", "csv", "-o", "x.csv"], 1, "none.h5"),
        (["r.h5", "--to", "gpx", "-o", "x"], 2, "'gpx' is not one of"),
    ],
)
def test_what_cannot_be_done_is_one_known_error(
    home: Path, arguments: list[str], code: int, message: str
) -> None:
    done = fpnav("export", *arguments, cwd=home)
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
