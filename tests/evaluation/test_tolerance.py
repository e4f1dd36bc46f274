"""Recall over the radius: the base grows with it, heading and candidates stay."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.results import header, on_map, recognition, revisit_run, rows

from fpnav.evaluation.case import judge
from fpnav.evaluation.tolerance import tolerance_sweep
from fpnav.store.tables import Result

REFERENCES = rows([[0, 0, 0], [3, 0, 0], [3, 0, 3.0]])
QUERIES = rows([[0.4, 0, 0], [1.8, 0, 0], [3.1, 0, 3.0]])


def run(heading: object = 45) -> Result:
    # best answers: 0 (0.4 m off), 0 (1.8 m off though 1 is nearer), 1 (0.1 m off, turned round)
    scores = [[0.9, 0.1, 0.0], [0.9, 0.1, 0.0], [0.0, 0.9, 0.1]]
    facts = header("recognize", protocol={"radius_m": 1.5, "heading_deg": heading})
    return recognition(scores, queries=QUERIES, references=REFERENCES, header=facts)


def test_right_and_base_are_counted_at_each_radius() -> None:
    found = tolerance_sweep(judge(run()), np.array([0.2, 0.5, 1.5, 2.0]))
    assert found is not None
    assert found.base.tolist() == [1, 2, 3, 3]
    assert found.right.tolist() == [0, 1, 1, 2]


def test_any_heading_lets_the_turned_answer_count() -> None:
    found = tolerance_sweep(judge(run("any")), np.array([0.2]))
    assert found is not None
    assert (found.right.tolist(), found.base.tolist()) == ([1], [1])


def test_at_the_radius_of_the_protocol_it_is_the_recall() -> None:
    case = judge(revisit_run(quality=0.3))
    found = tolerance_sweep(case, np.array([1.5]))
    assert found is not None
    assert found.base[0] == case.has_match.sum()
    assert found.right[0] == (case.best_right & case.has_match).sum()


@pytest.mark.parametrize(
    "result",
    [
        on_map([[0, 0, 0]], [0], [[0, 0, 0]], [[0]]),
        recognition([[1.0]], pairs={0: [0]}),
        recognition(np.zeros((0, 1))),
    ],
    ids=["map", "pairs", "no query"],
)
def test_there_is_none_without_poses_of_frames(result: Result) -> None:
    assert tolerance_sweep(judge(result)) is None
