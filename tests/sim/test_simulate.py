"""The command, from one line to a log that says what it was asked to say."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner
from mcap.reader import make_reader

from fpnav.cli.main import cli
from fpnav.publish import file_digest
from fpnav.sim.truth import WorldFacts, schema

SIZE = ["--sensors", "panorama,scan,sonar", "--set", "panorama.width_px=90", "-q", "--json"]
CAMPUS = ["campus", "--route", "tour", "--places", "6", "--seed", "2"]


def simulate(*arguments: str) -> dict[str, object]:
    given = [*arguments, *SIZE, "--set", "panorama.height_px=16"]
    made = CliRunner().invoke(cli, ["simulate", *given], catch_exceptions=False)
    assert made.exit_code == 0, made.output
    return dict(json.loads(made.stdout))


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("campus") / "tour.mcap"
    facts = simulate(*CAMPUS, "-o", str(file))
    assert facts["data_sets"] == 6
    return file


def topics(file: Path) -> dict[str, int]:
    with open(file, "rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    counts = summary.statistics.channel_message_counts
    return {channel.topic: counts[number] for number, channel in summary.channels.items()}


def attached(file: Path) -> WorldFacts:
    with open(file, "rb") as stream:
        (attachment,) = make_reader(stream).iter_attachments()
    return msgspec.json.decode(attachment.data, type=WorldFacts)


def test_every_standard_topic_of_the_rig_is_there(log: Path) -> None:
    found = topics(log)
    assert found["/panorama"] == found["/scan"] == found["/sonar/23"] == 6
    assert {"/odom", "/truth", "/compass", "/label", "/tf_static"} <= set(found)


def test_the_log_reads_back_as_frames_with_their_truth(log: Path) -> None:
    from fpnav.logs.frames import open_log

    with open_log(log) as made:
        frames = list(made.frames())
    assert len(frames) == 6
    assert frames[3].panorama is not None
    assert frames[3].panorama.pixels.shape == (16, 90, 3)
    assert frames[3].reference.truth is not None
    assert frames[3].reference.label.startswith("0-")


def test_the_world_travels_as_an_attachment_of_its_schema(log: Path) -> None:
    facts = attached(log)
    assert (facts.world, facts.seed, facts.run, facts.route) == ("campus", 2, 1, "tour")
    assert len(facts.routes["tour"].points) == 6


def test_the_schema_in_the_docs_is_that_of_the_code(root: Path) -> None:
    assert (root / "docs" / "world.schema.json").read_bytes() == schema()


def test_the_same_line_gives_the_same_bytes(log: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.mcap"
    simulate(*CAMPUS, "-o", str(again))
    assert file_digest(again) == file_digest(log)


def test_two_processes_give_the_same_bytes_as_one(log: Path, tmp_path: Path) -> None:
    spread = tmp_path / "spread.mcap"
    simulate(*CAMPUS, "-o", str(spread), "--jobs", "2")
    assert file_digest(spread) == file_digest(log)


def test_another_run_gives_another_log_of_the_same_building(log: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.mcap"
    simulate(*CAMPUS, "--run", "2", "-o", str(other))
    assert file_digest(other) != file_digest(log)
    assert attached(other).rooms == attached(log).rooms


def test_kidnaps_and_masks_are_one_flag_each(tmp_path: Path) -> None:
    file = tmp_path / "carried.mcap"
    simulate(
        "room", "--route", "line", "--step", "0.2", "--kidnap", "2",
        "--set", "mask.share=0.5", "--set", "mask.from_share=0.0", "-o", str(file),
    )  # fmt: skip
    from fpnav.logs.frames import open_log

    with open_log(file) as made:
        frames = list(made.frames())
    truth = np.array([(f.reference.truth.x_m, f.reference.truth.y_m) for f in frames])  # type: ignore[union-attr]
    assert (np.linalg.norm(np.diff(truth, axis=0), axis=1) > 0.3).sum() == 2
    assert frames[0].panorama is not None
    hidden = np.ptp(frames[0].panorama.pixels[4:12].astype(int), axis=(0, 2)) < 12
    assert hidden[2:43].mean() > 0.9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["castle", "--route", "map"], "no world 'castle'; known: office"),
        (["office", "--route", "home"], "office has no route 'home'; it has map, test"),
        (["office", "--route", "map", "--sensors", "nose"], "no sensor 'nose'"),
        (["office", "--route", "map", "--set", "world.peple=3"], "did you mean 'people'"),
    ],
)
def test_a_wrong_request_is_answered_in_one_line(
    arguments: list[str], message: str, tmp_path: Path
) -> None:
    output = tmp_path / "x.mcap"
    made = CliRunner().invoke(cli, ["simulate", *arguments, "-o", str(output)])
    assert message in str(made.exception)
    assert not output.exists()
