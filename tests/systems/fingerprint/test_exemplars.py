"""Exemplars kept beside a place's mean."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.exemplars import added, closest, losses
from fpnav.systems.fingerprint.mean import Mean
from fpnav.systems.fingerprint.model import hand_made
from fpnav.values import Pose2, Signature


def system(**settings: object) -> Fingerprint:
    return Fingerprint(FingerprintParams(**settings))  # type: ignore[arg-type]


def walk(of: Fingerprint, poses: list[Pose2]) -> list[Signature]:
    frames = [small_world.frame(at, pose, ["panorama", "scan"]) for at, pose in enumerate(poses)]
    return list(of.assemble((one.reference, of.describe(one)) for one in frames))


ALONG = [Pose2(0.8 + 0.4 * i, 0.0, 0.0) for i in range(12)]
ALIGNER = Aligner(FingerprintParams(), hand_made(FingerprintParams()))


def views(count: int) -> list[Mean]:
    return [ALIGNER.observation(one) for one in walk(system(), ALONG[:count])]


def test_there_are_never_more_than_asked_for() -> None:
    kept: list[Mean] = []
    for one in views(6):
        kept = added(kept, one, 3, ALIGNER)
        assert len(kept) <= 3
    assert sum(mean.observations for mean in kept) == 6
    assert added(kept, views(1)[0], 0, ALIGNER) == []


def test_the_two_that_lose_least_become_one() -> None:
    first, second, third = views(3)
    twin = Mean(first.features.copy(), first.arcs, 1)
    assert closest([first, third, twin], ALIGNER) == (0, 2)
    loss = losses([first, second, third], ALIGNER)
    assert np.isinf(loss[np.tril_indices(3)]).all()
    assert (loss[np.triu_indices(3, 1)] > 0.0).all()


def test_a_long_place_is_known_better_at_its_ends() -> None:
    scores = {}
    for count in (0, 3):
        of = system(exemplars=count)
        signatures = walk(of, ALONG)
        memory = of.memory()
        for one in signatures:
            memory.learn(0, one)
        found, _ = memory.recall([signatures[0], signatures[-1]], 1, None, None)
        scores[count] = found.scores[:, 0]
        assert len(memory.exemplars(0)) == count
    assert (scores[3] >= scores[0]).all()
    assert scores[3].max() > scores[0].max()


def test_exemplars_stand_in_the_frame_of_the_place() -> None:
    of = system(exemplars=2)
    turned = [Pose2(1.0 + 0.1 * i, 0.0, 0.9 * (i % 2)) for i in range(6)]
    signatures = walk(of, turned)
    memory = of.memory()
    for one in signatures:
        memory.learn(3, one)
    found, _ = memory.recall(signatures, 1, None, None)
    expected = [0.9 * (i % 2) for i in range(6)]
    assert found.headings_rad[:, 0] == pytest.approx(expected, abs=math.radians(6.0))


def test_pruning_by_place_is_exact_with_exemplars() -> None:
    of = system(exemplars=3)
    signatures = walk(of, ALONG)
    memory = of.memory()
    for at, one in enumerate(signatures):
        memory.learn(at // 3, one)
    short, _ = memory.recall(signatures, 1, None, None)
    whole, _ = memory.recall(signatures, 4, None, None)
    assert np.array_equal(short.scores[:, 0], whole.scores[:, 0])
    assert np.array_equal(short.places[:, 0], whole.places[:, 0])
    assert np.isfinite(whole.scores).all()


def test_merging_keeps_the_exemplars_of_both_within_the_limit() -> None:
    of = system(exemplars=3)
    signatures = walk(of, ALONG)
    memory = of.memory()
    for at, one in enumerate(signatures):
        memory.learn(at // 6, one)
    memory.merge(0, 1)
    assert len(memory.exemplars(0)) == 3
    assert sum(one.observations for one in memory.exemplars(0)) == 12
    memory.shrink(1)
    assert len(memory.exemplars(0)) == 1
