"""Joined systems: whose places, how evidence adds, what silence says; evidence by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers import small_world

from fpnav.errors import UsageError
from fpnav.execution.walk import SystemChoice, make_system
from fpnav.systems.calibration import LARGEST, Evidence, evidence_of, fit_evidence
from fpnav.systems.registry import system_class
from fpnav.values import Frame, Signature


def joined(name: str = "tiny+ridf") -> Any:
    kind = system_class(name)
    return kind(kind.PRESETS["default"])


def run_of(system: Any, frames: list[Frame]) -> list[Signature]:
    return list(system.assemble((one.reference, system.describe(one)) for one in frames))


def memory_of(system: Any, run: list[Signature]) -> Any:
    memory = system.memory()
    memory.fit(run)
    for row, signature in enumerate(run):
        memory.learn(row, signature)
    return memory


def test_scores_are_the_sum_of_what_the_members_make_of_them() -> None:
    system = joined()
    run = run_of(system, small_world.route(40, ["panorama"], step_m=0.2))
    found, _ = memory_of(system, run).recall(run[:3], 40, None, None)
    expected = np.zeros((3, 40))
    for member in system.members:
        own = [system.of(member, one) for one in run]
        scores, _ = memory_of(member, own).recall(own[:3], 40, None, None)
        by_place = np.take_along_axis(scores.scores, np.argsort(scores.places, axis=1), axis=1)
        expected += evidence_of(member, own).ratios(by_place)
    got = np.take_along_axis(found.scores, np.argsort(found.places, axis=1), axis=1)
    assert got == pytest.approx(expected)


def test_a_member_that_is_silent_adds_nothing() -> None:
    both, alone = joined("ridf+gateway"), joined("ridf+tiny").members[0]
    run = run_of(both, small_world.route(40, ["panorama", "scan", "sonar"], step_m=0.2))
    silent = [one for one in run if both.of(both.members[1], one) is None]
    assert silent
    own = [both.of(both.members[0], one) for one in run]
    asked = [both.of(both.members[0], one) for one in silent[:2]]
    got, _ = memory_of(both, run).recall(silent[:2], 5, None, None)
    scores, _ = memory_of(alone, own).recall(asked, 5, None, None)
    expected = evidence_of(alone, own).ratios(scores.scores)
    assert np.array_equal(got.places[:, 0], scores.places[:, 0])
    assert got.scores == pytest.approx(expected)


def test_the_first_owns_the_places() -> None:
    system = joined()
    run = run_of(system, small_world.route(30, ["panorama"], step_m=0.2))
    lead = system.members[0]
    own = [system.of(lead, one) for one in run]
    assert system.rule == lead.rule
    one, other = memory_of(system, run), memory_of(lead, own)
    assert one.novelty(run[3], run[2], None)[0] == other.novelty(own[3], own[2], None)[0]


def test_parameters_reach_the_member_they_name() -> None:
    tables = {"tiny": {"theta": 0.25}, "ridf": {"height_px": 12}}
    system, preset = make_system(SystemChoice("tiny+ridf", None, tables))
    assert preset == "default"
    assert system.rule.threshold == 0.25
    assert system.params.ridf.height_px == 12  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["tiny+tiny", "tiny+", "tiny+nobody"])
def test_what_cannot_be_joined_is_refused(name: str) -> None:
    with pytest.raises(UsageError):
        system_class(name)


def test_ratios_of_two_normals_are_the_textbook_line() -> None:
    rng = np.random.default_rng(1)
    right, wrong = rng.normal(3.0, 0.5, 4000), rng.normal(1.0, 0.5, 4000)
    found = fit_evidence(right, wrong)
    scores = np.array([1.5, 2.0, 2.5])
    expected = (np.square(scores - 1.0) - np.square(scores - 3.0)) / (2.0 * 0.25)
    assert found.ratios(scores) == pytest.approx(expected, abs=0.4)


def test_nothing_is_claimed_of_what_was_not_seen_and_never_too_much() -> None:
    evidence = Evidence(slope=100.0, midpoint=0.5)
    assert list(evidence.ratios(np.array([-np.inf, 5.0, -5.0]))) == [0.0, LARGEST, -LARGEST]
    assert fit_evidence(np.array([1.0]), np.ones(50)) == Evidence()
    assert fit_evidence(np.zeros(9), np.ones(9)) == Evidence()
