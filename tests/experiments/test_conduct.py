"""A study is run: every experiment in every world, pooled, drawn together."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import pytest

from fpnav.errors import UsageError
from fpnav.execution.spread import Here
from fpnav.experiments.registry import STUDIES, study_of
from fpnav.experiments.study import Outcome, Study, conduct
from fpnav.experiments.workshop import Workshop
from fpnav.report.study import Claim, Finding, Heading, Illustration, study_context
from fpnav.values import Metric

Item = TypeVar("Item")
Answer = TypeVar("Answer")

HEADING = Heading("toy", "toy", "Toy", "", "", {})


def counting(shop: Workshop, seed: int) -> Outcome:
    return Outcome([Metric("share", seed / 4, seed, 4)], (), {"preset": "paper"}, seed)


def together(materials: Sequence[Any]) -> Sequence[Illustration]:
    raise AssertionError if 4 in materials else LookupError(sum(materials))


def study(**changes: Any) -> Study:
    return Study(HEADING, (), {"T1": counting, "T2": counting}, **changes)


def shop(tmp_path: Path) -> Workshop:
    return Workshop(tmp_path, Here())


def test_every_experiment_runs_in_every_world_and_is_pooled(tmp_path: Path) -> None:
    found = conduct(study(), shop(tmp_path), [1, 3])
    assert [one.name for one in found] == [
        "T1", "T1/seed-1", "T1/seed-3", "T2", "T2/seed-1", "T2/seed-3",
    ]  # fmt: skip
    pooled = found[0].metrics["share"]
    assert (pooled.value, pooled.n, pooled.of) == (0.5, 4, 8)
    assert (pooled.low, pooled.high) == pytest.approx((0.25, 0.75), abs=0.02)


def test_a_long_experiment_runs_in_the_first_worlds_only(tmp_path: Path) -> None:
    done: list[int] = []
    found = conduct(study(most={"T1": 1}), shop(tmp_path), [2, 3, 4], ["T1"], done.append)
    assert [one.name for one in found] == ["T1", "T1/seed-2"]
    assert found[0].facts["seeds"] == [2]
    assert sum(done) == 3


def test_pictures_over_all_worlds_are_made_of_their_materials(tmp_path: Path) -> None:
    with pytest.raises(LookupError, match="6"):
        conduct(study(together={"T1": together}), shop(tmp_path), [1, 2, 3])


def test_long_experiments_are_begun_first_and_told_in_order(tmp_path: Path) -> None:
    begun: list[tuple[str, int]] = []

    def noted(name: str, shop: Workshop, seed: int) -> Outcome:
        begun.append((name, seed))
        return counting(shop, seed)

    experiments = {name: partial(noted, name) for name in ("T1", "T2", "T3")}
    long_last = Study(HEADING, (), experiments, most={"T3": 1}, long=("T3", "T9"))
    found = conduct(long_last, shop(tmp_path), [4, 5])
    assert begun == [("T3", 4), ("T1", 4), ("T1", 5), ("T2", 4), ("T2", 5)]
    assert [one.experiment for one in found if one.seed is None] == ["T1", "T2", "T3"]


class Sent:
    """A spread that sends everything through pickle, as processes do."""

    def ordered(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[Answer]:
        for item in items:
            yield pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(function))(item)))


def drawn(shop: Workshop, seed: int) -> Outcome:
    assert isinstance(shop.spread, Here)  # worlds are side by side, each on one process
    return Outcome([], [Illustration("p", "", "", partial(divmod, seed, 2))])


def test_worlds_side_by_side_give_what_one_after_the_other_gives(tmp_path: Path) -> None:
    one = conduct(study(), Workshop(tmp_path, Here()), [1, 3])
    both = conduct(study(), Workshop(tmp_path, Sent()), [1, 3])
    assert repr([(f.name, f.metrics) for f in both]) == repr([(f.name, f.metrics) for f in one])
    pictured = Study(HEADING, (), {"T1": drawn})
    found = conduct(pictured, Workshop(tmp_path, Sent()), [4, 5])
    assert [f.pictures[0].draw() for f in found[1:]] == [(2, 0), (2, 1)]


@pytest.mark.parametrize("name", STUDIES)
def test_experiments_of_every_paper_can_be_sent_to_a_process(name: str) -> None:
    for experiment in study_of(name).experiments.values():
        assert pickle.loads(pickle.dumps(experiment)) is experiment


@pytest.mark.parametrize("name", STUDIES)
def test_pictures_of_every_paper_can_be_sent_back(name: str, root: Path) -> None:
    for source in (root / "fpnav" / "experiments" / name).glob("*.py"):
        assert "lambda: drawing" not in source.read_text(encoding="utf-8"), source


def test_an_experiment_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="toy has no experiment 'T9'; it has T1, T2"):
        conduct(study(), shop(tmp_path), [1], ["T9"])


@pytest.mark.parametrize(
    ("bounds", "low", "met"),
    [
        ({}, 0.1, None),
        ({"above": 0.0}, 0.1, True),
        ({"above": 0.0}, -0.1, False),
        ({"above": 0.0}, math.nan, True),
        ({"least": 0.5, "above": 0.0}, 0.1, False),
        ({"most": 0.4}, 0.1, True),
    ],
)
def test_a_claim_may_ask_for_the_whole_interval(
    bounds: dict[str, float], low: float, met: bool | None
) -> None:
    claim = Claim("T1", "lead", "leads", "", **bounds)
    assert claim.met(Metric("lead", 0.3, 1, 1, low=low, high=0.6)) is met


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_a_studys_claims_and_titles_are_of_its_experiments(name: str) -> None:
    made = study_of(name)
    assert {claim.experiment for claim in made.claims} <= set(made.experiments)
    assert set(made.heading.titles) == set(made.experiments)
    assert {*made.together, *made.most} <= set(made.experiments)


def test_the_mean_of_shares_is_a_share_above_the_counts_of_all_worlds() -> None:
    def found(seed: int | None, value: float, n: int, of: int) -> Finding:
        return Finding("T1", seed, {"share": Metric("share", value, n, of)})

    findings = [found(None, 0.75, 11, 12), found(1, 0.5, 1, 2), found(2, 1.0, 10, 10)]
    claim = Claim("T1", "share", "", "", least=0.7)
    context = study_context(HEADING, [claim], findings, {f.name: [] for f in findings})
    row = context["rows"][0]
    assert row["value"] == "75.0\u202f%"
    assert row["counts"] == "11 of 12 in all"
    assert row["goal"] == "\u2265 70.0\u202f%"
    assert row["range"] == "50.0\u202f% to 100.0\u202f%"
    section = context["experiments"][0]
    assert section["columns"] == ["mean", "world 1", "world 2"]
    assert [cell["value"] for cell in section["table"][0]["cells"]] == [
        "75.0\u202f%", "50.0\u202f%", "100.0\u202f%",
    ]  # fmt: skip
