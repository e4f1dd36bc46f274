"""Names, plain language and gates."""

from __future__ import annotations

import math

import pytest
from helpers.results import header, office_run, recognition, revisit_run
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import GateError
from fpnav.evaluation.table import METRICS
from fpnav.report import words
from fpnav.report.entry import Entry, distinct, entries_of, slug
from fpnav.report.figures.style import shown
from fpnav.report.gates import check_gates
from fpnav.values import Metric


def entry(**metrics: float) -> Entry:
    made = {name: Metric(name, value, 1, 2) for name, value in metrics.items()}
    return Entry("run", "run", header(), made, {"ece": "no probabilities are stated"})


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["a", "b"], ["a", "b"]),
        (["a", "a", "a"], ["a", "a-2", "a-3"]),
        (["a", "a", "a-2"], ["a", "a-3", "a-2"]),
    ],
)
def test_repeated_names_are_told_apart(names: list[str], expected: list[str]) -> None:
    assert distinct(names) == expected


@given(st.lists(st.sampled_from(["a", "a-2", "a-3", "b"]), max_size=12))
def test_no_name_is_given_twice(names: list[str]) -> None:
    found = distinct(names)
    assert len(set(found)) == len(names)


@given(st.text(max_size=200))
def test_a_slug_is_a_plain_file_name(name: str) -> None:
    made = slug(name)
    assert 0 < len(made) <= 80
    assert not made.startswith((".", "-"))
    assert all(c.isascii() and (c.isalnum() or c in "._-") for c in made)


@given(st.text(max_size=60))
def test_any_name_can_stand_in_a_figure(name: str) -> None:
    text = shown(name)
    assert len(text) <= 41
    assert not text.startswith("_")
    assert "\n" not in text


@pytest.mark.parametrize(
    ("metric", "number", "interval"),
    [
        (Metric("recall_at_1", 0.5, 5, 10, "", 0.25, 0.75), "50.0\u202f%", "25 to 75\u202f%"),
        (Metric("average_precision", 0.8372, 5, 10, "", 0.7, 0.9), "0.837", "0.70 to 0.90"),
        (Metric("position_error_median_m", 0.1849, 5, 5, "m"), "0.18\u202fm", ""),
        (Metric("heading_error_median_deg", 12.34, 5, 5, "deg", 10, 14), "12.3\u202f\u00b0",
         "10.0 to 14.0"),
        (Metric("places", 20.0, 20, 20), "20", ""),
    ],
)  # fmt: skip
def test_figures_read_as_a_person_writes_them(metric: Metric, number: str, interval: str) -> None:
    assert words.number(metric) == number
    assert words.interval(metric) == interval


def test_a_count_of_none_is_no_share() -> None:
    assert words.number(Metric("nodes_at_closed_doors", 0.0, 0, 185)) == "0"
    assert not words.is_rate(Metric("nodes_at_closed_doors", 0.0, 0, 185))


def test_places_are_not_counted_of_themselves() -> None:
    assert words.counts(Metric("places", 20.0, 20, 20)) == ""
    assert words.counts(Metric("recall_at_1", 0.5, 5, 10)) == "5 of 10"


def test_the_summary_says_what_was_done_and_the_verdict_what_came_out() -> None:
    run, past = entries_of([("office", office_run("match")), ("laps", revisit_run())])
    assert words.summary(run) == (
        "233 queries located on a map of 20 places: each query on its own, no memory of the run."
    )
    assert "of the same run, at least 15 m of path earlier" in words.summary(past)
    assert "stand in a mapped place" in words.verdict(run)
    assert "decisions were made" in words.verdict(past)
    assert words.same_place(past).startswith("Right is a reference within 1.5 m, at most 45")


def test_few_positives_are_warned_of() -> None:
    (few,) = entries_of([("few", recognition([[0.9, 0.1]], pairs={0: [0]}))])
    assert words.warnings(few) == [
        "Only 1 queries have a match: every figure hangs on a few of them."
    ]


def test_looking_ahead_is_labelled_whatever_the_method_is_called() -> None:
    facts = header("recognize", protocol={"causal": False}, synthetic=False)
    (found,) = entries_of([("run", recognition([[0.9]], pairs={0: [0]}, header=facts))])
    assert [word for word, _ in words.labels(found)] == ["recorded", "not causal"]


def test_every_metric_has_a_title_and_a_meaning_of_its_own() -> None:
    titles = [metric.title for metric in METRICS.values()]
    assert len(set(titles)) == len(titles)
    assert all(metric.meaning and metric.counts for metric in METRICS.values())
    assert words.title_of("unknown_to_the_table") == "unknown_to_the_table"


def test_gates_that_are_met_say_nothing() -> None:
    check_gates([entry(recall_at_1=0.8, position_error_median_m=0.2)],
                [("recall_at_1", 0.8), ("position_error_median_m", 0.3)])  # fmt: skip


@pytest.mark.parametrize(
    ("name", "bound", "message"),
    [
        ("recall_at_1", 0.9, r"run: recall_at_1 is 0.8 \(1 of 2\), expected at least 0.9"),
        ("position_error_median_m", 0.1, r"is 0.2 \(1 of 2\), expected at most 0.1"),
        ("ece", 0.1, r"run: ece is absent: no probabilities are stated"),
        ("places", 1, r"run: places is absent: not measured"),
    ],
)
def test_a_gate_missed_names_result_figure_and_bound(name: str, bound: float, message: str) -> None:
    with pytest.raises(GateError, match=message):
        check_gates([entry(recall_at_1=0.8, position_error_median_m=0.2)], [(name, bound)])


def test_all_gates_missed_stand_in_one_line() -> None:
    with pytest.raises(GateError) as caught:
        check_gates([entry(recall_at_1=0.1)], [("recall_at_1", 0.9), ("ece", 0.1)])
    assert str(caught.value).count(";") == 1
    assert "\n" not in str(caught.value)
    assert not math.isnan(caught.value.exit_code)
