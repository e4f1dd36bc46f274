"""Real recordings go in by one command, or are refused in one line; counts as others count."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from fpnav.errors import LogError
from fpnav.logs.frames import open_log
from fpnav.logs.ingest import ingest


@dataclass(frozen=True)
class Recording:
    """What a recording of shared/data must come to."""

    path: str
    messages: dict[str, int]
    frames: int
    path_m: float | None


RECORDINGS = [
    Recording(
        "laser/carmen/freiburg-079-corrected.log.gz", {"scan": 4791, "truth": 4791}, 4791, 423
    ),
    Recording("laser/carmen/intel-corrected.log.gz", {"scan": 910, "truth": 910}, 910, 500),
    Recording("laser/carmen/belgioioso-corrected.log.gz", {"scan": 395, "truth": 395}, 395, 219),
    Recording("laser/intel_raw/intel_raw.log.gz", {"odometry": 2726, "scan": 2726}, 2726, 506),
    Recording("laser/wean_hall/robotdata1.log.gz", {"odometry": 1505, "scan": 713}, 713, None),
    Recording("laser/wean_hall/robotdata3.log.gz", {"odometry": 1735, "scan": 1241}, 1241, None),
    Recording("images/rtabmap_samples", {"calibration:camera": 1, "camera": 84}, 84, None),
    Recording(
        "images/bob_route/train",
        {"calibration:camera": 1, "camera": 455, "truth": 1861},
        455,
        11,
    ),
    Recording("bags/birmingham_p3dx/trace0.bag", {"odometry": 958, "scan": 958}, 958, 31.7),
    Recording(
        "bags/olin_turtlebot4/macfirst_floor_take_2", {"odometry": 920, "scan": 357}, 357, 8.3
    ),
    Recording("sonar/scitos_ring/ring.csv", {"sonar": 5456}, 5456, None),
    Recording(
        "images/bob_route/test", {"calibration:camera": 1, "camera": 94, "truth": 1564}, 94, None
    ),
]


@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda recording: recording.path)
def test_a_recording_goes_in_whole(recording: Recording, data: Path, tmp_path: Path) -> None:
    done = ingest([data / recording.path], tmp_path / "log.mcap")
    assert done.messages == recording.messages
    with open_log(tmp_path / "log.mcap", strict=True) as log:
        references = log.references()
        assert log.integrity == "verified"
        assert sum(1 for _ in log.frames()) == recording.frames == len(references)
        if recording.path_m is not None:
            assert references[-1].travelled_m == pytest.approx(recording.path_m, abs=1.0)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("mcap/wifi/real_4_2_0.mcap", r"E206 .*holds wifi_interface/msg/WifiList"),
        ("mcap/wifi/zero_bytes.mcap", "E101 empty file"),
        ("laser/wean_hall/wean.dat.gz", "E100 looks like a text file; known formats are"),
        ("images/rtabmap_samples/truth.json", "E100 looks like a text file"),
        ("scores/vprbench_corridor.npz", "E100 a zip of 10 files, expected one"),
    ],
)
def test_what_is_no_recording_is_refused_in_one_line(
    path: str, message: str, data: Path, tmp_path: Path
) -> None:
    with pytest.raises(LogError, match=message) as caught:
        ingest([data / path], tmp_path / "log.mcap")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "log.mcap").exists()
