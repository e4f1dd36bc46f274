"""Matches smoothed along a run, with a system that sees corridors that look alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fpnav.errors import UsageError
from fpnav.localization.sequence import (
    agreement,
    chained,
    chosen,
    composed,
    difference,
    guesses_of,
    inverted,
    judged,
    motions,
    smoothed,
)
from fpnav.localization.verify import Checked
from fpnav.systems.base import Recall, Verification
from fpnav.values import Pose2, Reference, RelativePose, Signature

RECORD = np.dtype([("at_m", "<f8"), ("look", "<i8")])
RNG = np.random.default_rng(5)


def at(spot_m: float, look: int, index: int, odometry: bool = True) -> Signature:
    record = np.zeros(1, RECORD)
    record["at_m"], record["look"] = spot_m, look
    pose = Pose2(spot_m, 0.0, 0.0) if odometry else None
    return Signature(Reference(index, index, travelled_m=spot_m, odometry=pose), record[0], {})


class Corridors:
    """Signatures of one look match at their distance along their corridor; 20 m a corridor."""

    NAME = "corridors"

    def __init__(self, poses: bool = True) -> None:
        self.poses = poses
        self.asked = 0

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification:
        self.asked += len(candidates)
        relative, stated = [], []
        for one in candidates:
            off = float(query.record["at_m"] % 20.0 - one.record["at_m"] % 20.0)
            alike = query.record["look"] == one.record["look"] and abs(off) < 2.0
            stated.append(0.9 if alike else 0.02)
            pose = RelativePose(Pose2(off, 0.0, 0.0), tuple(np.eye(3).ravel()))
            relative.append(pose if self.poses and abs(off) < 2.0 else None)
        return Verification(np.array(stated), tuple(relative), stated=np.array(stated))


def drive(corridor: int, looks: Sequence[int], odometry: bool = True) -> list[Signature]:
    """One signature a metre along a corridor."""
    return [at(20.0 * corridor + k, look, k, odometry) for k, look in enumerate(looks)]


def checked(
    places: Sequence[Sequence[int]], stated: Sequence[Sequence[float]], off: Any
) -> Checked:
    rows, shares = np.array(places), np.array(stated)
    poses = np.zeros((*rows.shape, 3))
    poses[..., 0] = off
    recall = Recall(rows, np.log(shares / (1.0 - shares)), np.zeros(rows.shape))
    best = poses[:, 0]
    done = np.ones(len(rows), dtype=np.bool_)
    return Checked(recall, best, np.zeros((len(rows), 3, 3)), shares[:, 0], poses, shares, done)


REFERENCE = drive(0, [0] * 12) + [replace(one, reference=replace(
    one.reference, session=1)) for one in drive(1, [0] * 12)]  # fmt: skip
"""Two corridors that look alike, in sessions of their own."""


def test_neighbours_that_agree_overrule_one_that_does_not() -> None:
    queries = drive(0, [0] * 8)
    places = [[k, 12 + k] for k in range(8)]
    stated = [[0.8, 0.5] for _ in range(8)]
    places[4], stated[4] = [16, 4], [0.7, 0.6]  # the other corridor looks a little better once
    found = smoothed(Corridors(), REFERENCE, queries, np.full(8, 24), checked(places, stated, 0.0))
    assert found.recall.places[:, 0].tolist() == list(range(8))
    assert found.stated[4] == pytest.approx(0.6)  # what its own overlay says
    assert (np.diff(found.recall.scores, axis=1) <= 0.0).all()


def test_answers_the_sequence_does_not_change_stay_as_they_were() -> None:
    queries = drive(0, [0] * 5)
    places, stated = [[k] for k in range(5)], [[0.95] for _ in range(5)]
    places[2] = [20]  # alone among others, and nothing better is known
    before = checked(places, stated, 0.0)
    found = smoothed(Corridors(), REFERENCE, queries, np.full(5, 0), before)
    assert found.recall.places.tolist() == before.recall.places.tolist()
    assert found.recall.scores == pytest.approx(before.recall.scores)
    assert found.stated == pytest.approx(before.stated)


def test_an_answer_stands_unless_the_sequence_all_but_excludes_it() -> None:
    chain = chained(motions(Corridors(), REFERENCE))
    one = guesses_of(checked([[16, 4]], [[0.7, 0.6]], 0.0), 0)
    likely, sure = np.array([0.1, 0.8]), np.array([0.001, 0.9])
    assert chosen(one, likely, 16, 0.7, chain) == 0
    assert chosen(one, sure, 16, 0.7, chain) == 1
    assert chosen(one, likely, 16, 0.4, chain) == 1  # it was no answer by itself


def test_a_match_further_off_than_any_drift_is_refuted_within_one_run() -> None:
    run = drive(0, [0] * 12)
    before = checked([[0], [4]], [[0.95], [0.95]], 0.0)
    queries, allowed = [run[10], run[11]], np.array([5, 5])
    apart = smoothed(Corridors(), run, queries, allowed, before)
    assert apart.stated == pytest.approx([0.95, 0.95])  # of two runs nothing is known
    found = smoothed(Corridors(), run, queries, allowed, before, np.array([10, 11]))
    assert (found.stated < 0.6).all()
    assert (found.recall.scores[:, 0] < apart.recall.scores[:, 0]).all()


def test_a_match_within_the_drift_is_not_refuted() -> None:
    chain = chained(motions(Corridors(), REFERENCE))
    one = guesses_of(checked([[0, 1]], [[0.9, 0.9]], [[2.0, 5.0]]), 0)
    found = judged(one, 3, chain, np.arange(24.0))
    assert found.refuted is not None
    assert found.refuted.tolist() == [False, True]  # 1 m and 3 m off after 3 m and 2 m
    assert found.worth[1] < found.worth[0] - 5.0


def test_a_query_that_found_nothing_is_looked_for_where_its_neighbours_point() -> None:
    queries = drive(0, [0] * 6)
    places = [[k, 12] for k in range(6)]
    stated = [[0.9, 0.01] for _ in range(6)]
    places[3], stated[3] = [20, 21], [0.05, 0.04]
    found = smoothed(Corridors(), REFERENCE, queries, np.full(6, 24), checked(places, stated, 0.0))
    assert found.recall.places[3, 0] == 3
    assert found.stated[3] > 0.8


def test_rows_that_are_not_allowed_are_not_looked_at() -> None:
    queries = drive(0, [0] * 6)
    places = [[k] for k in range(6)]
    stated = [[0.9] for _ in range(6)]
    places[3], stated[3] = [0], [0.05]
    allowed = np.array([24, 24, 24, 2, 24, 24])
    found = smoothed(Corridors(), REFERENCE, queries, allowed, checked(places, stated, 0.0))
    assert found.recall.places[3, 0] < 2


def test_motion_comes_from_odometry_else_from_the_check_and_never_across_sessions() -> None:
    system = Corridors()
    with_odometry = motions(system, drive(0, [0] * 3))
    assert system.asked == 0
    assert with_odometry[1:].tolist() == [[1.0, 0.0, 0.0]] * 2
    without = motions(system, drive(0, [0] * 3, odometry=False))
    assert system.asked == 2
    assert without[1:].tolist() == [[1.0, 0.0, 0.0]] * 2
    assert np.isnan(without[0]).all()
    assert np.isnan(motions(system, REFERENCE)[12]).all()


def test_a_gap_parts_the_chain() -> None:
    motion = np.array([[np.nan] * 3, [1.0, 0.0, 0.5], [np.nan] * 3, [1.0, 0.0, 0.0]])
    chain = chained(motion)
    assert chain.stretch.tolist() == [1, 1, 2, 2]
    assert np.isnan(chain.between(np.array([1]), np.array([2]))).all()
    assert chain.between(np.array([0]), np.array([1]))[0] == pytest.approx([1.0, 0.0, 0.5])


def test_without_a_known_motion_neighbours_say_nothing() -> None:
    chain = chained(motions(Corridors(), REFERENCE))
    one = guesses_of(checked([[3, 4]], [[0.8, 0.5]], 0.0), 0)
    assert (agreement(one, one, np.full(3, np.nan), chain) == 1.0).all()


def test_a_system_without_poses_is_refused_in_words() -> None:
    poseless = checked([[0]], [[0.9]], np.nan)
    with pytest.raises(UsageError, match="--method match"):
        smoothed(Corridors(), REFERENCE, drive(0, [0]), np.array([24]), poseless)


def test_poses_compose_and_invert_as_single_ones_do() -> None:
    first, second = RNG.normal(size=(2, 5, 3))
    there = composed(first, second)
    assert difference(composed(inverted(first), there), second) == pytest.approx(np.zeros((5, 2)))
