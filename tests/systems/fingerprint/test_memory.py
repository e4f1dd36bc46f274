"""The memory of places: fusing, novelty, recall, merging."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.record import record_of
from fpnav.systems.fingerprint.symbols import features_of, parse, symbols_of
from fpnav.values import Pose2, Reference, Signature

TAU = 2.0 * math.pi
ROUND = np.array([[0.0, TAU], [0.0, TAU]])


def system(**settings: object) -> Fingerprint:
    return Fingerprint(FingerprintParams(**settings))  # type: ignore[arg-type]


def signature(rows: np.ndarray, arcs: np.ndarray = ROUND, index: int = 0) -> Signature:
    """Signature of FEATURE rows."""
    symbols = symbols_of(
        rows, arcs, pair_rad=math.radians(3.0), delta_rad=math.radians(20.0), certainty_n=0.5
    )
    record = record_of(arcs, symbols["type"].tobytes())
    return Signature(Reference(index, index), record, {"features": rows, "symbols": symbols})


def walk(fingerprint: Fingerprint, poses: list[Pose2]) -> list[Signature]:
    frames = [small_world.frame(at, pose, ["panorama", "scan"]) for at, pose in enumerate(poses)]
    return list(fingerprint.assemble((one.reference, fingerprint.describe(one)) for one in frames))


CORRIDOR = [Pose2(1.0 + 0.1 * i, 0.0, 0.0) for i in range(8)]
ROOM = [Pose2(6.2 + 0.1 * i, 2.5, 1.0) for i in range(4)]


def test_novelty_is_one_less_prob_matching() -> None:
    fingerprint = system()
    first, second = walk(fingerprint, CORRIDOR[:2])
    value, _ = fingerprint.memory().novelty(second, first, None)
    assert value == pytest.approx(1.0 - fingerprint.similarity(second, first))
    assert 0.0 < value < 0.5


def test_compare_chooses_what_is_compared_with() -> None:
    found = {}
    for compare in ("previous", "mean", "both"):
        fingerprint = system(compare=compare)
        signatures = walk(fingerprint, CORRIDOR[:6])
        memory = fingerprint.memory()
        for one in signatures[:4]:
            memory.learn(0, one)
        found[compare] = memory.novelty(signatures[5], signatures[4], None)[0]
    assert found["both"] == max(found["previous"], found["mean"])
    assert found["previous"] != found["mean"]


def test_without_anything_to_compare_with_all_is_new() -> None:
    for compare in ("previous", "mean", "both"):
        fingerprint = system(compare=compare)
        only = walk(fingerprint, CORRIDOR[:1])[0]
        assert fingerprint.memory().novelty(only, None, None)[0] == 1.0


def test_the_mean_stays_in_the_frame_of_the_first_observation() -> None:
    fingerprint = system()
    ahead, turned = walk(fingerprint, [CORRIDOR[0], Pose2(1.0, 0.0, 1.1)])
    memory = fingerprint.memory()
    memory.learn(0, ahead)
    memory.learn(0, turned)
    found, _ = memory.recall([ahead, turned], 1, None, None)
    assert found.headings_rad[0, 0] == pytest.approx(0.0, abs=math.radians(3.0))
    assert found.headings_rad[1, 0] == pytest.approx(1.1, abs=math.radians(3.0))


def test_recall_finds_the_place_and_the_heading_at_once() -> None:
    fingerprint = system()
    memory = fingerprint.memory()
    for place, poses in ((0, CORRIDOR), (1, ROOM)):
        for one in walk(fingerprint, poses):
            memory.learn(place, one)
    queries = walk(fingerprint, [Pose2(1.35, 0.05, -0.8), Pose2(6.35, 2.45, 2.2)])
    found, _ = memory.recall(queries, 2, None, None)
    assert found.places.tolist() == [[0, 1], [1, 0]]
    assert (found.scores[:, 0] > found.scores[:, 1] + 0.2).all()
    assert found.headings_rad[:, 0] == pytest.approx([-0.8, 1.2], abs=math.radians(6.0))


def test_only_the_best_few_are_given_a_heading() -> None:
    fingerprint = system(headings=1)
    memory = fingerprint.memory()
    signatures = walk(fingerprint, CORRIDOR[:3])
    for place, one in enumerate(signatures):
        memory.learn(place, one)
    found, _ = memory.recall(signatures, 3, None, None)
    assert np.isfinite(found.headings_rad[:, 0]).all()
    assert np.isnan(found.headings_rad[:, 1:]).all()


def test_learning_again_gains_evidence_without_moving_features() -> None:
    fingerprint = system()
    one = walk(fingerprint, CORRIDOR[:1])[0]
    memory = fingerprint.memory()
    for _ in range(3):
        memory.learn(5, one)
    mean = memory.mean(5)
    assert mean.observations == 3
    assert np.allclose(mean.features["angle_rad"], one.parts["features"]["angle_rad"])
    assert np.allclose(mean.features["certainty"], one.parts["features"]["certainty"], atol=1e-6)
    found, _ = memory.recall([one], 1, None, None)
    assert found.scores[0, 0] == pytest.approx(1.0, abs=1e-4)


def glimpse(place: int, seed: int) -> Signature:
    """What is seen of one of a few random places at a glance: jitter and features missed."""
    layout, noise = np.random.default_rng(place), np.random.default_rng([place, seed])
    angles = np.radians(np.arange(18) * 20.0 + layout.uniform(-6.0, 6.0, 18))
    letters = layout.choice(np.frombuffer(b"vcABIE", "S1"), 18)
    seen = noise.random(18) < 0.9
    jitter = np.radians(noise.normal(0.0, 1.0, 18))
    certainty = noise.uniform(0.6, 1.0, 18)
    return signature(features_of(letters[seen], (angles + jitter)[seen], certainty[seen]))


@pytest.mark.parametrize("place", range(4))
def test_the_order_of_fusion_hardly_matters(place: int) -> None:
    seen = [glimpse(place, seed) for seed in range(6)]
    scores = []
    for order in ((0, 1, 2, 3, 4, 5), (5, 3, 1, 4, 0, 2), (2, 4, 3, 5, 1, 0)):
        memory = system().memory()
        for at in order:
            memory.learn(0, seen[at])
        scores.append(memory.recall([glimpse(place, 99)], 1, None, None)[0].scores[0, 0])
    assert max(scores) - min(scores) < 0.05
    assert min(scores) > 0.7


def test_merging_weighs_by_observations_and_takes_over_the_current_place() -> None:
    fingerprint = system(compare="mean")
    signatures = walk(fingerprint, CORRIDOR[:6])
    memory = fingerprint.memory()
    for at, one in enumerate(signatures):
        memory.learn(at // 4, one)
    memory.merge(0, 1)
    assert memory.mean(0).observations == 6
    assert memory.places.tolist() == [0]
    assert memory.novelty(signatures[5], None, None)[0] < 0.5


def test_shrinking_keeps_the_most_certain_features() -> None:
    fingerprint = system()
    memory = fingerprint.memory()
    memory.learn(0, walk(fingerprint, CORRIDOR[:1])[0])
    before = np.sort(memory.mean(0).features["certainty"])
    memory.shrink(4)
    assert np.array_equal(np.sort(memory.mean(0).features["certainty"]), before[-4:])


def test_the_papers_string_is_recalled_among_others() -> None:
    fingerprint = system()
    memory = fingerprint.memory()
    texts = ["cIfvncvfnvncvnnvcvBnvBccE", "cvnnncvAnncvnvcnPnv", "nnncnnvnnDnncnn"]
    signatures = []
    for text in texts:
        rows = parse(text)
        signatures.append(
            Signature(
                Reference(0, 0),
                record_of(ROUND, rows["type"].tobytes()),
                {"features": _features(rows), "symbols": rows},
            )
        )
    for place, one in enumerate(signatures):
        memory.learn(place, one)
    found, _ = memory.recall(signatures, 1, None, None)
    assert found.places[:, 0].tolist() == [0, 1, 2]


def _features(rows: np.ndarray) -> np.ndarray:
    own = rows[(rows["type"] != b"n") & (rows["type"] != b"f")]
    return features_of(own["type"], own["angle_rad"], own["certainty"])


def test_half_a_view_is_recalled_from_a_map_of_whole_ones() -> None:
    fingerprint = system(use_camera=False)
    memory = fingerprint.memory()
    for place, poses in ((0, CORRIDOR), (1, ROOM)):
        for one in walk(fingerprint, poses):
            memory.learn(place, one)
    half = system(use_camera=False, laser_fov_deg=180.0)
    queries = walk(half, [CORRIDOR[2], ROOM[1]])
    found, _ = memory.recall(queries, 1, None, None)
    assert found.places[:, 0].tolist() == [0, 1]
    assert found.headings_rad[:, 0] == pytest.approx([0.0, 0.0], abs=math.radians(8.0))
