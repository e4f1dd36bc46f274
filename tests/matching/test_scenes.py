"""Scene matching on scenes small enough to count."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fpnav.matching.scenes import Scenes, Soft, match_scores, scenes_of, soft_scores, unique_best
from fpnav.sensing.cues import CUE
from fpnav.sensing.scene import compatible

Row = tuple[float, ...]


def cue(
    column: float,
    row: float = 2,
    direction: int = 1,
    metres: float = 3.0,
    facing: int = 0,
    strength: float = 1.0,
) -> Row:
    """A cue that fills one cell of the grid."""
    top = 96 * row
    return (facing, direction, 96 * column + 48, top, top + 95, strength, metres)


def scene(*rows: Row) -> NDArray[np.void]:
    return np.array(list(rows), CUE)


def batch(*scenes: NDArray[np.void], facings: int = 1) -> Scenes:
    return scenes_of(list(scenes), [facings] * len(scenes))


def score(present: Sequence[Row], stored: Sequence[Row], method: int, facings: int = 1) -> float:
    one, other = batch(scene(*present), facings=facings), batch(scene(*stored))
    return float(match_scores(one, other, method)[0, 0])


@pytest.mark.parametrize("method", [1, 2, 3, 4])
def test_three_of_seven_are_3_7(method: int) -> None:
    stored = [cue(c, 1) for c in (0, 1, 2, 3, 4)] + [cue(0, 3), cue(2, 3)]
    present = [cue(0, 1), cue(2, 1), cue(4, 1)]
    if method == 1:
        stored = [cue(0, 1, metres=3.0), cue(2, 1), cue(4, 1)] + [cue(2, 1, -1)] * 4
    assert score(present, stored, method) == pytest.approx(3 / 7, abs=1e-4)


@pytest.mark.parametrize("method", [1, 2, 3, 4])
def test_a_scene_matches_itself_and_nothing_matches_nothing(method: int) -> None:
    rows = [cue(0), cue(1, 3, -1, 5.0), cue(4, 0, 1, math.nan)]
    assert score(rows, rows, method) == 1.0
    assert score([], rows, method) == 0.0
    assert score(rows, [], method) == 0.0


@pytest.mark.parametrize(
    ("other", "scores"),
    [
        (cue(2), (1, 1, 1, 1)),
        (cue(2, direction=-1), (0, 0, 0, 1)),
        (cue(2, metres=7.0), (0, 0, 1, 1)),
        (cue(3), (1, 0, 0, 0)),
        (cue(4), (0, 0, 0, 0)),
        (cue(2, row=0), (1, 0, 0, 0)),
    ],
    ids=["same", "direction", "distance", "next column", "two columns", "row"],
)
def test_what_each_algorithm_asks_for(other: Row, scores: tuple[int, ...]) -> None:
    assert tuple(score([other], [cue(2)], method) for method in (1, 2, 3, 4)) == scores


def test_a_feature_is_used_once_and_a_cell_as_often_as_it_fits() -> None:
    stored = [cue(2), cue(2)]
    assert score([cue(2)], stored, 1) == 0.5
    assert score([cue(2)], stored, 2) == 1.0


def test_the_nearest_feature_is_taken_first() -> None:
    left, right = (0, 1, 200.0, 100, 200, 1.0, 3.0), (0, 1, 260.0, 100, 200, 1.0, 3.0)
    assert score([left, right], [left, right], 1) == 1.0


def test_a_cell_is_of_its_strongest_cue() -> None:
    weak, strong = cue(2, direction=1), cue(2, direction=-1, metres=9.0, strength=2.0)
    for present in ([cue(2, direction=-1, metres=10.0)], [weak, strong], [strong, weak]):
        assert score(present, [weak, strong], 2) == 1.0
    assert score([weak], [weak, strong], 2) == 0.0
    assert score([weak], [weak, strong], 1) == 0.5


def test_a_tall_cue_fills_several_cells() -> None:
    tall = (0, 1, 240.0, 0.0, 479.0, 1.0, 3.0)
    assert score([cue(2, 1)], [tall], 2) == pytest.approx(1 / 5)
    assert score([tall], [cue(2, 1)], 2) == 1.0


def test_only_directions_that_were_looked_in_count() -> None:
    stored = [cue(2), cue(2, facing=2), cue(1, facing=2)]
    assert score([cue(2)], stored, 2, facings=0b001) == 1.0
    assert score([cue(2), cue(2, facing=2)], stored, 2, facings=0b101) == pytest.approx(2 / 3)
    assert score([cue(2)], stored, 1, facings=0b001) == 1.0
    assert score([cue(2, facing=2)], [cue(2)], 4, facings=0b100) == 0.0


def test_a_tie_is_no_match() -> None:
    scores = np.array([[0.2, 0.7, 0.7], [0.2, 0.7, 0.6], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0]])
    assert unique_best(scores).tolist() == [-1, 1, -1, 1]
    assert unique_best(np.zeros((2, 0))).tolist() == [-1, -1]


def slow_cells(present: NDArray[np.void], stored: NDArray[np.void]) -> float:
    """The second algorithm, cell by cell as the paper words it."""

    def table(cues: NDArray[np.void]) -> dict[tuple[int, int], np.void]:
        cells: dict[tuple[int, int], np.void] = {}
        for one in cues:
            column = int(one["x_px"] // 96)
            for row in range(5):
                covered = min(one["bottom_px"] + 1, 96 * row + 96) - max(one["top_px"], 96 * row)
                held = cells.get((row, column))
                if covered >= 48 and (held is None or one["strength"] > held["strength"]):
                    cells[row, column] = one
        return cells

    shown, kept = table(present), table(stored)
    matched = sum(
        cell in shown
        and one["direction"] == shown[cell]["direction"]
        and bool(compatible(one["distance_m"], shown[cell]["distance_m"], 0.25))
        for cell, one in kept.items()
    )
    return matched / len(kept) if kept else 0.0


rows = st.lists(
    st.tuples(
        st.just(0),
        st.sampled_from([1, -1]),
        st.integers(0, 479),
        st.integers(0, 300),
        st.integers(96, 179),
        st.sampled_from([0.5, 1.0, 2.0]),
        st.sampled_from([0.7, 1.9, 2.2, 3.5, 5.0, 7.9, 12.0, math.nan]),
    ).map(lambda r: (*r[:4], r[3] + r[4], *r[5:])),
    max_size=8,
)


@given(rows, rows)
def test_the_second_algorithm_is_what_the_paper_words(
    present: list[Row], stored: list[Row]
) -> None:
    found = match_scores(batch(scene(*present)), batch(scene(*stored)), 2)[0, 0]
    assert found == pytest.approx(slow_cells(scene(*present), scene(*stored)))


@given(rows, rows)
def test_scores_lie_between_0_and_1_and_coarser_cells_match_more(
    present: list[Row], stored: list[Row]
) -> None:
    one, other = batch(scene(*present)), batch(scene(*stored))
    scores = [float(match_scores(one, other, method)[0, 0]) for method in (1, 2, 3, 4)]
    scores.append(float(soft_scores(one, other, Soft())[0, 0]))
    assert all(0.0 <= value <= 1.0 for value in scores)
    assert scores[1] <= scores[2] <= scores[3]


def test_a_batch_is_scored_as_its_members() -> None:
    scenes = [scene(cue(0), cue(1, 3)), scene(), scene(cue(0, 2, -1)), scene(cue(4), cue(1, 3))]
    whole = match_scores(batch(*scenes), batch(*scenes), 2)
    assert whole.shape == (4, 4)
    for q, one in enumerate(scenes):
        for r, other in enumerate(scenes):
            assert whole[q, r] == match_scores(batch(one), batch(other), 2)[0, 0]


def soft(present: Sequence[Row], stored: Sequence[Row], rule: Soft | None = None) -> float:
    one, other = batch(scene(*present)), batch(scene(*stored))
    return float(soft_scores(one, other, rule or Soft())[0, 0])


def shifted(row: Row, pixels: float) -> Row:
    return (*row[:2], row[2] + pixels, *row[3:])


def test_softly_a_scene_matches_itself() -> None:
    assert soft([cue(0), cue(2, 1, -1)], [cue(0), cue(2, 1, -1)]) == pytest.approx(1.0)


def test_softly_a_cue_does_not_fall_over_the_border_of_a_cell() -> None:
    near, far = [shifted(cue(1), 47)], [shifted(cue(1), 49)]
    assert score(near, far, 2) == 0.0
    assert soft(near, far) > 0.9


def test_softly_a_common_shift_costs_little_and_is_found() -> None:
    stored = [cue(1), cue(2, 1, -1), cue(3)]
    turned = [shifted(row, 36) for row in stored]
    apart = [shifted(row, 36 * (-1) ** i) for i, row in enumerate(stored)]
    assert soft(turned, stored) == pytest.approx(1.0 - 0.15 * 36 / 47, abs=0.02)
    assert soft(apart, stored) < soft(turned, stored)


def test_softly_cues_the_stored_scene_lacks_cost_something() -> None:
    stored = [cue(1), cue(3)]
    assert soft([*stored, cue(2), cue(0)], stored) < soft(stored, stored)
    assert soft(stored, [*stored, cue(2), cue(0)]) < soft([*stored, cue(2), cue(0)], stored)


def test_softly_a_strong_link_counts_more_than_a_weak_one() -> None:
    rows, weights = scene(cue(1), cue(3)), np.array([0.9, 0.1])
    stored = scenes_of([rows], [1], [weights])
    strong = soft_scores(batch(scene(cue(1))), stored, Soft())[0, 0]
    weak = soft_scores(batch(scene(cue(3))), stored, Soft())[0, 0]
    assert strong > weak > 0.0


def test_softly_distances_a_factor_of_two_apart_do_not_match() -> None:
    assert soft([cue(1, metres=2.5)], [cue(1, metres=5.1)]) == 0.0
    assert soft([cue(1, metres=2.5)], [cue(1, metres=3.0)]) > 0.6
    assert soft([cue(1, metres=math.nan)], [cue(1)]) == pytest.approx(0.7)
