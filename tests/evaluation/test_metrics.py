"""Every metric on an example small enough to work by hand, and the reasons for absent ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.results import (
    chain_edges,
    header,
    nowhere,
    office_run,
    on_map,
    recognition,
    revisit_run,
    rows,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import spearmanr

from fpnav.evaluation.evaluate import OUTCOMES, Evaluation, evaluate
from fpnav.evaluation.loops import returning_stays, returns
from fpnav.evaluation.places import kidnaps
from fpnav.evaluation.poses import weighted_spearman
from fpnav.evaluation.table import METRICS
from fpnav.store.tables import Accepted


def value(evaluation: Evaluation, name: str) -> tuple[float, int, int]:
    metric = evaluation.metrics[name]
    return metric.value, metric.n, metric.of


# Three references; query 0 finds its match first, 1 second, 2 has none, 3 third.
RANKED = recognition(
    [[0.9, 0.1, 0.0], [0.9, 0.8, 0.1], [0.5, 0.4, 0.3], [0.9, 0.8, 0.7]],
    pairs={0: [0], 1: [1], 3: [2]},
)


def test_recall_states_both_denominators() -> None:
    found = evaluate(RANKED)
    assert value(found, "recall_at_1") == (pytest.approx(1 / 3), 1, 3)
    assert value(found, "recall_at_1_all") == (pytest.approx(1 / 4), 1, 4)
    assert value(found, "recall_at_5") == (1.0, 3, 3)
    assert value(found, "recall_at_5_all") == (pytest.approx(3 / 4), 3, 4)


def test_abstaining_does_not_change_the_ranking() -> None:
    silent = replace(RANKED, decision=np.full(4, -1))
    found = evaluate(silent)
    assert value(found, "recall_at_1")[1:] == (1, 3)
    assert value(found, "not_localized") == (1.0, 4, 4)
    assert found.absent["decision_precision"] == "every decision was withheld"


def test_decisions_and_new_places_are_counted_apart() -> None:
    found = evaluate(replace(RANKED, decision=np.array([0, 0, -1, -1])))
    assert value(found, "decision_precision") == (0.5, 1, 2)
    assert value(found, "new_place_recall") == (1.0, 1, 1)
    assert [OUTCOMES[code] for code in found.table["outcome"]] == [
        "right",
        "wrong",
        "not localized",
        "not localized",
    ]
    assert found.table["rank_of_match"].tolist() == [1, 2, 0, 3]


def test_a_ranking_cut_short_has_no_recall_beyond_its_depth() -> None:
    shallow = recognition(np.eye(12), pairs={row: [row] for row in range(12)}, depth=3)
    found = evaluate(shallow)
    assert found.metrics["recall_at_1"].value == 1.0
    assert found.absent["recall_at_10"] == "the ranking saved is 3 deep"


def test_stated_probabilities_by_hand() -> None:
    # stated .9 .6 .6 .1, right yes yes no no; base rate one half
    result = recognition(
        np.tile([0.9, 0.1], (4, 1)),
        pairs={0: [0], 1: [0], 2: [1], 3: [1]},
        stated=np.array([0.9, 0.6, 0.6, 0.1]),
    )
    found = evaluate(result)
    brier = (0.1**2 + 0.4**2 + 0.6**2 + 0.1**2) / 4
    assert value(found, "brier_skill") == (pytest.approx(1 - brier / 0.25), 4, 4)
    # bins .9: |.9 - 1|, .6: |.6 - .5| for two, .1: |.1 - 0|
    assert value(found, "ece") == (pytest.approx((0.1 + 2 * 0.1 + 0.1) / 4), 4, 4)


@pytest.mark.parametrize(
    ("stated", "reason"),
    [
        ([np.nan] * 4, "no probabilities are stated"),
        ([1.5, 0.5, 0.5, 0.5], "stated values lie outside 0 .. 1: they are no probabilities"),
    ],
)
def test_what_is_no_probability_is_not_calibrated(stated: list[float], reason: str) -> None:
    found = evaluate(replace(RANKED, stated=np.array(stated)))
    assert found.absent["ece"] == found.absent["brier_skill"] == reason


def test_there_is_no_skill_where_all_are_right() -> None:
    result = recognition([[1.0]], pairs={0: [0]}, stated=np.array([0.8]))
    found = evaluate(result)
    assert found.absent["brier_skill"].startswith("all answers are right")
    assert value(found, "ece") == (pytest.approx(0.2), 1, 1)


LINE = [[x, 0.0, 0.0] for x in range(6)]  # mapping poses a metre apart, places 0 0 1 1 2 2
OWNER = [0, 0, 1, 1, 2, 2]


def line_run(queries: Any, answers: Any, **fields: Any) -> Evaluation:
    return evaluate(on_map(LINE, OWNER, queries, answers, edges=[(0, 1), (1, 2)], **fields))


def test_place_accuracy_counts_queries_that_stand_in_a_place() -> None:
    found = line_run(
        [[0.2, 0, 0], [2.1, 0, 0], [4.9, 0, 0], [50, 0, 0]],
        [[0, 1, 2], [0, 1, 2], [0, 1, 2], [0, 1, 2]],
    )
    assert value(found, "place_accuracy_top1") == (pytest.approx(1 / 3), 1, 3)
    assert value(found, "place_accuracy_top3") == (1.0, 3, 3)
    assert found.metrics["places"].value == 3.0


def test_a_neighbour_at_the_border_counts_for_the_tolerant_figure_alone() -> None:
    mapping = [[0.3 * x, 0, 0] for x in range(6)]
    result = on_map(
        mapping, OWNER, [[0.35, 0.1, 0], [-0.2, 0.1, 0]], [[1], [1]], edges=[(0, 1), (1, 2)]
    )
    found = evaluate(result)
    # place 1 begins at 0.45 m: 0.1 m from the first query, 0.65 m from the second
    assert value(found, "place_accuracy_top1") == (0.0, 0, 2)
    assert value(found, "place_accuracy_top1_tolerant") == (0.5, 1, 2)


def missions(decisions: list[int], answers: list[int]) -> Evaluation:
    queries = [[0.2, 0, 0]] * len(answers)
    return line_run(queries, [[answer] for answer in answers], decision=np.array(decisions))


def test_a_mission_needs_a_right_end_and_no_wrong_decision() -> None:
    # 20 missions of two queries; the first ends wrong, the second decides wrong on the way,
    # the third has a wrong guess on the way but withholds it
    answers, decisions = [0] * 40, [0] * 40
    answers[1], decisions[1] = 1, -1
    answers[2], decisions[2] = 1, 1
    answers[4], decisions[4] = 1, -1
    assert value(missions(decisions, answers), "mission_success") == (0.9, 18, 20)


def test_too_short_a_run_has_no_missions() -> None:
    found = missions([0] * 19, [0] * 19)
    assert found.absent["mission_success"] == "19 queries stand in a place, 20 missions need 20"


def test_recovery_is_travel_from_the_jump_to_the_first_right_decision() -> None:
    path = np.array(
        [[0.4 * i, 0.0, 0.0] for i in range(6)] + [[5.0, 0.1 * i, 0.0] for i in range(6)]
    )
    right = [0, 0, 0, 0, 1, 1] + [2] * 6
    wrong_first = [*right[:6], 0, 0, 0, 2, 2, 2]
    found = line_run(path, [[place] for place in wrong_first])
    # the first pose behind the jump is where travel is counted from: three steps of 0.1 m
    assert value(found, "kidnap_recovery_m") == (pytest.approx(0.3), 1, 1)
    lost = line_run(path, [[place] for place in [*right[:6], 0, 0, 0, 0, 0, 0]])
    assert lost.absent["kidnap_recovery_m"] == "no kidnapping of 1 was recovered from"


def test_a_jump_is_a_kidnapping_a_long_step_is_not() -> None:
    strides = np.array([[3.0 * i, 0, 0] for i in range(10)])
    assert kidnaps(strides, np.zeros(10, np.int32)).tolist() == []
    strides[5:, 1] = 100.0
    assert kidnaps(strides, np.zeros(10, np.int32)).tolist() == [5]
    assert kidnaps(strides[:5], np.array([0, 0, 0, 1, 1])).tolist() == [3]


def test_position_error_is_the_median_over_queries_with_a_match() -> None:
    references = rows([[0, 0, 0], [10, 0, 0]])
    queries = rows([[0.1, 0, 0], [0.5, 0, 0], [9.0, 0, 0], [100, 0, 0]])
    result = recognition([[1, 0], [1, 0], [0, 1], [1, 0]], queries=queries, references=references)
    assert value(evaluate(result), "position_error_median_m") == (pytest.approx(0.5), 3, 3)


def test_heading_error_is_measured_where_the_answer_is_right() -> None:
    queries = [[0.2, 0, 0.0], [0.3, 0, 1.0], [4.1, 0, 0.0]]
    headings = np.array([[math.radians(4)], [1.0 + math.radians(-8)], [2.0]])
    found = line_run(queries, [[0], [0], [0]], headings_rad=headings)
    assert value(found, "heading_error_median_deg") == (pytest.approx(6.0), 2, 2)


def test_scores_that_fall_off_around_a_place_give_a_strongly_negative_rho() -> None:
    queries = [[0.1 * i, 0, 0] for i in range(51)]
    centres = np.array([0.5, 2.5, 4.5])
    scores = -np.abs(np.array(queries)[:, :1] - centres)
    order = np.argsort(-scores, axis=1)
    found = line_run(queries, order, scores=np.take_along_axis(scores, order, axis=1))
    rho, n, of = value(found, "field_rho")
    assert rho == pytest.approx(-1.0)
    assert n == of


@given(
    st.lists(
        st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(0, 3)), min_size=3, max_size=30
    )
)
def test_weighted_rho_is_scipys_of_the_repeated_sample(units: list[tuple[int, int, int]]) -> None:
    table = np.array(units, dtype=float)
    repeated = np.repeat(table, table[:, 2].astype(int), axis=0)
    if len(repeated) < 2 or np.ptp(repeated[:, 0]) == 0 or np.ptp(repeated[:, 1]) == 0:
        return
    ours = weighted_spearman(table[:, 0], table[:, 1], table[None, :, 2])[0]
    assert ours == pytest.approx(spearmanr(repeated[:, 0], repeated[:, 1]).statistic)


def test_a_place_entered_again_is_a_loop_the_map_closed() -> None:
    assert returning_stays(np.array([0, 0, 1, 1, 0, 2, 1, 1])) == [(4, 4), (6, 7)]
    assert returning_stays(np.array([0, 1, 2])) == []


def test_returns_are_stretches_along_an_earlier_path_not_crossings() -> None:
    out_and_up = np.array([[x, 0, 0] for x in np.arange(0, 20, 0.5)], dtype=float)
    crossing = np.array([[10, y, 0] for y in np.arange(20, -20, -0.5)], dtype=float)
    again = np.array([[x, 0.3, 0] for x in np.arange(0, 5, 0.5)], dtype=float)
    assert returns(out_and_up) == []
    path = np.vstack([out_and_up, crossing, again])
    driven_again = (len(path) - len(again), len(path) - 1)
    assert returns(path)[-1] == driven_again
    assert all(b - a <= 4 for a, b in returns(path)[:-1])


def test_loops_of_a_map_by_hand() -> None:
    lap = np.array([[x, 0, 0] for x in range(10)] + [[9 - x, 9, 0] for x in range(10)], dtype=float)
    path = np.vstack([lap, lap[:4]])
    owner = np.repeat(np.arange(12), 2)
    closed = owner.copy()
    closed[20:22], closed[22:24] = 0, 5  # the first return is closed right, the second wrongly
    found = evaluate(on_map(path, closed.tolist(), [[0, 0, 0]], [[0]]))
    assert value(found, "loop_precision") == (0.5, 1, 2)
    assert value(found, "loop_recall") == (1.0, 1, 1)
    open_map = evaluate(on_map(path, owner.tolist(), [[0, 0, 0]], [[0]]))
    assert open_map.absent["loop_precision"] == "no loop was closed while the map was built"
    assert value(open_map, "loop_recall") == (0.0, 0, 1)


def test_loops_of_a_run_against_its_past_are_its_decisions() -> None:
    found = evaluate(revisit_run())
    assert value(found, "loop_precision") == value(found, "decision_precision")
    assert found.metrics["loop_recall"].of == found.metrics["recall_at_1"].of


def test_two_runs_have_no_loops() -> None:
    assert "query run against reference run" in evaluate(RANKED).absent["loop_recall"]


def test_without_truth_nothing_is_called_right_or_wrong() -> None:
    result = recognition(np.ones((3, 2)), truth=Accepted("none", "none"), queries=nowhere(3))
    found = evaluate(result)
    assert set(found.metrics) == {"not_localized"}
    assert found.absent["recall_at_1"].startswith("no ground truth")
    assert {OUTCOMES[code] for code in found.table["outcome"]} == {"not judged"}


def test_a_result_without_queries_is_measured_without_a_crash() -> None:
    result = recognition(np.zeros((0, 4)), pairs={})
    found = evaluate(result)
    assert found.metrics == {}
    assert set(found.absent) == set(METRICS)


def test_every_metric_is_measured_or_absent_with_a_reason() -> None:
    for result in (office_run(), office_run("match", quality=0.5), revisit_run(), RANKED):
        found = evaluate(result)
        assert set(found.metrics) | set(found.absent) == set(METRICS)
        assert not set(found.metrics) & set(found.absent)
        assert all(found.absent.values())
        for metric in found.metrics.values():
            assert math.isfinite(metric.value)
            assert 0 <= metric.n <= metric.of
            assert math.isnan(metric.low) or metric.low <= metric.high


def test_the_same_result_gives_the_same_evaluation() -> None:
    first, second = evaluate(office_run("match")), evaluate(office_run("match"))
    assert first.metrics == second.metrics
    assert first.table.tobytes() == second.table.tobytes()


def test_the_chain_leads_from_the_result_to_the_log() -> None:
    chain = evaluate(recognition([[1.0]], pairs={0: [0]})).chain
    assert [link["format"] for link in chain] == ["fpnav/result", "fpnav/signatures"]
    assert chain[-1]["sources"][0]["name"] == "drive.mcap"


def test_no_metric_asks_for_a_systems_name() -> None:
    named = replace(RANKED, header={**header("recognize"), "system": "anything"})
    assert evaluate(named).metrics == evaluate(RANKED).metrics


def test_edges_join_places_in_both_directions() -> None:
    assert chain_edges([(0, 1)])["target"].tolist() == [1]
