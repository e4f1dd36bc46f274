"""Each check says what holds, what does not, and what to do about it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.commands import run
from helpers.logs import START_NS, STEP_NS, drive, jpeg, log_bytes, ring, scan, write_log

from fpnav.logs import messages
from fpnav.logs.checks.finding import Finding
from fpnav.logs.checks.registry import check_log
from fpnav.logs.frames import open_log
from fpnav.logs.ledger import Budget
from fpnav.logs.writer import LogWriter
from fpnav.values import Calibration, LaserScan, Pose2

Fill = Callable[[LogWriter], None]


def findings(path: Path) -> list[Finding]:
    with open_log(path, max_loss=1.0, allow_truncated=True) as log:
        return check_log(log, Budget())


def found(path: Path, check: str) -> list[tuple[str, str]]:
    return [(f.level, f.code) for f in findings(path) if f.check == check]


def test_a_good_log_passes_every_check(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        for i in range(20):
            stamp = START_NS + i * STEP_NS
            writer.label(stamp, "hall")
            writer.odometry(stamp, Pose2(0.05 * i, 0.01 * i, 0.01 * i))
            writer.truth(stamp, Pose2(0.05 * i, 0.0, 0.0))
            writer.scan(stamp, scan(range_m=1.0 + i / 10))

    levels = {f.level for f in findings(write_log(tmp_path / "a.mcap", fill))}
    assert levels == {"ok"}


def every(step_ns: int, count: int, send: Callable[[LogWriter, int, int], None]) -> Fill:
    def fill(writer: LogWriter) -> None:
        for i in range(count):
            send(writer, i, START_NS + i * step_ns)

    return fill


def gap(writer: LogWriter) -> None:
    for i in range(10):
        writer.scan(START_NS + i * STEP_NS + (5 * 10**9 if i > 5 else 0), scan())


def late(writer: LogWriter) -> None:
    for i in (0, 2, 1, 3):
        writer.scan(START_NS + i * STEP_NS, scan(range_m=1.0 + i), log_ns=START_NS + 9)


def clocks(writer: LogWriter) -> None:
    for i in range(5):
        writer.scan(START_NS + i, scan(), log_ns=START_NS + 100 * 10**9 + i)


def few_hits(writer: LogWriter) -> None:
    nothing = LaserScan(np.full(8, np.inf, np.float32), 0.0, 0.1, 0.1, 10.0)
    writer.scan(START_NS, nothing)


def unplaced(writer: LogWriter) -> None:
    made = messages.laser_scan(START_NS, "somewhere", scan())
    writer.message("/scan", messages.LASER_SCAN, made, START_NS, None)


def image_sizes(writer: LogWriter) -> None:
    for i in range(4):
        writer.image("camera", START_NS + i, jpeg(32 + 8 * i))


def leak(writer: LogWriter) -> None:
    for i in range(20):
        stamp, pose = START_NS + i * STEP_NS, Pose2(0.05 * i, 0.0, 0.0)
        writer.odometry(stamp, pose)
        writer.truth(stamp, pose)
        writer.scan(stamp, scan())


def millimetres(writer: LogWriter) -> None:
    for i in range(20):
        writer.odometry(START_NS + i * STEP_NS, Pose2(50.0 * i, 0.0, 0.0))
        writer.scan(START_NS + i * STEP_NS, scan())


def elsewhere(writer: LogWriter) -> None:
    writer.truth(START_NS + 10**12, Pose2(0, 0, 0))
    writer.scan(START_NS, scan())


@pytest.mark.parametrize(
    ("check", "fill", "expected"),
    [
        ("roles", lambda w: w.heading(START_NS, 0.1), ("fail", "E206")),
        ("roles", lambda w: w.scan(START_NS, scan()), ("warn", "E206")),
        ("gaps", gap, ("warn", "B10")),
        ("order", late, ("warn", "E201")),
        ("log-time", clocks, ("warn", "B7")),
        ("scans", few_hits, ("warn", "E505")),
        ("mounts", unplaced, ("warn", "E503")),
        ("images", image_sizes, ("warn", "E408")),
        ("calibration", image_sizes, ("warn", "E503")),
        ("drift", leak, ("warn", "E505")),
        ("motion", millimetres, ("warn", "E13")),
        ("coverage", elsewhere, ("fail", "E205")),
        ("sonar", lambda w: w.sonar(START_NS, ring(4)), ("ok", "")),
        ("labels", lambda w: w.scan(START_NS, scan()), ("note", "")),
    ],
)
def test_each_fault_is_found_by_its_check(
    check: str, fill: Fill, expected: tuple[str, str], tmp_path: Path
) -> None:
    assert expected in found(write_log(tmp_path / "a.mcap", fill), check)


def test_a_calibrated_camera_is_not_complained_of(tmp_path: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.camera_info("camera", START_NS, Calibration(32, 16, horizontal_fov_rad=1.0))
        writer.image("camera", START_NS, jpeg())

    assert found(write_log(tmp_path / "a.mcap", fill), "calibration") == [("ok", "")]


@pytest.mark.parametrize(
    ("data", "code", "word"),
    [
        (log_bytes(drive), 0, "ok "),
        (log_bytes(lambda w: w.heading(START_NS, 0.1)), 1, "FAIL"),
        (log_bytes(drive, "none")[:-12000], 3, "LOSS"),
    ],
)
def test_the_command_ends_with_the_code_of_the_worst(
    data: bytes, code: int, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.mcap").write_bytes(data)
    before = (tmp_path / "a.mcap").read_bytes()
    outcome = run(capsys, "check", tmp_path / "a.mcap")
    assert outcome.code == code
    assert word in outcome.out
    assert (tmp_path / "a.mcap").read_bytes() == before
    as_json = run(capsys, "check", tmp_path / "a.mcap", "--json")
    assert as_json.code == code
    assert {"check", "level", "code", "message", "fix"} == set(
        json.loads(as_json.out)["findings"][0]
    )
