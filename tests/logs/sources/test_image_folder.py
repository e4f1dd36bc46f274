"""Folders of images with images.csv and truth.tum."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.logs import jpeg

from fpnav.errors import LogError, LossError, TruthError, UsageError
from fpnav.logs.frames import open_log
from fpnav.logs.images import encode_png
from fpnav.logs.ingest import ingest
from fpnav.logs.sources.base import SourceOptions
from fpnav.values import Calibration, Pose2

TUM = "# t tx ty tz qx qy qz qw\n0.9  1.0 2.0 0 0 0 0 1\r\n\n2.1\t3.0 2.0 0 0 0 1 0  \n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two images a second apart, a JPEG and a PNG, with truth around them."""
    path = tmp_path / "photos"
    (path / "sub").mkdir(parents=True)
    (path / "sub" / "a.jpg").write_bytes(jpeg())
    (path / "b.png").write_bytes(encode_png(np.full((10, 20), 90, np.uint8)))
    (path / "images.csv").write_text("stamp_s,file\n1.000000,sub/a.jpg\n2.000000,b.png\n")
    (path / "truth.tum").write_text(TUM)
    return path


def test_images_and_truth_come_in_and_stay_as_they_are(folder: Path, tmp_path: Path) -> None:
    done = ingest([folder], tmp_path / "out.mcap")
    assert done.format == "images"
    assert done.messages == {"calibration:camera": 1, "camera": 2, "truth": 2}
    with open_log(tmp_path / "out.mcap") as log:
        frames = list(log.frames())
    assert [frame.reference.stamp_ns for frame in frames] == [10**9, 2 * 10**9]
    assert [frame.camera.pixels.shape for frame in frames if frame.camera] == [
        (16, 32, 3),
        (10, 20, 3),
    ]
    truth = frames[1].reference.truth
    assert truth is not None
    assert truth.x_m == pytest.approx(1.0 + 2.0 * 1.1 / 1.2)


def test_the_role_and_the_calibration_are_the_users_to_say(folder: Path, tmp_path: Path) -> None:
    given = Calibration(0, 0, vertical_fov_rad=math.radians(75), horizon_row=6.0)
    options = SourceOptions(role="panorama", calibration=given)
    ingest([folder / "images.csv"], tmp_path / "out.mcap", options=options)
    with open_log(tmp_path / "out.mcap") as log:
        assert log.primary == "panorama"
        calibration = log.calibrations["panorama"]
    assert calibration.vertical_fov_rad == pytest.approx(math.radians(75))
    assert (calibration.width_px, calibration.horizon_row) == (32, 6.0)
    with pytest.raises(UsageError, match="--role sonar: images can be camera"):
        ingest([folder], tmp_path / "out.mcap", options=SourceOptions(role="sonar"))


@pytest.mark.parametrize("name", ["../b.png", "/etc/hostname", "sub/../../b.png", "a\x00b"])
def test_the_list_cannot_lead_out_of_its_folder(name: str, folder: Path, tmp_path: Path) -> None:
    (folder / "images.csv").write_text(f"stamp_s,file\n1.0,{name}\n")
    with pytest.raises(LogError, match=r"line 2: .* is not a file of the folder"):
        ingest([folder], tmp_path / "out.mcap")


def test_a_missing_image_is_named(folder: Path, tmp_path: Path) -> None:
    (folder / "b.png").unlink()
    with pytest.raises(LogError, match=r"b\.png: cannot be read: No such file"):
        ingest([folder], tmp_path / "out.mcap")


def test_damaged_images_are_counted(folder: Path, tmp_path: Path) -> None:
    (folder / "b.png").write_bytes(b"not an image")
    with pytest.raises(LossError, match=r"/camera: 1 of 2 messages lost \(50.00%; 1 E403\)"):
        ingest([folder], tmp_path / "out.mcap")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,name\n1,a\n", "first line is 'time,name', expected stamp_s,file"),
        ("stamp_s,file\nsoon,b.png\n", "line 2: 'soon,b.png', expected stamp_s,file"),
        ("stamp_s,file\n1.0\n", "line 2: '1.0', expected stamp_s,file"),
        ("stamp_s,file\n", "E206 names no image"),
        ("", "first line is ''"),
    ],
)
def test_a_list_that_is_none_is_refused(
    text: str, message: str, folder: Path, tmp_path: Path
) -> None:
    (folder / "images.csv").write_text(text)
    with pytest.raises(LogError, match=message):
        ingest([folder], tmp_path / "out.mcap")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("1 2 3 4 5 6 7", "line 1: E610 7 columns, expected t tx ty tz qx qy qz qw"),
        ("1 2,5 0 0 0 0 0 1", "decimal commas are not read"),
        ("now 2 0 0 0 0 0 1", "is not 8 numbers"),
    ],
)
def test_truth_that_is_none_is_refused_with_its_line(
    line: str, message: str, folder: Path, tmp_path: Path
) -> None:
    (folder / "truth.tum").write_text(line)
    with pytest.raises(TruthError, match=message):
        ingest([folder], tmp_path / "out.mcap")


def test_truth_rows_without_numbers_are_counted(folder: Path, tmp_path: Path) -> None:
    rows = [f"{i} {i} 0 0 0 0 0 1" for i in range(300)]
    (folder / "truth.tum").write_text("\n".join([*rows, "301 nan 0 0 0 0 0 1"]))
    done = ingest([folder], tmp_path / "out.mcap")
    assert done.ledger.topic("/truth").skipped == {"E504": 1}
    with open_log(tmp_path / "out.mcap") as log:
        assert log.references()[0].truth == Pose2(1.0, 0.0, 0.0)


def test_a_folder_without_a_list_says_what_is_known(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(
        LogError, match=r"E100 a folder without images.csv, .*known formats are mcap"
    ):
        ingest([tmp_path / "empty"], tmp_path / "out.mcap")
    with pytest.raises(LogError, match="no such file"):
        ingest([tmp_path / "gone"], tmp_path / "out.mcap")
    with pytest.raises(UsageError, match="--format dvd: no such format; there are mcap"):
        ingest([tmp_path / "empty"], tmp_path / "out.mcap", format="dvd")
