"""Opening and closing of one side."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.sensing.openings import Change, Edge, Evidence, Side, Threshold
from fpnav.sensing.walls import LEFT, Wall


def threshold() -> Change:
    return Threshold(0.5, 0.25, 2)


def evidence() -> Change:
    return Evidence(0.25, 0.05, 5.0)


def side(change: Change) -> Side:
    return Side(Wall(LEFT, 1.5, 1.5, 2.5), change, 0.5)


def edges(one: Side, ranges: list[float], step_m: float = 0.1) -> list[Edge]:
    found = (one.update(step_m * i, 0.0, r) for i, r in enumerate(ranges))
    return [edge for edge in found if edge is not None]


DOOR = [1.0] * 10 + [3.0] * 8 + [1.0] * 6


@pytest.mark.parametrize("change", [threshold, evidence])
def test_an_opening_lies_between_the_readings_at_its_ends(change: type) -> None:
    found = edges(side(change()), DOOR)
    assert [edge.opens for edge in found] == [True, False]
    assert [edge.at_m for edge in found] == pytest.approx([0.95, 1.75])


@pytest.mark.parametrize("change", [threshold, evidence])
def test_one_far_reading_opens_nothing_and_one_near_reading_closes_nothing(change: type) -> None:
    assert edges(side(change()), [1.0] * 10 + [3.0] + [1.0] * 10) == []
    one = side(change())
    found = edges(one, [1.0] * 10 + [3.0] * 4 + [1.0] + [3.0] * 4)
    assert [edge.opens for edge in found] == [True]
    assert one.opened


@pytest.mark.parametrize("change", [threshold, evidence])
def test_an_opening_without_an_echo_opens_too(change: type) -> None:
    found = edges(side(change()), [1.0] * 10 + [math.inf] * 8 + [1.0] * 6)
    assert [edge.opens for edge in found] == [True, False]


@pytest.mark.parametrize("change", [threshold, evidence])
def test_unknown_readings_say_nothing(change: type) -> None:
    found = edges(side(change()), [1.0] * 10 + [math.nan] * 5 + [1.0] * 5)
    assert found == []


def test_a_side_without_a_wall_does_not_open() -> None:
    one = side(threshold())
    assert edges(one, [4.0] * 10) == []
    assert not one.known


def test_the_wall_is_followed_as_the_robot_drifts() -> None:
    one = side(threshold())
    assert edges(one, [0.8 + 0.02 * i for i in range(40)]) == []
    assert one.wall_m == pytest.approx(1.43, abs=0.05)


def test_the_wall_before_the_opening_decides_where_it_closes() -> None:
    one = side(threshold())
    assert [e.opens for e in edges(one, [1.0] * 10 + [3.0] * 5 + [1.3] * 5)] == [True]
    assert [e.opens for e in edges(side(threshold()), [1.0] * 10 + [3.0] * 5 + [1.2] * 5)] == [
        True,
        False,
    ]


def test_a_side_that_is_lost_needs_a_wall_again() -> None:
    one = side(threshold())
    edges(one, DOOR[:14])
    one.lose()
    assert not one.opened
    assert not one.known
    assert edges(one, DOOR) != []


def test_hidden_ends_grow_with_the_distance_of_the_wall() -> None:
    one = side(threshold())
    edges(one, [1.0] * 10)
    assert one.hidden_m(0.2) == pytest.approx(0.2 * 1.35)
    edges(one, [3.0] * 3)
    assert one.hidden_m(0.2) == pytest.approx(0.2 * 1.175)


def test_evidence_of_a_reading_is_the_log_ratio_of_its_densities() -> None:
    test = Evidence(0.25, 0.05, 5.0)
    assert test.ratio(9.0, 0.05) == pytest.approx(math.log(0.4 / 0.04))
    hit = 0.88 / (0.05 * math.sqrt(2 * math.pi)) + 0.02
    assert test.ratio(0.0, 0.05) == pytest.approx(max(-3.0, math.log(0.02 / hit)))
    assert test.ratio(0.24, 0.1) == pytest.approx(
        math.log(0.02 / (0.88 * math.exp(-2.88) / (0.1 * math.sqrt(2 * math.pi)) + 0.02))
    )
    assert test.ratio(1.0, 0.05) == pytest.approx(math.log((0.52 / 3.75 + 0.02) / 0.02))


def test_evidence_stands_more_noise_than_two_thresholds() -> None:
    invented = {threshold: 0, evidence: 0}
    for seed in range(40):
        rng = np.random.default_rng(seed)
        ranges = 1.0 + rng.normal(0.0, 0.05, 200)
        ranges[rng.random(200) < 0.12] = math.inf
        for change in invented:
            invented[change] += len(edges(side(change()), ranges.tolist())) > 0
    assert invented[evidence] < invented[threshold] / 2


@pytest.mark.parametrize("change", [threshold, evidence])
def test_somebody_standing_in_an_opening_does_not_close_it(change: type) -> None:
    ranges = [1.0] * 10 + [3.0] * 4 + [0.4] * 4 + [3.0] * 4 + [1.0] * 6
    found = edges(side(change()), ranges)
    assert [edge.opens for edge in found] == [True, False]
    assert found[1].at_m == pytest.approx(2.15)


@pytest.mark.parametrize("change", [threshold, evidence])
def test_a_wall_that_steps_back_is_no_opening_for_ever(change: type) -> None:
    one = side(change())
    found = edges(one, [1.0] * 10 + [1.8] * 20)
    assert [edge.opens for edge in found] == [True]
    assert not one.opened
    assert one.wall_m == pytest.approx(1.8)


def test_a_wall_needs_some_travel() -> None:
    one = side(threshold())
    edges(one, [0.5] * 4, step_m=0.05)
    assert not one.known


def test_a_cone_that_begins_nearer_to_the_wall_hides_less_of_an_opening() -> None:
    side = Side(Wall(LEFT, 1.5, 1.5, 2.5), Threshold(0.5, 0.25, 2), 0.5)
    for step in range(20):
        side.update(0.1 * step, 0.0, 1.0)
    assert side.hidden_m(0.25) == pytest.approx(0.3375)
    assert side.hidden_m(0.25, 0.2) == pytest.approx(0.2875)


def test_an_opening_begins_before_a_single_bad_echo_that_followed_its_first_reading() -> None:
    test = threshold()
    told = [test.update(reading, 1.0, 0.01, False) for reading in (1.0, 3.0, 1.1, 3.0, 3.0)]
    assert told == [0, 0, 0, 0, 4]
