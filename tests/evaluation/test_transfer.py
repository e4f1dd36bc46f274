"""Thresholds chosen on one run and carried to another, by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.results import header, recognition

from fpnav.evaluation import curve
from fpnav.evaluation.case import judge
from fpnav.evaluation.evaluate import Evaluation, evaluate
from fpnav.evaluation.transfer import (
    Carried,
    carry,
    share_reaching,
    threshold_at_precision,
    threshold_at_share,
)
from fpnav.store.tables import Result


def run(name: str, scores: list[float], right: list[bool | None], **facts: Any) -> Result:
    """One best answer a query; None = the query has no match, so the answer is wrong."""
    matrix = np.zeros((len(scores), 3))
    matrix[:, 0] = scores
    pairs = {row: [0] if ok else [1] for row, ok in enumerate(right) if ok is not None}
    made = header("recognize", sources=[{"name": name}], **facts)
    return recognition(matrix, pairs=pairs, header=made)


# there  .9 yes  .8 yes  .7 no  .6 yes  .5 no: all right down to .8, which 2 of 5 reach
THERE = run("there", [0.9, 0.8, 0.7, 0.6, 0.5], [True, True, False, True, False])
# here, a tenth of the scores: 40 % of ten is four answers, so down to .06; three of them are right
HERE = run(
    "here",
    [0.09, 0.08, 0.07, 0.06, 0.05, 0.04, 0.03, 0.02, 0.015, 0.01],
    [True, True, None, True, True, False, None, None, None, False],
)


def measured(result: Result = HERE, other: Result = THERE) -> Evaluation:
    return evaluate(result, judge(other))


def counts(found: Evaluation, name: str) -> tuple[int, int]:
    return found.metrics[name].n, found.metrics[name].of


def test_a_threshold_is_carried_by_its_quantile() -> None:
    case = replace(judge(HERE), chosen_on=judge(THERE))
    assert carry(case, 1.0) == Carried(chosen=0.8, accepted=0.4, here=0.06)


def test_precision_and_recall_are_those_of_this_run_at_the_carried_threshold() -> None:
    found = measured()
    assert counts(found, "precision_at_carried_100") == (3, 4)
    assert counts(found, "recall_at_carried_100") == (3, 6)
    assert found.metrics["precision_at_carried_100"].value == pytest.approx(0.75)


def test_the_truth_of_this_run_does_not_move_the_threshold() -> None:
    opposite = replace(HERE, truth=run("x", [0.0] * 10, [False] * 10).truth)
    for least in (1.0, 0.99):
        one, two = (replace(judge(r), chosen_on=judge(THERE)) for r in (HERE, opposite))
        assert carry(one, least) == carry(two, least)


def test_the_threshold_of_a_precision_is_where_recall_is_largest() -> None:
    answers = curve.sweep(judge(THERE))
    assert threshold_at_precision(answers, 1.0) == 0.8
    assert threshold_at_precision(answers, 0.75) == 0.6
    wrong_first = curve.sweep(judge(run("w", [0.9, 0.8], [False, True])))
    assert threshold_at_precision(wrong_first, 1.0) is None


def test_equal_scores_are_accepted_together_or_not_at_all() -> None:
    scores = np.array([0.9, 0.7, 0.7, 0.1])
    assert share_reaching(scores, 0.7) == 0.75
    assert threshold_at_share(scores, 0.75) == 0.7
    assert threshold_at_share(scores, 0.5) == 0.9
    assert threshold_at_share(scores, 0.2) == np.inf
    assert threshold_at_share(scores, 1.0) == 0.1


@pytest.mark.parametrize(
    ("result", "other", "reason"),
    [
        (THERE, THERE, "this very run"),
        (HERE, run("o", [0.9], [True], system="polar"), "by polar, paper, recognize; this one"),
        (HERE, run("o", [0.9, 0.8], [False, True]), "never reaches 100 % precision"),
        (HERE, run("o", [], []), "never reaches 100 % precision"),
        (run("e", [], []), THERE, "no query has an answer"),
    ],
)
def test_what_cannot_be_carried_is_absent_with_its_reason(
    result: Result, other: Result, reason: str
) -> None:
    assert reason in measured(result, other).absent["precision_at_carried_100"]
    assert reason in measured(result, other).absent["recall_at_carried_100"]


def test_a_share_too_small_for_any_answer_accepts_none() -> None:
    many = run("many", list(np.linspace(1, 0.5, 20)), [True, *[False] * 19])
    found = measured(run("few", [0.9, 0.8], [True, True]), many)
    assert "no answer reaches" in found.absent["precision_at_carried_100"]
    assert counts(found, "recall_at_carried_100") == (0, 2)


def test_without_another_run_the_reason_names_the_option() -> None:
    assert "--threshold-from" in evaluate(HERE).absent["recall_at_carried_99"]
