"""What counts as right: radius and heading, candidates, owners, borders, near misses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.results import header, on_map, recognition, rows
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import TruthError
from fpnav.evaluation.accepted import border_places, contains, nearest_rows, rows_by_pose
from fpnav.evaluation.case import judge
from fpnav.store.tables import Accepted, Ragged

NO_LABELS = (np.zeros(0, "S64"), np.zeros(0, "S64"))


def accepted(ragged: Ragged) -> list[list[int]]:
    return [ragged[row].tolist() for row in range(len(ragged))]


def test_rows_within_radius_and_heading_of_a_query_are_accepted() -> None:
    references = np.array([[0, 0, 0], [1, 0, 0], [1, 0, math.pi], [5, 0, 0], [np.nan] * 3])
    queries = np.array([[0.2, 0, math.radians(30)]])
    every = np.array([5])
    assert accepted(rows_by_pose(queries, references, every, 1.5, math.radians(45))) == [[0, 1]]
    assert accepted(rows_by_pose(queries, references, every, 1.5, None)) == [[0, 1, 2]]
    assert accepted(rows_by_pose(queries, references, np.array([1]), 1.5, None)) == [[0]]


def test_headings_are_compared_around_the_circle() -> None:
    references = np.array([[0, 0, math.radians(179)]])
    queries = np.array([[0, 0, math.radians(-179)]])
    assert accepted(rows_by_pose(queries, references, np.array([1]), 1.0, math.radians(3))) == [[0]]


@given(st.integers(1, 30), st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_blocks_and_plain_loops_agree(queries: int, references: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    asked, known = random.uniform(0, 4, (queries, 3)), random.uniform(0, 4, (references, 3))
    candidates = random.integers(0, references + 1, queries)
    found = accepted(rows_by_pose(asked, known, candidates, 1.0, 0.8))
    for query in range(queries):
        expected = [
            row
            for row in range(int(candidates[query]))
            if math.dist(asked[query, :2], known[row, :2]) <= 1.0
            and abs(math.remainder(asked[query, 2] - known[row, 2], math.tau)) <= 0.8
        ]
        assert found[query] == expected


def test_the_nearest_row_must_be_near_and_carry_the_same_room_name() -> None:
    poses = np.array([[0, 0, 0], [0.4, 0, 0], [np.nan] * 3])
    queries = np.array([[0.3, 0, 0], [0.3, 0, 0], [3, 0, 0], [np.nan] * 3])
    asked = np.array([b"", b"hall", b"", b""], "S64")
    known = np.array([b"hall", b"office", b"hall"], "S64")
    assert nearest_rows(queries, poses, (asked, known), 1.0).tolist() == [1, 0, -1, -1]


def test_no_reference_means_nearest_to_nothing() -> None:
    assert nearest_rows(np.zeros((2, 3)), np.zeros((0, 3)), NO_LABELS, 1.0).tolist() == [-1, -1]


def test_padding_is_never_right() -> None:
    ragged = Ragged.of([np.array([0]), np.array([], np.int64)], np.dtype(np.int64))
    assert contains(ragged, np.array([[-1, 0], [-1, 0]])).tolist() == [[False, True], [False] * 2]


def test_a_neighbour_is_tolerated_only_near_its_border() -> None:
    poses = np.array([[x, 0, 0] for x in (0.0, 0.4, 0.8, 1.2)])
    owner = np.array([0, 0, 1, 2])
    queries = np.array([[0.05, 0, 0], [0.15, 0, 0], [0.7, 0.3, 0], [np.nan] * 3])
    found = border_places(queries, np.array([0, 0, 2, -1]), poses, owner, {0: {1}, 1: {0}}, 0.5)
    # places 0 and 1 meet at 0.6; 1 and 2 meet at 1.0 but are no neighbours
    assert accepted(found) == [[], [1], [0], []]


def test_a_border_lies_half_way_between_two_passings() -> None:
    """Two tracks 0.8 m apart: their border is 0.4 m from either."""
    along = np.arange(0.0, 3.0, 0.15)
    poses = np.array([[x, y, 0.0] for y in (0.0, 0.8) for x in along])
    owner = np.repeat([0, 1], len(along))
    queries = np.array([[1.5, y, 0.0] for y in (-0.2, 0.0, 0.3, 0.79)])
    foot = np.array([10, 10, 10, 30])
    found = border_places(queries, foot, poses, owner, {0: {1}, 1: {0}}, 0.5)
    assert accepted(found) == [[], [1], [1], [0]]


def test_another_place_between_keeps_a_border_away() -> None:
    poses = np.array([[x, 0, 0] for x in (0.0, 0.3, 0.6)])
    found = border_places(np.zeros((1, 3)), np.array([0]), poses, np.arange(3), {0: {1, 2}}, 0.4)
    assert accepted(found) == [[1]]


def test_the_true_place_owns_the_nearest_mapping_pose() -> None:
    mapping = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    result = on_map(mapping, [4, 4, 7], [[0.4, 0, 0], [1.6, 0, 0], [9, 0, 0]], [[4], [4], [4]])
    case = judge(result)
    assert case.true_place.tolist() == [4, 7, -1]
    assert case.best_right.tolist() == [True, False, False]
    assert case.has_match.tolist() == [True, True, False]


def test_accepted_frames_count_for_the_places_that_own_them() -> None:
    result = on_map([[0, 0, 0]] * 3, [4, 4, 7], [[0, 0, 0]] * 2, [[7], [7]])
    pairs = Ragged.of([np.array([0, 1]), np.array([2])], np.dtype(np.int64))
    case = judge(replace(result, truth=Accepted("pairs", "truth.json", pairs)))
    assert accepted(case.accepted) == [[4], [7]]
    assert case.best_right.tolist() == [False, True]


def test_accepted_frames_beyond_the_candidates_do_not_count() -> None:
    case = judge(recognition(np.ones((2, 3)), pairs={0: [0, 2], 1: [2]}, candidates=[1, 3]))
    assert accepted(case.accepted) == [[0], [2]]


def test_truth_of_another_length_is_refused() -> None:
    pairs = Ragged.of([np.array([0])], np.dtype(np.int64))
    result = recognition(np.ones((2, 3)), truth=Accepted("pairs", "truth.json", pairs))
    with pytest.raises(TruthError, match=r"truth.json: 1 rows of truth, the result has 2 queries"):
        judge(result)


def test_the_protocol_of_the_header_decides_what_is_the_same_place() -> None:
    references = rows([[0, 0, math.pi]])
    queries = rows([[2, 0, 0]])
    wide = header("recognize", protocol={"radius_m": 3.0, "heading_deg": "any"})
    for facts, right in ((header("recognize"), False), (wide, True)):
        result = recognition([[1.0]], queries=queries, references=references, header=facts)
        assert judge(result).best_right.tolist() == [right]


def test_queries_without_truth_are_not_judged() -> None:
    queries = rows([[0, 0, 0], [np.nan] * 3])
    case = judge(recognition(np.ones((2, 1)), queries=queries, references=rows([[0, 0, 0]])))
    assert case.judged.tolist() == [True, False]


def test_a_relative_pose_moves_the_estimate_in_the_members_frame() -> None:
    references = rows([[1, 1, math.pi / 2]])
    queries = rows([[1, 3, math.pi]])
    result = recognition(
        [[1.0]],
        queries=queries,
        references=references,
        relative=np.array([[2.0, 0.0, math.pi / 2]]),
    )
    case = judge(result)
    assert case.position_error_m[0] == pytest.approx(0.0, abs=1e-12)
    assert case.heading_error_rad[0] == pytest.approx(0.0, abs=1e-12)
    assert case.member_apart_m[0] == pytest.approx(2.0)


def test_a_stated_rotation_turns_the_frame_of_the_place() -> None:
    mapping = [[0, 0, 0.5], [1, 0, 2.0]]
    result = on_map(mapping, [0, 0], [[0.9, 0, 1.0]], [[0]], headings_rad=np.array([[0.6]]))
    assert judge(result).heading_error_rad[0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("query", "near"),
    [([2.9, 0, 0], True), ([3.1, 0, 0], False), ([2.9, 0, math.radians(91)], False)],
)
def test_near_misses_lie_within_three_metres_and_ninety_degrees(
    query: list[float], near: bool
) -> None:
    result = recognition([[1.0]], queries=rows([query]), references=rows([[0, 0, 0]]))
    assert judge(result).dont_care.tolist() == [near]
