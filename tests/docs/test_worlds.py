"""Every line of docs/worlds.md that simulates a log does so, cut short, and the log reads back."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from fpnav.logs.frames import open_log
from fpnav.sim.catalogue import WORLDS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "worlds.md"
LINES = [line for line in PAGE.read_text().splitlines() if line.startswith("fpnav simulate ")]
SHORT = ("--set", "capture.length_m=1.5", "--quiet")
FEW = ("--places", "5", "--quiet")


def test_every_route_of_every_world_has_a_line_or_a_like_one() -> None:
    shown = {(words[2], words[4]) for words in map(shlex.split, LINES)}
    alike = {("office", f"loop-{k}") for k in range(2, 6)}
    alike |= {("gateways", "route-2"), ("gateways", "route-3")}
    alike |= {("gateway_types", f"type-{k:02d}") for k in range(1, 26)}
    known = {(world, route) for world, routes in WORLDS.items() for route in routes}
    assert shown | alike == known


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_a_line_of_the_page_makes_a_log_that_reads_back(line: str, tmp_path: Path) -> None:
    words = shlex.split(line)[1:]
    short = FEW if words[1] == "campus" else SHORT
    command = [sys.executable, "-m", "fpnav", *words, *short]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with open_log(tmp_path / words[words.index("-o") + 1]) as log:
        assert log.world is not None
        assert len(list(log.frames())) >= 2
