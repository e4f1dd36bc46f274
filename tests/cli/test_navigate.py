"""``fpnav navigate``: a robot is taught the way home in a small room, and finds it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.commands import run

from fpnav.store.results import read_result

CELLS = ("-s", "placecell", "--preset", "fig7b", "--set", "placecell.rho_l=1",
         "--set", "placecell.qmax=0")  # fmt: skip
EYE = ("--set", "panorama.width_px=480", "--set", "panorama.height_px=80")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map of eight places about a goal, and the log it was taught with beside it."""
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def taught(home: Path) -> Path:
    import subprocess
    import sys

    log, topomap = home / "home.mcap", home / "home.h5"
    simulate = ("simulate", "room", "--route", "homing", "--length", "7.3", *EYE, "-o", log)
    build = ("build-map", log, *CELLS, "--labels", "guided", "--no-loops", "-o", topomap)
    for words in (simulate, build):
        subprocess.run([sys.executable, "-m", "fpnav", *map(str, words)], check=True)
    return topomap


@pytest.mark.timeout(200)
def test_a_robot_comes_home_and_its_log_gives_the_same_actions(
    capsys: pytest.CaptureFixture[str], taught: Path, tmp_path: Path
) -> None:
    words = ("--map", taught, "--goal", "goal")
    drive = ("--trips", 2, "--period", 0.5, "--seconds", 20, *EYE, "-o", tmp_path / "run.h5")
    done = run(capsys, "navigate", "room", *words, *map(str, drive), "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["homing_success"] == [2, 2]
    driven = read_result(tmp_path / "run.h5")
    asked = run(capsys, "navigate", tmp_path / "run.mcap", *words, "-o", tmp_path / "asked.h5")
    assert asked.code == 0, asked.err
    again = read_result(tmp_path / "asked.h5")
    assert len(again.actions) == len(driven.actions) == len(driven.queries)
    same = again.actions["place"] == driven.actions["place"]
    assert same.mean() > 0.9
    report = run(capsys, "report", tmp_path / "run.h5", "-o", tmp_path / "page")
    assert report.code == 0
    figures = json.loads((tmp_path / "page" / "report.json").read_text())["results"][0]
    assert figures["metrics"]["homing_success"]["n"] == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("room",), "one of --goal PLACE and --route NAME"),
        (("room", "--goal", "goal", "--route", "line"), "one of --goal PLACE and --route NAME"),
        (("suburb", "--route", "loop"), "learned in world room --seed 1"),
        (("room", "--seed", "2", "--goal", "goal"), "learned in world room --seed 1"),
        (("nowhere", "--goal", "goal"), "no world"),
        (("room", "--goal", "attic"), "no place 'attic'"),
        (("room", "--route", "attic"), "no route 'attic'"),
        (("room", "--goal", "goal", "--policy", "luck"), "no policy 'luck'"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    capsys: pytest.CaptureFixture[str],
    taught: Path,
    tmp_path: Path,
    words: tuple[str, ...],
    said: str,
) -> None:
    done = run(capsys, "navigate", *words, "--map", taught, "-o", tmp_path / "run.h5")
    assert done.code in (1, 2)
    assert said in done.err
    assert len(done.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())
