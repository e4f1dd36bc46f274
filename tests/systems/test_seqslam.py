"""Sequences: lines through differences, local normalisation, and a run that single images lose."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.systems.registry import system_class
from fpnav.systems.seqslam import line_means, locally_normalised
from fpnav.values import Reference, Signature


def test_differences_are_normalised_over_their_neighbours() -> None:
    values = np.random.default_rng(1).normal(size=30)
    found = locally_normalised(values, 10)
    around = values[7:18]
    assert found[12] == pytest.approx((values[12] - around.mean()) / around.std())


def test_the_best_line_follows_the_run() -> None:
    differences = np.ones((5, 20))
    for step in range(5):
        differences[step, 8 + step] = 0.0
    assert int(line_means(differences, np.array([1.0])).argmin()) == 12
    assert line_means(differences, np.array([0.5]))[12] > 0.5


def test_a_sequence_finds_what_single_images_do_not() -> None:
    rng = np.random.default_rng(3)
    kind = system_class("seqslam")
    system = kind(kind.PRESETS["default"])
    world = rng.normal(size=(80, 2048)).astype(np.float32)
    seen = world + rng.normal(0.0, 9.0, world.shape).astype(np.float32)

    def signature(row: int, vector: np.ndarray) -> Signature:  # type: ignore[type-arg]
        record: np.void = np.array([(1,)], kind.RECORD)[0]
        return Signature(Reference(row, row), record, {"vector": vector})

    memory = system.memory()
    for row, vector in enumerate(world):
        memory.learn(row, signature(row, vector))
    queries = [signature(row, vector) for row, vector in enumerate(seen)]
    found, _ = memory.recall(queries, 1, None, None)
    alone = [memory.recall([query], 1, None, None)[0].places[0, 0] for query in queries]
    right = found.places[10:, 0] == np.arange(10, 80)
    single = np.array(alone[10:]) == np.arange(10, 80)
    assert right.mean() > 0.9
    assert right.mean() > single.mean() + 0.1
