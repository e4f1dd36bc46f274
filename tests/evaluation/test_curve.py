"""Precision and recall by hand, against scikit-learn, and the published score matrices."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.results import recognition, rows
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import average_precision_score

from fpnav.evaluation import curve
from fpnav.evaluation.case import Case, judge
from fpnav.evaluation.table import METRICS
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Metric


def answers(scores: list[float], right: list[bool | None]) -> Result:
    """One best answer a query; None = the query has no match at all, so the answer is wrong."""
    matrix = np.zeros((len(scores), 3))
    matrix[:, 0] = scores
    pairs = {row: [0] if ok else [1] for row, ok in enumerate(right) if ok is not None}
    return recognition(matrix, pairs=pairs)


def figure(result: Result, of: curve.Figure, case: Case | None = None) -> float:
    return float(of(curve.plain(curve.sweep(case or judge(result))))[0])


# score   .9    .8     .7    .6    .5    .4
# right   yes   yes    no    yes   no    yes      (no: a query with a match, answered wrong)
# tp/acc  1/1   2/2    2/3   3/4   3/5   4/6
# recall over six queries with a match: 1/6, 2/6, 2/6, 3/6, 3/6, 4/6
BY_HAND = answers([0.9, 0.8, 0.7, 0.6, 0.5, 0.4], [True, True, False, True, False, True])


@pytest.mark.parametrize(
    ("of", "expected"),
    [
        (curve.average_precision, (1 + 1 + 3 / 4 + 4 / 6) / 6),
        (
            curve.area,
            (1 + 1 + (2 / 3 + 3 / 4) / 2 + (3 / 5 + 4 / 6) / 2) / 6,
        ),
        (
            curve.area_of_correct,
            (1 + 1 + (2 / 3 + 3 / 4) / 2 + (3 / 5 + 4 / 6) / 2) / 4,
        ),
        (curve.recall_at_precision(1.0), 2 / 6),
        (curve.recall_at_precision(0.75), 3 / 6),
        (curve.recall_at_precision(0.99), 2 / 6),
        (curve.extended_precision, (1 + 2 / 4) / 2),
    ],
)
def test_six_answers_by_hand(of: curve.Figure, expected: float) -> None:
    assert figure(BY_HAND, of) == pytest.approx(expected)


def test_queries_without_a_match_are_negatives_but_no_recall_base() -> None:
    # .9 right, .8 a query that has no match at all, .7 right: precision 1, 1/2, 2/3
    result = answers([0.9, 0.8, 0.7], [True, None, True])
    assert figure(result, curve.average_precision) == pytest.approx((1 + 2 / 3) / 2)
    assert figure(result, curve.recall_at_precision(1.0)) == pytest.approx(1 / 2)


def test_equal_scores_share_one_threshold() -> None:
    # all at .5: three of four accepted answers right, in whatever order
    for right in ([True, False, True, True], [True, True, True, False]):
        result = answers([0.5] * 4, right)
        assert figure(result, curve.average_precision) == pytest.approx(3 / 4 * 3 / 4)
        assert figure(result, curve.recall_at_precision(1.0)) == 0.0


def test_the_most_confident_answer_wrong_gives_no_recall_at_full_precision() -> None:
    result = answers([0.9, 0.8], [False, True])
    assert figure(result, curve.recall_at_precision(1.0)) == 0.0
    assert figure(result, curve.extended_precision) == 0.0


def test_ninety_nine_of_a_hundred_reach_99_percent() -> None:
    result = answers(list(np.linspace(1, 0.5, 100)), [True] * 50 + [False] + [True] * 49)
    assert figure(result, curve.recall_at_precision(0.99)) == pytest.approx(0.99)


def test_a_near_miss_counts_neither_way_and_stays_in_the_recall_base() -> None:
    references = rows([[0, 0, 0], [10, 0, 0], [20, 0, 0]])
    queries = rows([[0.1, 0, 0], [8, 0, 0], [10.2, 0, 0]])
    # query 1 stands 2 m from its best answer: wrong, but ignored
    scores = [[0.9, 0, 0], [0, 0.8, 0], [0, 0.7, 0]]
    case = judge(recognition(scores, queries=queries, references=references))
    assert case.dont_care.tolist() == [False, True, False]
    plain = curve.plain(curve.sweep(case))
    aside = curve.plain(curve.sweep(case, ignore=case.dont_care))
    full = curve.recall_at_precision(1.0)
    assert full(plain)[0] == pytest.approx(1 / 2)
    assert full(aside)[0] == pytest.approx(1.0)


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.sampled_from([True, False, None])), min_size=2, max_size=40
    ).filter(lambda units: any(ok for _, ok in units))
)
def test_average_precision_is_scikit_learns_scaled_to_our_recall_base(
    units: list[tuple[int, bool | None]],
) -> None:
    scores = np.array([score + 1.0 for score, _ in units])
    right = np.array([ok is True for _, ok in units])
    base = sum(ok is not None for _, ok in units)
    ours = figure(answers(scores.tolist(), [ok for _, ok in units]), curve.average_precision)
    theirs = average_precision_score(right, scores)
    assert ours == pytest.approx(theirs * right.sum() / base)


@given(st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_weights_are_repetitions(size: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    case = judge(
        answers(
            random.integers(1, 5, size).astype(float).tolist(), (random.random(size) < 0.6).tolist()
        )
    )
    counts = random.integers(0, 3, size)
    counts[0] += 1
    weighted = curve.count(curve.sweep(case), counts[None, :].astype(float))
    chosen = np.repeat(np.arange(size), counts)
    score, ok = case.result.scores[chosen, 0], case.best_right[chosen]
    repeated = answers(score.tolist(), ok.tolist())
    for of in (curve.average_precision, curve.area, curve.recall_at_precision(1.0)):
        assert float(of(weighted)[0]) == pytest.approx(figure(repeated, of))


CORRIDOR = {
    # R@1, R@5, R@10, AUC over all queries, AUC of VPR-Bench, R@100P, EP (None: not printed)
    "HybridNet": (0.901, 0.991, 1.0, 0.844, 0.937, 0.252, 0.640),
    "AMOSNet": (0.847, 0.991, 1.0, 0.808, 0.954, 0.288, 0.670),
    "denseVLAD": (0.703, 0.955, 0.982, 0.627, 0.892, 0.243, 0.673),
    "AlexNet_VPR": (0.685, 0.901, 0.946, 0.552, 0.806, 0.027, None),
    "NetVLAD": (0.676, 0.937, 0.991, 0.555, 0.822, 0.072, 0.553),
    "CoHOG": (0.622, 0.892, 0.937, 0.427, 0.687, 0.027, None),
    "ap-gem-r101": (0.532, 0.811, 0.856, 0.454, 0.855, 0.036, None),
    "HOG": (0.477, 0.721, 0.829, 0.333, 0.697, 0.018, None),
    "RegionVLAD": (0.432, 0.712, 0.820, 0.297, 0.686, 0.0, None),
    "CALC": (0.324, 0.486, 0.604, 0.255, 0.788, 0.072, None),
}
SPEDTEST = {
    "HybridNet": (0.794, 0.901, 0.921, 0.718, 0.905, 0.021, None),
    "NetVLAD": (0.679, 0.830, 0.883, 0.556, 0.818, 0.021, None),
    "HOG": (0.499, 0.601, 0.671, 0.318, 0.638, 0.008, None),
    "CALC": (0.427, 0.562, 0.619, 0.290, 0.679, 0.016, None),
}
PRINTED = (
    "recall_at_1",
    "recall_at_5",
    "recall_at_10",
    "auc_pr",
    "auc_pr_vprbench",
    "recall_at_100_precision",
    "extended_precision",
)


def shipped(data: Path, name: str) -> tuple[dict[str, FloatArray], dict[int, list[int]]]:
    with np.load(data / "scores" / f"vprbench_{name}.npz") as file:
        scores = {method: file[method] for method in file}
    truth = json.loads((data / "scores" / f"vprbench_{name}_truth.json").read_text())
    return scores, {int(query): accepted for query, accepted in truth.items()}


@pytest.mark.parametrize(("name", "table"), [("corridor", CORRIDOR), ("spedtest", SPEDTEST)])
def test_score_matrices_of_others_give_their_figures_to_the_digits_printed(
    data: Path, name: str, table: dict[str, tuple[float | None, ...]]
) -> None:
    scores, pairs = shipped(data, name)
    assert set(scores) == set(table)
    for method, expected in table.items():
        case = judge(recognition(scores[method], pairs=pairs, depth=10))
        for metric, value in zip(PRINTED, expected, strict=True):
            if value is not None:
                found = METRICS[metric].measure(metric, case)
                assert isinstance(found, Metric)
                assert round(found.value, 3) == value, (method, metric)


def test_the_interval_of_a_published_matrix_is_the_published_one(data: Path) -> None:
    scores, pairs = shipped(data, "corridor")
    for method, low, high in (("HybridNet", 0.80, 0.96), ("NetVLAD", 0.53, 0.78)):
        case = judge(recognition(scores[method], pairs=pairs))
        metric = METRICS["recall_at_1"].measure("recall_at_1", case)
        assert isinstance(metric, Metric)
        assert (metric.low, metric.high) == pytest.approx((low, high), abs=0.02)
