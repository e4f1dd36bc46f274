"""CARMEN logs: what is scan, what is odometry, what is truth."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from fpnav.errors import LogError, LossError
from fpnav.logs.carmen_lines import parse
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.sources.base import SourceOptions
from fpnav.logs.sources.carmen import recognises
from fpnav.values import Pose2


def flaser(
    stamp: float, pose: tuple[float, float, float], count: int = 180, range_m: float = 2.0,
    ahead_m: float = 0.0,
) -> str:  # fmt: skip
    x, y, heading = pose
    laser = (x + ahead_m * math.cos(heading), y + ahead_m * math.sin(heading), heading)
    words = ["FLASER", count, *[range_m] * count, *laser, *pose, stamp, "host", stamp]
    return " ".join(str(word) for word in words)


def odom(stamp: float, pose: tuple[float, float, float]) -> str:
    return f"ODOM {pose[0]} {pose[1]} {pose[2]} 0.4 0.1 0 {stamp} host {stamp}"


def write(path: Path, *lines: str) -> Path:
    text = "\n".join(["# a comment", "PARAM robot_use_laser on host 0", *lines, ""])
    path.write_bytes(gzip.compress(text.encode()) if path.suffix == ".gz" else text.encode())
    return path


def drive(*, extra: tuple[str, ...] = (), ahead_m: float = 0.0) -> list[str]:
    lines = list(extra)
    for i in range(5):
        pose = (0.5 * i, 0.0, 0.0)
        lines += [
            odom(10.0 + i, pose),
            flaser(10.05 + i, pose, range_m=1.0 + i, ahead_m=ahead_m),
        ]
    return lines


@pytest.mark.parametrize("suffix", [".log", ".log.gz"])
def test_a_raw_log_gives_scans_and_odometry(suffix: str, tmp_path: Path) -> None:
    source = write(tmp_path / f"drive{suffix}", *drive(ahead_m=0.25))
    done = ingest([source], tmp_path / "out.mcap")
    assert done.messages == {"odometry": 5, "scan": 5}
    with open_log(tmp_path / "out.mcap") as log:
        frames = list(log.frames())
    assert [frame.reference.stamp_ns for frame in frames] == [
        10_050_000_000 + i * 10**9 for i in range(5)
    ]
    assert frames[2].reference.odometry == Pose2(pytest.approx(1.025), 0.0, 0.0)
    assert frames[2].reference.truth is None
    assert frames[2].scan is not None
    assert frames[2].scan.mount == Pose2(pytest.approx(0.25), 0.0, 0.0)


def test_a_corrected_log_gives_truth_and_no_odometry(tmp_path: Path) -> None:
    source = write(tmp_path / "drive.log", *drive(extra=("NEFF 30",)))
    done = ingest([source], tmp_path / "out.mcap")
    assert done.messages == {"scan": 5, "truth": 5}
    assert done.ledger.topic("ODOM").skipped == {"unused": 5}
    with open_log(tmp_path / "out.mcap") as log:
        assert log.travelled_from == "truth"
        assert log.references()[4].truth == Pose2(pytest.approx(2.0), 0.0, 0.0)


def test_the_name_tells_a_corrected_log_too_and_the_user_has_the_last_word(tmp_path: Path) -> None:
    source = write(tmp_path / "hall-corrected.log", *drive())
    assert "truth" in ingest([source], tmp_path / "a.mcap").messages
    options = SourceOptions(poses="odometry")
    assert "odometry" in ingest([source], tmp_path / "b.mcap", options=options).messages


def test_scan_poses_are_odometry_where_there_are_no_odom_lines(tmp_path: Path) -> None:
    source = write(tmp_path / "a.log", *(flaser(float(i), (0.5 * i, 0, 0)) for i in range(1, 5)))
    assert ingest([source], tmp_path / "out.mcap").messages == {"odometry": 4, "scan": 4}


def test_true_poses_of_a_simulator_are_truth(tmp_path: Path) -> None:
    true = "TRUEPOS 1.0 2.0 0.5 9 9 9 10.0 host 10.0"
    source = write(tmp_path / "a.log", flaser(10.0, (0, 0, 0)), true, flaser(10.1, (0, 0, 0)))
    ingest([source], tmp_path / "out.mcap")
    with open_log(tmp_path / "out.mcap") as log:
        assert log.references()[0].truth == Pose2(1.0, 2.0, pytest.approx(0.5))


@pytest.mark.parametrize(
    ("count", "step_deg", "last_deg"),
    [(180, 1.0, 89.0), (181, 1.0, 90.0), (360, 0.5, 89.5), (361, 0.5, 90.0), (91, 2.0, 90.0)],
)
def test_beams_are_placed_as_carmen_places_them(
    count: int, step_deg: float, last_deg: float
) -> None:
    scan = parse(flaser(1.0, (0, 0, 0), count)).scan
    assert scan is not None
    assert scan.angle_min_rad == pytest.approx(-math.pi / 2)
    assert math.degrees(scan.angle_increment_rad) == pytest.approx(step_deg)
    assert math.degrees(scan.bearings_rad[-1]) == pytest.approx(last_deg)


@pytest.mark.parametrize(
    ("code", "real"), [(81.91, 81.0 - 1.5), (81.83, 30.0), (8.191, 8.1), (8.187, 8.182)]
)
def test_codes_of_the_scanner_are_nothing_in_range(
    code: float, real: float, tmp_path: Path
) -> None:
    lines = [flaser(1.0, (0, 0, 0), range_m=real), flaser(2.0, (0, 0, 0), range_m=code)]
    ingest([write(tmp_path / "a.log", *lines)], tmp_path / "out.mcap")
    with open_log(tmp_path / "out.mcap") as log:
        first, second = (frame.scan for frame in log.frames())
    assert np.allclose(first.ranges_m, real)
    assert np.isposinf(second.ranges_m).all()
    assert not second.valid.any()


def test_a_robotlaser_line_says_its_own_geometry(tmp_path: Path) -> None:
    ranges = " ".join(["3.0", "90.0", "4.0"])
    line = (
        f"ROBOTLASER1 0 -0.5 1.0 0.5 20.0 0.01 0 3 {ranges} 2 7 8 "
        "1.1 0.0 0.0 1.0 0.0 0.0 0.3 0.1 0 0 0 100.5 my host 100.5"
    )
    parsed = parse(line.replace("my host", "host"))
    assert parsed.scan is not None
    assert parsed.scan.ranges_m.tolist() == [3.0, math.inf, 4.0]
    assert parsed.scan.bearings_rad.tolist() == [-0.5, 0.0, 0.5]
    assert parsed.scan.range_max_m == 20.0
    assert parsed.speeds == (0.3, 0.1)
    assert (parsed.robot, parsed.laser) == (Pose2(1.0, 0.0, 0.0), Pose2(1.1, 0.0, 0.0))
    assert parsed.stamp_ns == 100_500_000_000
    assert parse(line).stamp_ns == 100_500_000_000


def test_lines_that_are_not_whole_are_counted(tmp_path: Path) -> None:
    lines = [*drive(), "FLASER 180 1.0 2.0", "ODOM 1 2", flaser(16.0, (math.nan, 0, 0))]
    source = write(tmp_path / "a.log", *lines)
    with pytest.raises(LossError, match="FLASER: 2 of 7 messages lost"):
        ingest([source], tmp_path / "out.mcap")


def test_stamps_that_repeat_are_made_from_the_order(tmp_path: Path) -> None:
    lines = [flaser(1.01893e9, (0.5 * i, 0, 0)) for i in range(5)]
    source = write(tmp_path / "x-corrected.log", *lines)
    done = ingest([source], tmp_path / "out.mcap")
    assert "made from the order" in done.ledger.remarks["B6"]
    with open_log(tmp_path / "out.mcap") as log:
        references = log.references()
    assert [r.stamp_ns for r in references] == [i * 100_000_000 for i in range(5)]
    assert [r.truth.x_m for r in references if r.truth] == [0.5 * i for i in range(5)]


def test_a_gzip_cut_off_gives_what_is_whole_when_allowed(tmp_path: Path) -> None:
    source = write(tmp_path / "a.log.gz", *drive(), *drive(), *drive())
    source.write_bytes(source.read_bytes()[:-30])
    with pytest.raises(LossError, match=r"a\.log\.gz: E102 packed text is cut off"):
        ingest([source], tmp_path / "out.mcap")


def test_a_log_without_scans_is_refused(tmp_path: Path) -> None:
    source = write(tmp_path / "a.log", odom(1.0, (0, 0, 0)))
    with pytest.raises(LogError, match="E206 no FLASER or ROBOTLASER1"):
        ingest([source], tmp_path / "out.mcap")


def test_other_texts_are_not_taken_for_carmen() -> None:
    assert recognises(Path("a"), b"# comment\nPARAM x y\n")
    assert recognises(Path("a"), b"FLASER 180 1 1")
    assert not recognises(Path("a"), b"robot_specifications->resolution 10\n")
    assert not recognises(Path("a"), b"# only a comment\n")
    assert not recognises(Path("a"), b"")
