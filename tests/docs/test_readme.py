"""Every command line of README runs as it stands there, in order, in an empty folder."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

README = Path(__file__).resolve().parents[2] / "README.md"
BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)


@dataclass(frozen=True)
class Block:
    """One console block: its commands, and whether they use recordings."""

    number: int
    commands: tuple[str, ...]

    @property
    def needs_data(self) -> bool:
        return any("$FPNAV_DATA" in command for command in self.commands)


def console_blocks() -> list[Block]:
    blocks = []
    for number, match in enumerate(BLOCK.finditer(README.read_text(encoding="utf-8"))):
        joined = match[1].replace("\\\n", " ")
        lines = [line[2:].strip() for line in joined.splitlines() if line.startswith("$ ")]
        blocks.append(Block(number, tuple(lines)))
    return blocks


def fpnav_blocks(*, with_data: bool) -> list[Block]:
    return [
        block
        for block in console_blocks()
        if any(command.startswith("fpnav ") for command in block.commands)
        and block.needs_data == with_data
    ]


def run(command: str, folder: Path, environment: dict[str, str]) -> None:
    expanded = os.path.expandvars(command.replace("$FPNAV_DATA", environment["FPNAV_DATA"]))
    words = shlex.split(expanded)
    assert words[0] == "fpnav", f"README runs {words[0]!r}"
    done = subprocess.run(
        [sys.executable, "-m", "fpnav", *words[1:]],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stderr}"


@pytest.fixture
def folder(tmp_path: Path, root: Path) -> Path:
    (tmp_path / "sample_logs").symlink_to(root / "sample_logs")
    return tmp_path


@pytest.mark.timeout(280)
@pytest.mark.parametrize("block", fpnav_blocks(with_data=False), ids=lambda block: block.number)
def test_commands_on_sample_logs_run(block: Block, folder: Path) -> None:
    environment = {**os.environ, "FPNAV_DATA": "unused"}
    for command in block.commands:
        run(command, folder, environment)


@pytest.mark.slow
@pytest.mark.parametrize("block", fpnav_blocks(with_data=True), ids=lambda block: block.number)
def test_commands_on_recordings_run(block: Block, folder: Path, data: Path) -> None:
    environment = {**os.environ, "FPNAV_DATA": str(data)}
    for command in block.commands:
        run(command, folder, environment)


def test_make_targets_that_readme_names_exist(root: Path) -> None:
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    named = set(re.findall(r"`make ([a-z-]+)`", README.read_text(encoding="utf-8")))
    named |= {
        command.split()[1]
        for block in console_blocks()
        for command in block.commands
        if command.startswith("make ")
    }
    assert named
    for target in named:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"README names make {target}"


def test_readme_shows_a_picture_that_is_in_the_repository(root: Path) -> None:
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", README.read_text(encoding="utf-8"))
    assert pictures
    for picture in pictures:
        assert (root / picture).is_file()
