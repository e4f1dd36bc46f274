"""Cyclic alignment with uncertainty: both engines against brute force and its properties."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.strings import (
    SCORES,
    SILENT,
    TAU,
    brute_ratio,
    plain_score,
    random_strings,
    strings,
    symbols,
    turned,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fpnav.matching import compiled, cyclic, rotations
from fpnav.matching.bounds import bags
from fpnav.matching.strings import Strings, concatenated

SEEDS = st.integers(0, 2**32 - 1)
ENGINES = pytest.mark.parametrize("engine", [rotations, compiled], ids=["numpy", "numba"])
PAPER = "cIfvncvfnvncvnnvcvBnvBccE"


def everything(x: Strings, i: int, y: Strings, engine: object = rotations) -> np.ndarray:
    rows = np.arange(len(y))
    found: np.ndarray = engine.rotation_ratios(x, i, y, rows, SCORES)  # type: ignore[attr-defined]
    return found


def ratio(x: Strings, y: Strings) -> float:
    return float(everything(x, 0, y).max())


@settings(max_examples=15)
@given(SEEDS)
def test_numpy_equals_brute_force(seed: int) -> None:
    x, y = random_strings(seed, 1, 10), random_strings(seed + 1, 3, 12)
    found = everything(x, 0, y).max(axis=1)
    assert found == pytest.approx([brute_ratio(x, 0, y, j) for j in range(3)], abs=1e-4)


@settings(max_examples=60)
@given(SEEDS, st.booleans(), st.booleans())
def test_the_engines_agree_to_the_last_bit(seed: int, partial: bool, fixed: bool) -> None:
    x = random_strings(seed, 2, 24, partial=partial)
    y = random_strings(seed + 1, 8, 30, partial=partial)
    if fixed:
        x, y = (Strings(*vars_of(one)[:-1], np.ones(len(one), bool)) for one in (x, y))
    for i in range(2):
        first, second = everything(x, i, y), everything(x, i, y, compiled)
        assert np.array_equal(first, second)
        rows, cuts = np.arange(8), first.argmax(axis=1)
        assert np.array_equal(
            rotations.partners(x, i, y, rows, cuts, SCORES),
            compiled.partners(x, i, y, rows, cuts, SCORES),
        )


def vars_of(one: Strings) -> tuple[np.ndarray, ...]:
    return one.codes, one.weights, one.angles_rad, one.offsets, one.arcs, one.fixed


@settings(max_examples=40)
@given(SEEDS, st.integers(0, 40), st.floats(0.0, TAU))
def test_a_string_matches_itself_however_turned(seed: int, shift: int, turn: float) -> None:
    x = random_strings(seed, 1, 20, shortest=1)
    assert ratio(x, x) == 1.0
    assert ratio(x, turned(x, turn, shift)) == 1.0
    assert ratio(turned(x, turn, shift), x) == 1.0


@settings(max_examples=40)
@given(SEEDS)
def test_matching_is_symmetric_and_within_its_limits(seed: int) -> None:
    x, y = random_strings(seed, 1, 20), random_strings(seed + 1, 1, 25)
    assert ratio(x, y) == ratio(y, x)
    assert -1.0 <= ratio(x, y) <= 1.0


@settings(max_examples=30)
@given(SEEDS, st.integers(0, 19))
def test_deleting_a_matched_feature_never_helps(seed: int, at: int) -> None:
    x = random_strings(seed, 1, 20, shortest=3)
    at %= len(x.codes)
    keep = np.arange(len(x.codes)) != at
    fewer = Strings(
        x.codes[keep], x.weights[keep], x.angles_rad[keep],
        np.array([0, keep.sum()]), x.arcs, x.fixed,
    )  # fmt: skip
    total = 0.5 * (x.totals[0] + fewer.totals[0])
    one_gap = (fewer.totals[0] - 0.5 * x.weights[at]) / total
    assert one_gap - 1e-4 <= ratio(x, fewer) < 1.0


def test_an_uncertain_feature_is_cheap_to_miss_and_a_certain_one_dear() -> None:
    sure = strings(["vcv", "vv"], [[1.0, 1.0, 1.0], [1.0, 1.0]])
    unsure = strings(["vcv", "vv"], [[1.0, 0.3, 1.0], [1.0, 1.0]])
    assert ratio(sure.take([0]), sure.take([1])) == pytest.approx((2.0 - 0.5) / 2.5)
    assert ratio(unsure.take([0]), unsure.take([1])) == pytest.approx((2.0 - 0.15) / 2.15, abs=1e-4)


@pytest.mark.parametrize(
    ("first", "second", "sigma"),
    [
        ("v", "v", 1.0), ("A", "P", 0.5), ("A", "C", 0.0), ("A", "D", -1.0), ("v", "f", 0.4),
        ("c", "f", 0.4), ("v", "c", -0.5), ("v", "n", -1.0), ("A", "v", -1.0),
    ],
)  # fmt: skip
def test_one_symbol_earns_what_the_table_says_or_two_gaps(
    first: str, second: str, sigma: float
) -> None:
    x, y = strings([first]), strings([second])
    weights = x.totals[0] + y.totals[0]
    expected = max(0.5 * weights * sigma, -0.5 * weights) / (0.5 * weights)
    assert ratio(x, y) == pytest.approx(expected, abs=1e-4)


@ENGINES
def test_nothing_matches_nothing_by_nought(engine: object) -> None:
    empty, some = strings([""]), strings([PAPER])
    assert everything(empty, 0, empty, engine).max() == 0.0
    assert everything(empty, 0, some, engine).max() == pytest.approx(-1.0, abs=1e-4)
    assert everything(some, 0, empty, engine).max() == pytest.approx(-1.0, abs=1e-4)


def test_the_papers_string_aligns_with_its_rotations_and_less_with_less() -> None:
    x = strings([PAPER])
    for shift in range(len(PAPER)):
        assert ratio(x, strings([PAPER[shift:] + PAPER[:shift]])) == 1.0
    assert 0.8 < ratio(x, strings([PAPER.replace("I", "J")])) < 1.0
    assert ratio(x, strings([PAPER[::-1]])) < 0.9


def test_a_linear_alignment_is_what_biopython_finds() -> None:
    align = pytest.importorskip("Bio.Align")
    substitution = pytest.importorskip("Bio.Align.substitution_matrices")
    from fpnav.systems.fingerprint.symbols import ALPHABET

    table = substitution.Array(ALPHABET, dims=2)
    for a, letter in enumerate(ALPHABET):
        for b, other in enumerate(ALPHABET):
            table[letter, other] = SCORES.sigma[a, b]
    aligner = align.PairwiseAligner(mode="global", substitution_matrix=table, gap_score=-0.5)
    rng = np.random.default_rng(5)
    for _ in range(40):
        first, second = ("".join(rng.choice(list(ALPHABET), n)) for n in rng.integers(1, 20, 2))
        codes = [[(ALPHABET.index(letter), 1.0) for letter in text] for text in (first, second)]
        assert plain_score(*codes, SCORES) == pytest.approx(aligner.score(first, second), abs=1e-6)


@settings(max_examples=25)
@given(SEEDS, st.integers(1, 6))
def test_pruning_changes_nothing_among_the_best(seed: int, keep: int) -> None:
    x, y = random_strings(seed, 3, 20), random_strings(seed + 1, 40, 24)
    y = concatenated([y, y.take([0, 0, 1])])  # ties
    rows, both = np.arange(len(y)), (bags(x, SCORES), bags(y, SCORES))
    for i in range(3):
        full = cyclic.best_ratios(x, i, y, rows, SCORES)
        pruned = cyclic.best_ratios(x, i, y, rows, SCORES, keep, both)
        best = np.argsort(-full, kind="stable")[:keep]
        assert np.array_equal(np.argsort(-pruned, kind="stable")[:keep], best)
        assert np.array_equal(pruned[best], full[best])
        done = np.isfinite(pruned)
        assert np.array_equal(pruned[done], full[done])


@settings(max_examples=25)
@given(SEEDS)
def test_a_batch_answers_as_its_members(seed: int) -> None:
    x, y = random_strings(seed, 1, 20, partial=True), random_strings(seed + 1, 6, 24, partial=True)
    together = cyclic.align(x, 0, y, np.arange(6), SCORES, SILENT)
    for j in range(6):
        alone = cyclic.align(x, 0, y, np.array([j]), SCORES, SILENT)
        for name in ("ratios", "cuts", "psi_rad", "concentration", "spread_rad"):
            one, all_of_them = getattr(alone, name), getattr(together, name)
            assert np.array_equal(one[0], all_of_them[j], equal_nan=True)


@settings(max_examples=40)
@given(SEEDS, st.floats(-math.pi, math.pi), st.integers(0, 30))
def test_the_turn_is_found_to_a_millionth(seed: int, turn: float, shift: int) -> None:
    x = random_strings(seed, 1, 20, shortest=6)
    assume(len(set(x.codes)) >= 5)
    found = cyclic.align(x, 0, turned(x, turn, shift), np.zeros(1, np.int64), SCORES, SILENT)
    off = (found.psi_rad[0] - turn + math.pi) % TAU - math.pi
    assert off == pytest.approx(0.0, abs=1e-6)
    assert found.ratios[0] == 1.0
    assert found.concentration[0] == pytest.approx(1.0, abs=1e-9)
    assert found.spread_rad[0] == pytest.approx(0.0, abs=1e-4)


def test_equal_rotations_are_told_apart_by_their_residuals() -> None:
    angles = [[0.0, 1.0, 3.0]]
    x = strings(["vvv"], angles=angles)
    y = strings(["vvv"], angles=[[1.0, 3.0, TAU - 1e-9]])  # x started at its second symbol
    found = cyclic.align(x, 0, y, np.zeros(1, np.int64), SCORES, SILENT)
    assert found.cuts[0] == 1
    assert list(found.partner[0]) == [1, 2, 0]
    assert found.psi_rad[0] == pytest.approx(0.0, abs=1e-6)


def test_the_residuals_spread_is_that_of_the_angles() -> None:
    x = strings(["vcAv"], angles=[[0.0, 1.5, 3.0, 4.5]])
    y = strings(["vcAv"], angles=[[0.1, 1.4, 3.1, 4.4]])
    found = cyclic.align(x, 0, y, np.zeros(1, np.int64), SCORES, SILENT)
    assert found.psi_rad[0] == pytest.approx(0.0, abs=1e-9)
    assert found.concentration[0] == pytest.approx(math.cos(0.1))
    assert found.spread_rad[0] == pytest.approx(math.sqrt(-2.0 * math.log(math.cos(0.1))))


@pytest.mark.parametrize(("first", "second"), [("nnn", "nnn"), ("", ""), ("", "v"), ("v", "A")])
def test_without_a_matched_feature_there_is_no_turn(first: str, second: str) -> None:
    found = cyclic.align(
        strings([first]), 0, strings([second]), np.zeros(1, np.int64), SCORES, SILENT
    )
    assert math.isnan(found.psi_rad[0])
    assert found.concentration[0] == 0.0
    assert found.spread_rad[0] == math.inf


def test_only_gains_are_correspondences() -> None:
    x, y = strings(["vAc"]), strings(["vEc"])
    found = cyclic.align(x, 0, y, np.zeros(1, np.int64), SCORES, SILENT)
    assert list(found.partner[0]) == [0, -1, 2]


def test_open_strings_are_aligned_as_they_stand() -> None:
    x, y = strings(["vcA"], fixed=True), strings(["cAv"], fixed=True)
    assert ratio(x, y) == pytest.approx((2.0 - 1.0) / 3.0, abs=1e-4)
    assert ratio(x, strings(["cAv"])) == 1.0  # a closed one is turned
    found = cyclic.align(x, 0, y, np.zeros(1, np.int64), SCORES, SILENT)
    assert found.cuts[0] == 0


def test_the_engine_is_a_matter_of_time_only(monkeypatch: pytest.MonkeyPatch) -> None:
    x, y = random_strings(1, 1, 20), random_strings(2, 5, 20)
    rows = np.arange(5)
    monkeypatch.setattr(cyclic, "_done", 0)
    slow = cyclic.best_ratios(x, 0, y, rows, SCORES)
    monkeypatch.setattr(cyclic, "_done", cyclic.WORTH_COMPILING)
    assert np.array_equal(cyclic.best_ratios(x, 0, y, rows, SCORES), slow)


def test_strings_too_long_or_too_heavy_for_the_kernels_are_aligned_by_numpy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cyclic, "_done", cyclic.WORTH_COMPILING)
    long, some = random_strings(7, 1, 300, shortest=300), random_strings(8, 1, 40, shortest=40)
    heavy = Strings(*(vars_of(some)[0], some.weights * 8.0, *vars_of(some)[2:]))
    for x in (long, heavy):
        assert not compiled.fits(x, 0, x, SCORES)
        assert cyclic.best_ratios(x, 0, x, np.zeros(1, np.int64), SCORES)[0] == 1.0
    assert compiled.fits(some, 0, some, SCORES)


def test_plain_alignment_of_the_helper_is_the_recurrence() -> None:
    x = strings(["vn"], [[1.0, 0.5]])
    assert symbols(x, 0) == [(16, 1.0), (19, pytest.approx(0.15, abs=1e-4))]
