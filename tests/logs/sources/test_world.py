"""What a simulated log says of its world is carried on, so that it is still called simulated."""

from __future__ import annotations

from pathlib import Path

from helpers.logs import drive, write_log

from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.writer import LogWriter


def simulated(writer: LogWriter) -> None:
    drive(writer)
    writer.attach("world.json", "application/json", b'{"world": "office"}')


def world_after_ingest(log: Path, out: Path) -> object:
    ingest([log], out)
    with open_log(out) as opened:
        return opened.world


def test_the_world_of_a_simulated_log_survives_ingest(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.mcap", simulated)
    assert world_after_ingest(log, tmp_path / "out.mcap") == {"world": "office"}


def test_a_recorded_log_gets_no_world(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log.mcap")
    assert world_after_ingest(log, tmp_path / "out.mcap") is None
