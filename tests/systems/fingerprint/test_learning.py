"""Scores learned as log-odds, and the model a memory stores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import small_world
from helpers.strings import SCORES, strings

from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.learning import Tally, learned_scores, log_odds, tally
from fpnav.systems.fingerprint.model import hand_made, loaded, saved
from fpnav.systems.fingerprint.pairs import far_pairs, near_pairs
from fpnav.systems.fingerprint.symbols import C, N, V, features_of
from fpnav.values import Pose2, Reference, Signature

SIZE = 20


def outcomes(matched: dict[tuple[int, int], float], missed: dict[int, float]) -> Tally:
    pairs, gaps = np.zeros((SIZE, SIZE)), np.zeros(SIZE)
    for (a, b), count in matched.items():
        pairs[a, b] = pairs[b, a] = count
    for code, count in missed.items():
        gaps[code] = count
    return Tally(pairs, gaps)


def test_every_symbol_of_a_pair_is_counted_once_by_its_weight() -> None:
    batch = strings(["vcA", "vc"])
    found = tally(batch, np.array([[0, 1]]), SCORES)
    assert found.matched[V, V] == found.matched[C, C] == 2.0
    assert found.missed[0] == 1.0
    assert found.total == 5.0


def test_what_happens_more_within_a_place_is_worth_more() -> None:
    same = outcomes({(V, V): 8000.0, (C, C): 4000.0}, {V: 1000.0, C: 3000.0})
    other = outcomes({(V, V): 2000.0, (C, C): 4000.0}, {V: 7000.0, C: 3000.0})
    pairs, gaps = log_odds(same, other)
    assert pairs[V, V] == pytest.approx(np.log(4.0), abs=0.02)
    assert pairs[C, C] == pytest.approx(0.0, abs=0.02)
    assert gaps[V] == pytest.approx(np.log(7.0), abs=0.1)
    assert np.array_equal(pairs, pairs.T)


def test_hues_are_learned_together_by_how_far_apart_they_are() -> None:
    same = outcomes({(0, 0): 900.0, (3, 4): 90.0}, {5: 10.0})
    other = outcomes({(7, 7): 300.0, (9, 10): 300.0}, {5: 400.0})
    pairs, _ = log_odds(same, other)
    assert len({round(float(pairs[i, i]), 9) for i in range(16)}) == 1
    assert pairs[0, 15] == pytest.approx(pairs[3, 4])
    assert pairs[0, 0] > 0.0 > pairs[3, 4]


def test_rare_symbols_stay_quiet() -> None:
    same = outcomes({(V, V): 5000.0, (N, N): 1.0}, {})
    other = outcomes({(V, V): 5000.0}, {})
    assert abs(log_odds(same, other)[0][N, N]) < 3.0


def route(count: int = 60) -> tuple[Fingerprint, list[Signature]]:
    system = Fingerprint(FingerprintParams(scores="learned", certainty="calibrated"))
    frames = []
    for at in range(count):
        along = 0.6 + 0.1 * (at if at < 80 else 160 - at)  # there and back
        frames.append(small_world.frame(at, Pose2(along, 0.0, 0.0), ["panorama", "scan"]))
    described = ((one.reference, system.describe(one)) for one in frames)
    return system, list(system.assemble(described))


def test_learned_scores_keep_what_the_aligner_relies_on() -> None:
    system, signatures = route(160)
    memory = system.memory()
    memory.fit(signatures)
    scores, model = memory.model.scores, memory.model
    assert np.array_equal(scores.sigma, scores.sigma.T)
    assert (np.diag(scores.sigma) == 1.0).all()
    assert np.abs(scores.sigma).max() <= 1.0
    assert ((scores.gap >= 0.1) & (scores.gap <= 1.0)).all()
    assert ((model.weights > 0.0) & (model.weights <= 1.0)).all()
    assert (model.evidence > 0).all()


def test_what_was_learned_is_stored_with_its_evidence() -> None:
    system, signatures = route(160)
    memory, other = system.memory(), system.memory()
    memory.fit(signatures)
    memory.learn(0, signatures[0])
    other.load(memory.save())
    for name, array in saved(memory.model).items():
        assert np.array_equal(saved(other.model)[name], array)
    assert np.array_equal(loaded(saved(memory.model)).scores.sigma, memory.model.scores.sigma)


def test_a_model_saved_before_there_were_leanings_states_what_it_stated() -> None:
    model = hand_made(FingerprintParams(certainty="calibrated"))
    curves = model.curves * np.array([1.0, 0.5])[None, :, None]
    old = {**saved(replace(model, curves=curves))}
    del old["lean"]
    rows = features_of(np.array([b"c", b"v"]), np.array([0.0, 1.0]), np.array([0.4, 0.8]))
    assert loaded(old).certainty(rows) == pytest.approx([0.2, 0.4])


def test_a_run_too_short_to_learn_from_leaves_the_hand_made_scores() -> None:
    system, signatures = route(3)
    memory = system.memory()
    memory.fit(signatures)
    assert np.array_equal(memory.model.scores.sigma, hand_made(system.params).scores.sigma)
    memory.fit([])


def test_plain_scores_are_those_of_needleman_and_wunsch() -> None:
    plain = hand_made(FingerprintParams(scores="plain", certainty="flat"))
    assert plain.scores.sigma[0, 0] == 1.0
    assert plain.scores.sigma[0, 1] == plain.scores.sigma[V, C] == -1.0
    assert (plain.weights == 1.0).all()
    assert (plain.curves[:, 1] == 1.0).all()


def references(count: int, **extra: object) -> list[Reference]:
    return [Reference(i, i, travelled_m=0.2 * i, **extra) for i in range(count)]  # type: ignore[arg-type]


def test_near_pairs_are_a_little_travel_apart_in_one_session() -> None:
    rows = references(200)
    apart = np.diff(near_pairs(rows), axis=1)[:, 0] * 0.2
    assert set(np.round(apart, 1)) <= {0.4, 0.6, 0.8, 1.0, 1.2}
    halves = references(50) + [Reference(i, i, session=1, travelled_m=0.2 * i) for i in range(50)]
    pairs = near_pairs(halves)
    assert ((pairs[:, 0] < 50) == (pairs[:, 1] < 50)).all()


def test_far_pairs_are_of_different_places() -> None:
    rows = references(300)
    pairs = far_pairs(rows)
    assert len(pairs) > 100
    assert (np.abs(np.diff(pairs, axis=1)) * 0.2 >= 10.0).all()
    circle = [Reference(i, i, travelled_m=0.2 * i, odometry=Pose2(0, 0, 0)) for i in range(300)]
    assert len(far_pairs(circle)) == 0  # the robot never left


def test_without_a_path_frames_are_counted() -> None:
    rows = [Reference(i, i) for i in range(200)]
    assert set(np.diff(near_pairs(rows), axis=1)[:, 0]) <= {1, 2, 3, 4, 5, 6, 7}
    assert len(far_pairs(rows)) > 0
    assert len(near_pairs([])) == len(far_pairs([])) == 0


def test_scores_learned_twice_from_one_run_are_the_same() -> None:
    batch = strings(["vcAn", "vcA", "ncc", "PPv"] * 3)
    near, far = np.array([[0, 1], [4, 5], [8, 9]]), np.array([[0, 2], [4, 7], [8, 11]])
    first = learned_scores(batch, near, far, SCORES, np.ones(SIZE))
    again = learned_scores(batch, near, far, SCORES, np.ones(SIZE))
    assert np.array_equal(first[0].sigma, again[0].sigma)
    assert np.array_equal(first[1], again[1])
