"""Trips that a policy steers: where they start, when they end, what is written down."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.sim_world import block, box_room, hall_world, stage_of, true_rig

from fpnav.logs.frames import open_log
from fpnav.navigation.base import HALT, Command, Decision
from fpnav.sim.mission import Order, cut, following, homing, length_of, pose_from, world_of_map
from fpnav.sim.stage import set_stage
from fpnav.sim.trips import STILL, Expedition, starts_around, travel
from fpnav.sim.world import Route
from fpnav.values import Frame, Pose2

EAST = Route("east", ((1.0, 3.0), (6.0, 3.0)))


class Straight:
    """Straight on for a number of decisions, then it has arrived."""

    def __init__(self, decisions: int = 10**6) -> None:
        self.left = decisions
        self.decision = Decision(-1, 0.0, math.nan)

    def act(self, frame: Frame) -> Command:
        self.left -= 1
        self.decision = Decision(7, 0.5, 0.1, arrived=self.left < 0)
        return HALT if self.left < 0 else Command(0.5, 0.0)

    decide = None


def expedition(decisions: int = 100, *, follow: bool = False, trips: int = 1) -> Expedition:
    starts = [Pose2(1.0, 3.0, 0.0)] * trips
    return Expedition(true_rig("scan"), EAST, starts, decisions, follow=follow)


def test_a_trip_along_a_route_ends_where_the_route_ends() -> None:
    rows = travel(set_stage(hall_world()), expedition(follow=True), Straight)  # type: ignore[arg-type]
    assert rows["truth"][-1, 0] == pytest.approx(6.0, abs=0.13)
    assert set(rows["place"].tolist()) == {7}


def test_a_trip_ends_a_while_after_the_policy_has_arrived() -> None:
    rows = travel(set_stage(hall_world()), expedition(), lambda: Straight(5))  # type: ignore[arg-type, return-value]
    assert len(rows) == 5 + STILL


def test_every_trip_starts_anew_and_all_are_in_one_log(tmp_path: Path) -> None:
    path = tmp_path / "trips.mcap"
    stage = set_stage(hall_world())
    rows = travel(stage, expedition(6, trips=3), Straight, path)  # type: ignore[arg-type]
    assert np.bincount(rows["trip"]).tolist() == [6, 6, 6]
    assert rows["truth"][::6, 0] == pytest.approx([1.0] * 3, abs=0.02)
    with open_log(path, {}) as log:
        stamps = np.array([reference.stamp_ns for reference in log.references()])
    assert stamps - rows["stamp_ns"] == pytest.approx(15e6)  # a scan is taken 15 ms late


def test_starts_fill_the_disc_evenly_and_keep_clear_of_things() -> None:
    starts = starts_around((2.0, 1.0), 1.5, 2000, 1, 1, lambda pose: pose.x_m > 1.0)
    away = np.array([math.hypot(p.x_m - 2.0, p.y_m - 1.0) for p in starts])
    assert away.max() <= 1.5
    assert min(p.x_m for p in starts) > 1.0
    free = starts_around((0.0, 0.0), 2.0, 4000, 1, 1, lambda pose: True)
    inner = np.mean([math.hypot(p.x_m, p.y_m) < 1.0 for p in free])
    assert inner == pytest.approx(0.25, abs=0.03)


def test_homing_starts_outside_of_things() -> None:
    stage = stage_of([*box_room(8.0, 6.0), *block(4.0, 2.0, 5.0, 4.0)])
    trip = homing(stage, true_rig("scan"), (3.5, 3.0), Order(trips=20, within_m=1.0))
    assert len(trip.starts) == 20
    assert max(start.x_m for start in trip.starts) < 3.8


def test_a_route_of_the_world_is_followed_from_its_start() -> None:
    stage = set_stage(hall_world())
    trip = following(stage, true_rig("scan", capture={"length_m": 2.0}), "across", 0.5, Order())
    assert trip.starts == [Pose2(1.0, 3.0, 0.0)]
    assert trip.route.points == ((1.0, 3.0), (3.0, 3.0))
    assert trip.decisions == 2 * 2.0 / 0.5 / 0.25


def test_ways_are_cut_between_their_points() -> None:
    way = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0))
    assert length_of(way) == 4.0
    assert cut(way, 3.0) == [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)]
    assert cut(way, 9.0) == list(way)


def test_a_pose_is_read_with_or_without_a_heading() -> None:
    assert pose_from("1,2") == Pose2(1.0, 2.0, 0.0)
    assert pose_from("1,2,90").heading_rad == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("wrong", ["1", "1,2,3,4", "a,b", "nan,1"])
def test_other_words_are_no_pose(wrong: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        pose_from(wrong)


def test_the_world_of_a_map_is_found_in_its_chain() -> None:
    world = {"world": "room", "seed": 3, "run": 1, "rooms": []}
    header = {"chain": [{"worlds": [None, world]}]}
    assert world_of_map(header) == {"world": "room", "seed": 3, "run": 1}
    assert world_of_map(SimpleNamespace(get=lambda *_: ()).__dict__) is None
