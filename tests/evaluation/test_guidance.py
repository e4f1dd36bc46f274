"""Trips and actions beside what the teacher would do, on made-up decisions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.stores import result as stored_result

from fpnav.evaluation.case import judge
from fpnav.evaluation.guidance import MEASURES, action_error, ends_from, way_of
from fpnav.evaluation.measure import Absent
from fpnav.store.tables import ACTION, Result
from fpnav.values import Metric

CORNER = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]


def decisions(
    poses: list[tuple[float, float, float]], wanted: float = 0.0, trip: int = 0
) -> np.ndarray[Any, Any]:
    rows = np.zeros(len(poses), ACTION)
    rows["trip"], rows["truth"], rows["wanted_rad"] = trip, poses, wanted
    return rows


def result_of(actions: np.ndarray[Any, Any], **task: Any) -> Result:
    plain = stored_result()
    header = {**plain.header, "protocol": {"task": {"driven": True, **task}}}
    return replace(plain, header=header, actions=actions)


def measured(name: str, result: Result) -> Metric | Absent:
    return MEASURES[name](name, judge(result))


def test_a_trip_is_home_when_it_ends_near_the_goal() -> None:
    near = decisions([(1.0, 0.0, 0.0), (0.2, 0.1, 0.0)], trip=0)
    past = decisions([(0.1, 0.0, 0.0), (0.4, 0.0, 0.0)], trip=1)
    found = measured("homing_success", result_of(np.concatenate([near, past]), goal_m=[0, 0]))
    assert isinstance(found, Metric)
    assert (found.n, found.of) == (1, 2)
    ends = ends_from(np.concatenate([near, past]), np.zeros(2))
    assert ends == pytest.approx([math.hypot(0.2, 0.1), 0.4])


@pytest.mark.parametrize(("wanted_deg", "right"), [(180.0, 2), (140.0, 2), (130.0, 0), (0.0, 0)])
def test_actions_are_compared_with_the_way_to_the_goal(wanted_deg: float, right: int) -> None:
    actions = decisions([(2.0, 0.0, 0.0), (1.0, 0.0, 0.0)], math.radians(wanted_deg))
    found = measured("action_within_45", result_of(actions, goal_m=[0.0, 0.0]))
    assert isinstance(found, Metric)
    assert (found.n, found.of) == (right, 2)


def test_a_decision_without_a_direction_is_wrong_and_none_is_asked_at_the_goal() -> None:
    actions = decisions([(2.0, 0.0, 0.0), (0.1, 0.0, 0.0)], math.nan)
    found = measured("action_within_45", result_of(actions, goal_m=[0.0, 0.0]))
    assert isinstance(found, Metric)
    assert (found.n, found.of) == (0, 1)


def test_the_teacher_of_a_route_turns_where_the_route_turns() -> None:
    actions = decisions([(5.0, 0.5, 0.0), (10.2, 5.0, 0.0), (10.0, 10.0, math.pi / 2)])
    error = action_error(result_of(actions, way_m=CORNER))
    assert error == pytest.approx([0.0, math.pi / 2, 0.0], abs=1e-6)


def test_a_route_is_closed_when_all_of_it_is_passed_without_straying() -> None:
    along = [(float(x), 0.3, 0.0) for x in range(10)] + [(10.3, float(y), 0.0) for y in range(10)]
    trips = {
        "whole": along,
        "short": along[:14],
        "astray": [*along[:5], (4.0, 6.0, 0.0), *along[5:]],
        "a cut": [along[0], along[-1]],
    }
    closed = {}
    for name, poses in trips.items():
        found = measured("route_closed", result_of(decisions(poses), way_m=CORNER))
        assert isinstance(found, Metric)
        closed[name] = found.value == 1.0
    assert closed == {"whole": True, "short": False, "astray": False, "a cut": False}


def test_without_a_route_of_its_own_the_way_is_that_of_the_mapping_run() -> None:
    result = result_of(decisions([(0.0, 0.0, 0.0)]))
    known = result.references["truth"][np.isfinite(result.references["truth"]).all(axis=1), :2]
    assert way_of(result)[0] == pytest.approx(known[0])


def test_results_of_other_commands_say_why_there_is_nothing() -> None:
    for name in MEASURES:
        found = measured(name, stored_result())
        assert isinstance(found, Absent)
        assert "navigate" in found.reason


def test_nobody_comes_home_on_a_log() -> None:
    result = result_of(decisions([(0.0, 0.0, 0.0)]), goal_m=[0.0, 0.0], driven=False)
    found = measured("homing_success", result)
    assert isinstance(found, Absent)
    assert "moved nobody" in found.reason
