"""Every cell of the table in docs/formats.md, tried on a recording of that format."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path

import pytest
from helpers import encodings
from helpers.logs import jpeg

from fpnav.logs import messages
from fpnav.logs.frames import Log, open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.roles import IMAGE_ROLES
from fpnav.logs.sources.base import SourceOptions
from fpnav.values import Calibration

TABLE = Path(__file__).parents[2] / "docs" / "formats.md"


def cells() -> list[tuple[str, str, str]]:
    """(format, row, cell) of the table headed Format, encoding, role."""
    text = TABLE.read_text().split("## Format, encoding, role")[1].split("##")[0]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|") and not line.startswith("|--")
    ]
    return [(kind, row[0], cell) for row in rows[1:] for kind, cell in zip(rows[0][1:], row[1:],
            strict=True)]  # fmt: skip


def _mcap(encoding: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        path = folder / "a.mcap"
        path.write_bytes(encodings.encoded_drive(encoding))
        return path

    return write


def _carmen(folder: Path) -> Path:
    path = folder / "a.log"
    rows = (
        f"ODOM {i} 0 0 0.1 0 0 {i}.1 host {i}.1\n"
        f"FLASER 3 1.0 2.0 3.0 {i + 0.25} 0 0 {i} 0 0 {i}.2 host {i}.2\n"
        f"TRUEPOS {i} 0 0 {i} 0 0 {i}.3 host {i}.3\n"
        for i in range(4)
    )
    path.write_text("".join(rows))
    return path


def _g2o(folder: Path) -> Path:
    path = folder / "a.g2o"
    rows = [
        f"VERTEX_SE2 {i} {i} 0 0\nROBOTLASER1 0 -1.0 2.0 1.0 50 0.1 0 3 1 2 3 0 "
        f"{i + 0.25} 0 0 {i} 0 0 0 0 0 0 0 {i}.5 host {i}.5\n"
        for i in range(4)
    ]
    edges = [f"EDGE_SE2 {i} {i + 1} 1 0 0 1 0 0 1 0 1\n" for i in range(3)]
    path.write_text("".join(rows + edges))
    return path


def _images(folder: Path) -> Path:
    (folder / "a").mkdir()
    for i in range(3):
        (folder / "a" / f"{i}.jpg").write_bytes(jpeg())
    (folder / "a" / "images.csv").write_text("stamp_s,file\n0.5,0.jpg\n1.5,1.jpg\n2.5,2.jpg\n")
    (folder / "a" / "truth.tum").write_text("0 0 0 0 0 0 0 1\n3 1 0 0 0 0 0 1\n6 2 0 0 0 0 0 1\n")
    return folder / "a"


def _sonar(folder: Path) -> Path:
    path = folder / "a.csv"
    path.write_text("stamp_s,range_0,range_90\n0.0,1.0,2.0\n0.1,1.0,2.0\n")
    return path


SAMPLES: dict[str, Callable[[Path], Path]] = {
    "mcap cdr": _mcap("cdr"),
    "mcap ros1": _mcap("ros1"),
    "mcap protobuf": _mcap("protobuf"),
    "mcap json": _mcap("json"),
    "bag": lambda folder: encodings.write_bag(folder / "a.bag"),
    "db3": lambda folder: next(encodings.write_db3(folder / "a").glob("*.db3")),
    "carmen": _carmen,
    "g2o": _g2o,
    "images": _images,
    "sonar_csv": _sonar,
}


def _images_of(log: Log, type_name: str) -> bool:
    streams = [s for role in IMAGE_ROLES for s in log.streams.get(role, [])]
    return any(stream.type_name == type_name for stream in streams)


def _mounted(log: Log) -> bool:
    frame = next(log.frames())
    mounts = [] if frame.scan is None else [*astuple(frame.scan.mount)]
    mounts += [] if frame.sonar is None else frame.sonar.mounts.ravel().tolist()
    return any(mounts)


def _calibrated(log: Log) -> bool:
    return any(not math.isnan(c.horizontal_fov_rad) for c in log.calibrations.values())


TRIALS: dict[str, Callable[[Log], bool]] = {
    "camera, panorama, omni: compressed": lambda log: _images_of(log, messages.COMPRESSED_IMAGE),
    "the same: uncompressed": lambda log: _images_of(log, messages.IMAGE),
    "scan": lambda log: "scan" in log.roles,
    "sonar": lambda log: "sonar" in log.roles,
    "odometry": lambda log: "odometry" in log.roles,
    "truth": lambda log: "truth" in log.roles,
    "heading, pan, label": lambda log: {"heading", "pan", "label"} <= set(log.roles),
    "calibration": _calibrated,
    "mounts (/tf_static)": _mounted,
}


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], bool]:
    """Whether a recording of each format gives what each row names, read as it is if it can be."""
    found = {}
    hand = SourceOptions(calibration=Calibration(0, 0, horizontal_fov_rad=1.0))
    for kind, sample in SAMPLES.items():
        folder = tmp_path_factory.mktemp(kind.replace(" ", "_"))
        path = sample(folder)
        if path.suffix not in (".mcap", ".bag", ".db3"):
            ingest([path], folder / "made.mcap", options=hand)
            path = folder / "made.mcap"
        with open_log(path, strict=True) as log:
            found |= {(kind, row): trial(log) for row, trial in TRIALS.items()}
    return found


@pytest.mark.parametrize(("kind", "row", "cell"), cells(), ids=lambda value: str(value))
def test_a_cell_says_what_a_recording_gives(
    kind: str, row: str, cell: str, held: dict[tuple[str, str], bool]
) -> None:
    assert held[kind, row] == (cell != "-")


def test_the_table_names_every_format_and_row() -> None:
    assert {kind for kind, _, _ in cells()} == set(SAMPLES)
    assert {row for _, row, _ in cells()} == set(TRIALS)
