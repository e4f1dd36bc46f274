"""Systems of one laser descriptor a scan: what each finds, and how the turn is told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.geometry import relative
from fpnav.matching.sweeps import correlated, searched, turns_between
from fpnav.systems.correlative import Correlative, CorrelativeParams
from fpnav.systems.lasers import sweep_of
from fpnav.systems.registry import system_class
from fpnav.values import Decoded, Frame, Pose2, Reference, Signature

PEERS = ("polar", "cornerpairs", "correlative")
HERE = Pose2(3.0, 0.1, 0.2)
NEAR, AWAY = Pose2(3.2, 0.0, 0.5), Pose2(8.2, 0.0, 2.0)


def seen(name: str, pose: Pose2, fov_rad: float = math.pi) -> Signature:
    kind = system_class(name)
    system = kind(kind.PRESETS["default"])
    scan = small_world.scan(pose, round(math.degrees(fov_rad)), fov_rad)
    frame = Frame(Reference(0, 0), {"scan": Decoded(scan)})
    return next(iter(system.assemble([(frame.reference, system.describe(frame))])))


def recalled(name: str, query: Signature, *places: Signature):  # type: ignore[no-untyped-def]
    kind = system_class(name)
    memory = kind(kind.PRESETS["default"]).memory()
    memory.fit(places)
    for place, one in enumerate(places):
        memory.learn(place, one)
    return memory.recall([query], len(places), None, None)[0]


@pytest.mark.parametrize("name", PEERS)
def test_the_nearer_place_comes_first(name: str) -> None:
    found = recalled(name, seen(name, HERE), seen(name, AWAY), seen(name, NEAR))
    assert found.places[0].tolist() == [1, 0]


@pytest.mark.parametrize("name", ["polar", "cornerpairs"])
def test_full_circles_are_turned_all_round(name: str) -> None:
    """A pair counts in both directions, so that half a turn leaves its histogram as it was."""
    back = Pose2(3.0, 0.1, 0.2 + math.pi)
    found = recalled(name, seen(name, HERE, math.tau), seen(name, back, math.tau))
    assert found.scores[0, 0] > 0.9
    turn = abs(found.headings_rad[0, 0])
    assert name == "cornerpairs" or turn == pytest.approx(math.pi, abs=math.radians(12.0))


def test_scan_matching_gives_the_pose_of_those_it_checks_and_leaves_the_rest() -> None:
    system = Correlative(CorrelativeParams(checked=2))
    query, away, near = (seen("correlative", one) for one in (HERE, AWAY, NEAR))
    found = system.verify(query, [away, near, near])
    assert found is not None
    assert np.argsort(-found.scores).tolist() == [1, 0, 2]
    pose, truth = found.relative[1], relative(NEAR, HERE)
    assert pose is not None
    assert pose.pose.x_m == pytest.approx(truth.x_m, abs=0.1)
    assert pose.pose.heading_rad == pytest.approx(truth.heading_rad, abs=math.radians(3.0))
    assert found.relative[2] is None


def test_the_bounded_search_equals_trying_every_overlay() -> None:
    mine, other = (sweep_of(seen("polar", one).parts["rays"]) for one in (HERE, NEAR))
    turns = turns_between(mine, other, math.radians(30), math.radians(3))
    value, pose = correlated(mine, other, turns, 1.0, 0.1)
    fine, _ = mine.fields
    points = np.column_stack(other.outline)
    best = 0.0
    for turn in turns:
        c, s = math.cos(turn), math.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        for x in np.arange(-10, 10) * 0.1:
            for y in np.arange(-10, 10) * 0.1:
                cells = np.floor((turned + [x, y] + 16.0) / 0.2).astype(int)
                best = max(best, float(fine[cells[:, 0], cells[:, 1]].mean()))
    assert value == pytest.approx(best, abs=0.01)
    assert value >= searched(mine, other, turns, 3)[:, 0].max() - 0.05
    assert pose[2] == pytest.approx(relative(HERE, NEAR).heading_rad, abs=math.radians(3.1))
