"""The reproduction of Kortenkamp and Weymouth on places made by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.gateways import cue, gateway

from fpnav.evaluation.gateways import Gateways
from fpnav.execution.spread import Here
from fpnav.experiments.kortenkamp.learned import Learned
from fpnav.experiments.kortenkamp.recognition import PARAMS, normalisation, recognition
from fpnav.experiments.kortenkamp.tours import edged
from fpnav.experiments.workshop import Workshop
from fpnav.systems.gateway.memory import GatewayMemory
from fpnav.values import Signature

KINDS = {"A": "T-SHAPE", **dict.fromkeys("BCD", "RIGHT OPENING"), "E": "RIGHT ROOM",
         "F": "LEFT TURN", "G": "CROSS"}  # fmt: skip
ORDER = "BCDEAFG"
"""As the route meets them; the paper's tables are in alphabetical order."""


def seen(name: str) -> Signature:
    """A gateway with cues in columns of its own."""
    columns = [int(bit) for bit in f"{'ABCDEFG'.index(name) + 1:05b}"]
    cues = [cue(48.0 + 96.0 * number) for number, bit in enumerate(columns) if bit]
    return gateway(KINDS[name], cues)


def places(missing: str = "") -> Learned:
    memory = GatewayMemory(PARAMS)
    for place, name in enumerate(ORDER):
        for _ in range(5):
            memory.learn(place, seen(name))
    tests = tuple(None if name == missing else seen(name) for name in ORDER)
    return Learned(tuple(ORDER), ("route-1",) * 7, memory, tests)


def test_the_tables_are_in_the_papers_order_and_rows_add_up() -> None:
    found = recognition(places())
    assert "".join(found.names) == "ABCDEFG"
    for table in (found.vision, found.sonar, found.both):
        assert table.sum(axis=1) == pytest.approx(np.ones(7))


def test_sonar_alone_gives_the_papers_table() -> None:
    sonar = recognition(places()).sonar
    assert sonar[1] == pytest.approx([0.02, 0.31, 0.31, 0.31, 0.06, 0, 0], abs=0.03)
    # The paper's F and G are unlike A; here a turn and a crossing share an open side with it.
    assert sonar[0, 0] / (1.0 - sonar[0, 5:].sum()) == pytest.approx(0.82, abs=0.04)


def test_both_tell_what_neither_does_alone() -> None:
    found = recognition(places())
    assert found.both[1].argmax() == 1
    assert (found.sonar[1] == found.sonar[1].max()).sum() == 3


def test_a_gateway_that_was_not_found_is_told_by_nothing() -> None:
    found = recognition(places(missing="C"))
    assert not found.both[2].any()
    assert found.both[3].sum() == pytest.approx(1.0)


def test_a_misread_gateway_changes_the_sonar_row_alone() -> None:
    plain, misread = recognition(places()), recognition(places().misread("D", "RIGHT ROOM"))
    assert np.array_equal(plain.vision, misread.vision)
    assert np.array_equal(np.delete(plain.sonar, 3, 0), np.delete(misread.sonar, 3, 0))
    assert misread.sonar[3, 4] == pytest.approx(0.61, abs=0.04)
    assert misread.sonar[3, 3] == pytest.approx(0.11, abs=0.01)


def test_the_papers_example_of_normalisation(tmp_path: Path) -> None:
    (gap,) = normalisation(Workshop(tmp_path, Here()), 1).metrics
    assert gap.value < 0.0055


def test_rooms_count_from_the_edge_of_their_wall_and_openings_as_planned() -> None:
    plan = np.array([[1.0, 2.0, np.pi / 2], [3.0, 2.0, 0.0]])
    found = edged(Gateways(plan, ("RIGHT ROOM", "CROSS"), ("E", "G")))
    np.testing.assert_allclose(found.poses, [[1.0, 2.06, np.pi / 2], [3.0, 2.0, 0.0]])
