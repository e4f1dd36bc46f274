"""Stated probabilities, hand-worked."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.toy_system import Toy, drive, mixed, signature_of
from hypothesis import given
from hypothesis import strategies as st

from fpnav.localization.confidence import Confidence, fit_confidence, mapping_confidence
from fpnav.mapping.build import build_map
from fpnav.values import Reference, Signature

scores = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=30)


def fit(right: list[float], wrong: list[float]) -> Confidence:
    return fit_confidence(np.array(right), np.array(wrong))


def test_two_normals_of_one_variance_give_a_logistic() -> None:
    # means 0.9 and 0.3, variance 0.01: log odds (0.6 / 0.01) (s - 0.6)
    found = fit([0.8, 1.0], [0.2, 0.4])
    assert found.midpoint == pytest.approx(0.6)
    assert found.slope == pytest.approx(60.0)
    assert found.stated(np.array([0.6, 0.7])) == pytest.approx([0.5, 1 / (1 + math.exp(-6))])


def test_clusters_without_spread_are_told_apart_steeply_but_not_infinitely() -> None:
    found = fit([1.0, 1.0], [0.0, 0.0])
    assert found.slope == 200.0
    assert found.stated(np.array([0.49, 0.51])).round().tolist() == [0.0, 1.0]


def test_nothing_recalled_is_stated_as_impossible() -> None:
    assert fit([0.8, 1.0], [0.2]).stated(np.array([-np.inf]))[0] < 1e-9


def test_without_wrong_answers_all_that_were_right_are_trusted() -> None:
    found = fit([0.4, 0.9], [])
    assert (found.stated(np.array([0.4, 0.9, 1.0])) > 0.5).all()
    assert found.stated(np.array([0.3]))[0] < 0.5


def test_without_right_answers_nothing_is_trusted() -> None:
    stated = fit([math.nan], [0.5]).stated(np.array([1.0, 1e300, -np.inf]))
    assert (stated < 1e-9).all()


def test_where_wrong_answers_score_higher_only_the_highest_score_is_trusted() -> None:
    found = fit([0.2, 0.3], [0.8, 0.9])
    assert (found.stated(np.array([0.3, 0.85])) < 0.5).all()
    assert found.stated(np.array([0.95]))[0] > 0.5


@given(scores, scores)
def test_a_higher_score_never_states_less(right: list[float], wrong: list[float]) -> None:
    stated = fit(right, wrong).stated(np.linspace(-0.5, 1.5, 50))
    assert (np.diff(stated) >= 0).all()
    assert ((stated >= 0) & (stated <= 1)).all()


def test_the_mapping_run_is_asked_for_its_own_places_and_those_that_are_no_neighbours() -> None:
    # place 1 looks half like its neighbour 0 and place 2 a quarter like place 0
    looks = [mixed(0, 1, 0.5)] * 2 + [mixed(1, 1, 0.0)] * 2 + [mixed(2, 0, 0.25)] * 2
    rows = [
        signature_of(Reference(i, i, travelled_m=float(i)), look) for i, look in enumerate(looks)
    ]
    built = build_map(Toy(), rows, advance=lambda done: None)
    assert len(built.topomap) == 3
    found = mapping_confidence(Toy(), rows, built.topomap)
    # right: 1.0 six times; wrong: 0.25 four times (places 0 and 2), none for the one between
    assert found == fit_confidence(np.ones(6), np.full(4, 0.25))
    assert mapping_confidence(Toy(), rows, built.topomap, every=2) == found


def test_a_map_of_one_place_trusts_what_looks_like_it() -> None:
    rows = drive([0, 0, 0])
    built = build_map(Toy(), rows, advance=lambda done: None)
    found = mapping_confidence(Toy(), rows, built.topomap)
    assert found.stated(np.array([1.0, 0.5])).round().tolist() == [1.0, 0.0]


def test_what_is_asked_was_not_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = drive([0] * 8 + [1] * 8)
    built = build_map(Toy(), rows, advance=lambda done: None)
    kind = type(Toy().memory())
    learn, recall = kind.learn, kind.recall
    learned: set[int] = set()
    asked: set[int] = set()

    def note_learned(self: Any, place: int, signature: Signature) -> None:
        learned.add(signature.reference.index)
        learn(self, place, signature)

    def note_asked(self: Any, signatures: Any, *rest: Any) -> Any:
        asked.update(signature.reference.index for signature in signatures)
        return recall(self, signatures, *rest)

    monkeypatch.setattr(kind, "learn", note_learned)
    monkeypatch.setattr(kind, "recall", note_asked)
    mapping_confidence(Toy(), rows, built.topomap)
    assert learned == {0, 1, 2, 3, 8, 9, 10, 11}
    assert asked == {4, 5, 6, 7, 12, 13, 14, 15}
