"""The Foxglove recording, read back message by message."""

from __future__ import annotations

import io
import json
from collections import defaultdict
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.results import header, office_run, rows

from fpnav.export.subject import Subject, estimates
from fpnav.export.table import export
from fpnav.store.tables import Result

pytest.importorskip("foxglove", reason="extra foxglove is not installed")
mcap_reader = pytest.importorskip("mcap.reader")
protobuf = pytest.importorskip("mcap_protobuf.decoder", reason="decoder of the tests is absent")


def run() -> Result:
    made = office_run(step_m=2.0)
    queries = rows(made.queries["truth"])
    queries["odometry"] = made.queries["truth"] + [1.0, 0.0, 0.0]
    decision = made.decision.copy()
    decision[3:5] = -1
    return replace(made, queries=queries, decision=decision)


def subject(result: Result) -> Subject:
    labels = ("",) * len(result.view.place_ids)
    return Subject("run.h5", header(), result.view, labels, result.references, result.owner, result)


@pytest.fixture(scope="module")
def recording() -> bytes:
    return export(subject(run()), "mcap")


@pytest.fixture(scope="module")
def messages(recording: bytes) -> dict[str, list[tuple[int, Any]]]:
    reader = mcap_reader.make_reader(io.BytesIO(recording), validate_crcs=True)
    found: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    decoders = protobuf.DecoderFactory()
    for schema, channel, message in reader.iter_messages():
        decode = decoders.decoder_for(channel.message_encoding, schema) or json.loads
        found[channel.topic].append((message.log_time, decode(message.data)))
    return found


def test_the_graph_has_an_entity_per_place_and_one_for_the_edges(
    messages: dict[str, list[tuple[int, Any]]],
) -> None:
    ((_, scene),) = messages["/fpnav/graph"]
    ids = [entity.id for entity in scene.entities]
    assert ids == [f"place/{place}" for place in range(20)] + ["edges"]
    assert len(scene.entities[-1].lines[0].points) == 2 * 20
    assert all(entity.frame_id == "map" for entity in scene.entities)


def test_belief_is_shown_and_taken_back(messages: dict[str, list[tuple[int, Any]]]) -> None:
    shown: set[str] = set()
    result = run()
    assert len(messages["/fpnav/belief"]) == len(result.queries)
    for (stamp, scene), query, belief in zip(
        messages["/fpnav/belief"], result.queries, result.belief, strict=True
    ):
        assert stamp == query["stamp_ns"]
        shown -= {deleted.id for deleted in scene.deletions}
        shown |= {entity.id for entity in scene.entities}
        assert shown == {f"belief/{place}" for place in np.flatnonzero(belief >= 0.01)}


def test_scalars_name_the_best_two(messages: dict[str, list[tuple[int, Any]]]) -> None:
    _, values = messages["/fpnav/belief_scalars"][0]
    assert set(values) == {"best", "p_best", "second", "p_second", "entropy"}
    assert values["p_best"] >= values["p_second"]


def test_poses_stand_for_decisions_alone_and_map_to_odom_undoes_the_drift(
    messages: dict[str, list[tuple[int, Any]]],
) -> None:
    result = run()
    expected = dict(estimates(result))
    assert 3 not in expected
    assert [stamp for stamp, _ in messages["/fpnav/pose"]] == [
        int(result.queries["stamp_ns"][query]) for query in expected
    ]
    _, pose = messages["/fpnav/pose"][0]
    assert pose.pose.position.x == pytest.approx(next(iter(expected.values())).x_m)
    _, transforms = messages["/tf"][0]
    assert transforms.transforms[0].parent_frame_id == "map"
    assert transforms.transforms[0].child_frame_id == "odom"


def test_losing_and_finding_the_way_are_events(
    messages: dict[str, list[tuple[int, Any]]],
) -> None:
    texts = [message.message for _, message in messages["/fpnav/log"]]
    assert texts[0].startswith("localized at")
    assert any(text.startswith("lost: no place is near enough") for text in texts)


def test_figures_travel_along_and_the_bytes_are_the_same(recording: bytes) -> None:
    reader = mcap_reader.make_reader(io.BytesIO(recording))
    (attachment,) = reader.iter_attachments()
    assert attachment.name == "metrics.json"
    assert "place_accuracy_top1" in json.loads(attachment.data)
    assert export(subject(run()), "mcap") == recording


def test_a_map_alone_is_a_graph_and_a_path() -> None:
    alone = replace(subject(run()), result=None)
    reader = mcap_reader.make_reader(io.BytesIO(export(alone, "mcap")))
    topics = [channel.topic for _, channel, _ in reader.iter_messages()]
    assert topics == ["/fpnav/graph", "/fpnav/path"]
