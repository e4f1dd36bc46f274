"""From a run to answers on a map, by matching, filtering and smoothing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from helpers.toy_system import Toy, ToyMemory, ToyParams, drive, mixed, one_hot, signature_of
from numpy.typing import NDArray

from fpnav.localization import locate as module
from fpnav.localization.confidence import Confidence
from fpnav.localization.filter import FilterParams
from fpnav.localization.locate import Answers, Method, locate
from fpnav.localization.recall import by_place, frame_memory, recall_all
from fpnav.mapping.build import Built, build_map
from fpnav.systems.base import Recall
from fpnav.topomap.graph import TopoMap
from fpnav.values import Place, Pose2, Reference, Signature

SURE = Confidence(0.75, 50.0)
WAY = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]


def look(row: int, histogram: Any, heading: float = 0.0, session: int = 0) -> Signature:
    pose = Pose2(0.0, 0.0, heading)
    return signature_of(Reference(row, row, session, float(row), pose), histogram)


def build(rows: Sequence[Signature], *, guided: bool = False) -> Built:
    return build_map(Toy(ToyParams()), rows, guided=guided, advance=lambda done: None)


def answer(
    rows: Sequence[Signature],
    queries: Sequence[Signature],
    method: Method = Method.MATCH,
    *,
    built: Built | None = None,
    depth: int = 10,
    memory: Any = None,
    **params: Any,
) -> Answers:
    built = build(rows) if built is None else built
    remembered = built.memory if memory is None else memory
    recall = recall_all(remembered, queries, len(built.topomap), None, lambda done: None)
    return locate(
        Toy(),
        built.topomap,
        rows,
        queries,
        recall,
        method=method,
        params=FilterParams(**params),
        confidence=SURE,
        depth=depth,
    )


def test_matching_ranks_all_places_and_names_the_member_that_is_most_alike() -> None:
    rows = [look(i, mixed(i // 3, i // 3 + 1, 0.1 * (i % 3))) for i in range(6)]
    found = answer(rows, [look(0, mixed(1, 2, 0.1))])
    assert found.places.tolist() == [[1, 0]]
    assert found.members[0, 0] == 4
    assert found.decision.tolist() == [1]
    assert found.stated == pytest.approx(SURE.stated(found.scores[:, 0]))


def test_a_look_that_fits_nowhere_is_not_localized_but_its_ranking_stays() -> None:
    found = answer(drive(WAY), [look(0, one_hot(7)), look(1, mixed(2, 7, 0.5))])
    assert found.decision.tolist() == [-1, -1]
    assert found.places[1, 0] == 2
    assert found.stated[1] < 0.5


def test_the_ranking_is_cut_at_the_depth() -> None:
    assert answer(drive(WAY), drive([1]), depth=2).places.shape == (1, 2)
    assert answer(drive(WAY), drive([1]), depth=99).places.shape == (1, 4)


def test_the_heading_of_the_first_rank_turns_from_the_best_member() -> None:
    rows = [look(0, mixed(0, 1, 0.0), 0.5), look(1, mixed(0, 1, 0.2), 1.5), look(2, one_hot(4))]
    for method in Method:
        found = answer(rows, [look(0, mixed(0, 1, 0.2), 2.0)], method)
        assert found.members[0, 0] == 1
        assert found.headings_rad[0, 0] == pytest.approx(0.5)


class FirstHeadingOnly(ToyMemory):
    """Gives the heading of the best place only, as memories may."""

    def recall(
        self, signatures: Sequence[Signature], k: int, allowed: Any, trace: Any
    ) -> tuple[Recall, Any]:
        found, trace = super().recall(signatures, k, allowed, trace)
        headings = np.full_like(found.headings_rad, math.nan)
        headings[:, :1] = found.headings_rad[:, :1]
        return Recall(found.places, found.scores, headings), trace


def test_the_heading_at_a_place_belief_puts_first_is_asked_for() -> None:
    rows = drive(WAY)
    built = build(rows)
    memory = FirstHeadingOnly()
    memory.load(built.memory.save())
    queries = drive([0, 0, 0, 0])
    queries[3] = look(3, mixed(5, 6, 0.5), 0.25)  # fits nowhere: all places tie, the first is 0
    queries = [look(i, one_hot(3), 0.25) for i in range(3)] + queries[3:]
    found = answer(rows, queries, Method.FILTER, built=built, memory=memory)
    assert found.places[3, 0] == 3
    assert found.headings_rad[:, 0] == pytest.approx([0.25] * 4)


def test_the_filter_carries_belief_over_a_query_that_says_nothing() -> None:
    queries = drive([2, 2, 2, 2, 7, 2], step_m=0.1)
    match, found = answer(drive(WAY), queries), answer(drive(WAY), queries, Method.FILTER)
    assert match.decision.tolist() == [2, 2, 2, 2, -1, 2]
    assert found.decision.tolist()[1:] == [2, 2, 2, 2, 2]
    assert found.belief.shape == (6, 4)
    assert found.belief.sum(axis=1) == pytest.approx(np.ones(6))
    assert found.stated == pytest.approx(found.belief.max(axis=1))
    assert found.places[:, 0].tolist() == found.belief.argmax(axis=1).tolist()


def test_the_filter_withholds_its_answer_while_belief_is_spread() -> None:
    rows = drive([0, 0, 1, 1, 0, 0, 2, 2])  # places 0 and 2 look the same
    found = answer(rows, drive([0]), Method.FILTER)
    assert found.decision.tolist() == [-1]
    assert found.stated[0] == pytest.approx(0.5, abs=0.1)
    assert found.entropy[0] > 0.3 * math.log(4)


def test_driving_on_tells_two_places_that_look_the_same_apart() -> None:
    rows = drive([0] * 4 + [1] * 4 + [0] * 4 + [2] * 4)
    queries = drive([0, 0, 0, 0, 2, 2, 2, 2])
    filtered = answer(rows, queries, Method.FILTER)
    smoothed = answer(rows, queries, Method.SMOOTH)
    assert filtered.decision[0] == -1
    assert smoothed.places[:4, 0].tolist() == [2, 2, 2, 2]
    assert filtered.decision[-1] == smoothed.decision[-1] == 3


@pytest.mark.parametrize(("heading", "expected"), [(0.0, 2), (math.pi, 0)])
def test_belief_moves_the_way_the_robot_heads_on_the_map(heading: float, expected: int) -> None:
    queries = [look(i, one_hot(1), heading) for i in range(3)]
    queries += [look(3 + i, one_hot(7), heading) for i in range(3)]
    found = answer(drive(WAY), queries, Method.FILTER, kappa=5.0)
    assert found.places[2, 0] == 1
    assert found.belief[3:, expected].min() > found.belief[3:, 2 - expected].max()


def test_the_most_likely_path_takes_the_first_rank_where_it_is_asked_for() -> None:
    queries = drive([0, 0, 3, 0, 0, 0])
    posterior = answer(drive(WAY), queries, Method.SMOOTH)
    path = answer(drive(WAY), queries, Method.SMOOTH, decode="viterbi", kidnap=1e-6)
    assert path.places[:, 0].tolist() == [0] * 6
    assert path.belief == pytest.approx(
        answer(drive(WAY), queries, Method.SMOOTH, kidnap=1e-6).belief
    )
    assert sorted(path.places[2].tolist()) == sorted(posterior.places[2].tolist())


def test_a_new_session_may_begin_anywhere() -> None:
    queries = drive([0] * 6) + drive([3], session=1)
    found = answer(drive(WAY), queries, Method.FILTER)
    assert found.places[6, 0] == 3
    assert found.belief[6] == pytest.approx(found.belief[0][::-1])


def test_places_that_have_equal_belief_are_ranked_by_id() -> None:
    found = answer(drive([4, 5, 6]), drive([7]), Method.FILTER)
    assert found.places.tolist() == [[0, 1, 2]]


def test_a_belief_too_large_to_keep_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LARGEST_BELIEF", 7)
    found = answer(drive(WAY), drive([1, 2]), Method.FILTER)
    assert found.belief.shape == (2, 0)
    assert np.isfinite(found.entropy).all()


def test_matching_states_no_belief() -> None:
    found = answer(drive(WAY), drive([1, 2]))
    assert found.belief.shape == (2, 0)
    assert np.isnan(found.entropy).all()
    assert np.isnan(found.relative).all()


@pytest.mark.parametrize("method", list(Method))
def test_a_run_without_queries_has_an_answer_of_no_rows(method: Method) -> None:
    found = answer(drive(WAY), [], method)
    assert found.places.shape == (0, 4)
    assert found.decision.shape == (0,)


def test_places_of_a_map_need_not_count_from_zero() -> None:
    rows = drive([0, 0, 1, 1])
    memory = ToyMemory()
    for place, row in zip((7, 7, 30, 30), rows, strict=True):
        memory.learn(place, row)
    topomap = TopoMap.of([Place(7, (0, 1), 1.0), Place(30, (2, 3), 1.0)], [])
    built = Built(topomap, memory, np.zeros(4), 0.5)
    for method in Method:
        found = answer(rows, drive([1, 1, 1]), method, built=built)
        assert found.places[:, 0].tolist() == [30, 30, 30]
        assert found.members[:, 0].tolist() == [2, 2, 2]


def test_scores_by_place_leave_what_was_not_ranked_at_minus_infinity() -> None:
    recall = Recall(np.array([[9, 4], [4, -1]]), np.array([[2.0, 1.0], [3.0, -np.inf]]),
                    np.array([[0.1, 0.2], [0.3, math.nan]]))  # fmt: skip
    scores, headings = by_place(recall, np.array([4, 6, 9]))
    assert scores.tolist() == [[1.0, -np.inf, 2.0], [3.0, -np.inf, -np.inf]]
    assert np.nan_to_num(headings, nan=-9).tolist() == [[0.2, -9, 0.1], [0.3, -9, -9]]


def test_recall_in_blocks_carries_the_trace_and_masks_the_right_rows() -> None:
    rows = drive([i % 8 for i in range(150)])
    memory = frame_memory(Toy(), rows)
    seen: list[Any] = []
    plain = memory.recall

    def spied(signatures: Any, k: int, mask: Any, trace: Any) -> Any:
        seen.append((len(signatures), trace))
        return plain(signatures, k, mask, trace)

    memory.recall = spied  # type: ignore[method-assign]

    def only_itself(start: int, stop: int) -> NDArray[np.bool_]:
        return np.asarray(np.arange(150)[None, :] == np.arange(start, stop)[:, None])

    done: list[int] = []
    found = recall_all(memory, rows, 2, only_itself, done.append)
    assert found.places.tolist() == [[i, -1] for i in range(150)]
    assert seen == [(64, None), (64, 1), (22, 2)]
    assert sum(done) == 150


DETAILS = [10.0, 11.0, 12.0, 20.0, 21.0, 22.0, 30.0, 31.0, 32.0]


def detailed(detail: float, look: Any = None) -> Signature:
    return signature_of(Reference(0, 0), one_hot(0) if look is None else look, detail=detail)


def checked_answer(
    detail: float,
    method: Method = Method.MATCH,
    *,
    verifies: bool = True,
    whole: bool = True,
    look: Any = None,
) -> Answers:
    """Three places; by likeness a query looks like the first, ``detail`` says where it is."""
    rows = [detailed(value, mixed(0, 1, 0.1 * (k // 3))) for k, value in enumerate(DETAILS)]
    memory = ToyMemory()
    for k, row in enumerate(rows):
        memory.learn(5 * (k // 3), row)
    places = [Place(5 * n, (3 * n, 3 * n + 1, 3 * n + 2), 1.0) for n in range(3)]
    topomap, queries = TopoMap.of(places, []), [detailed(detail, look)]
    recall = recall_all(memory, queries, 3, None, lambda done: None)
    return locate(
        Toy(ToyParams(verifies=verifies, whole=whole)), topomap, rows, queries, recall,
        method=method, params=FilterParams(), confidence=SURE, depth=10,
    )  # fmt: skip


def test_a_check_puts_the_place_of_the_best_checked_member_first_with_its_pose() -> None:
    found = checked_answer(31.25)
    assert found.places.tolist() == [[10, 5, 0]]
    assert found.members.tolist() == [[7, 5, 2]]
    assert found.scores.tolist() == [[99.75, 90.75, 80.75]]
    assert found.relative.tolist() == [[0.25, 0.0, 0.0]]
    assert found.headings_rad[0, 0] == 0.0
    assert found.covariance[0].tolist() == np.eye(3).tolist()


def test_without_a_probability_of_the_check_that_of_the_chosen_place_is_stated() -> None:
    assert checked_answer(31.25).stated == pytest.approx(SURE.stated(np.array([0.8])))
    assert checked_answer(31.25).decision.tolist() == [10]
    nowhere = checked_answer(31.25, look=mixed(0, 7, 0.5))
    assert (nowhere.places[0, 0], nowhere.decision[0]) == (10, -1)


def test_a_place_without_checked_members_follows_those_that_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "CHECKED_PLACES", 2)
    found = checked_answer(31.25)
    assert found.places.tolist() == [[5, 0, 10]]
    assert found.members.tolist() == [[5, 2, -1]]
    assert (np.diff(found.scores[0]) <= 0).all()


def test_only_the_members_most_alike_are_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "CHECKED_MEMBERS", 3)
    found = checked_answer(31.25)
    assert found.places.tolist() == [[0, 5, 10]]
    assert found.members.tolist() == [[2, -1, -1]]


def test_without_a_check_the_ranking_by_likeness_stays() -> None:
    found = checked_answer(31.25, verifies=False)
    assert found.places.tolist() == [[0, 5, 10]]
    assert found.scores[0] == pytest.approx([1.0, 0.9, 0.8])
    assert np.isnan(found.relative).all()


def test_a_check_that_overlooks_a_sensor_does_not_reorder_places() -> None:
    plain, found = checked_answer(31.25, verifies=False), checked_answer(31.25, whole=False)
    assert found.places.tolist() == plain.places.tolist()
    assert found.scores.tolist() == plain.scores.tolist()


@pytest.mark.parametrize("method", [Method.FILTER, Method.SMOOTH])
def test_belief_is_not_overruled_by_a_check(method: Method) -> None:
    plain, found = (checked_answer(31.25, method, verifies=on) for on in (False, True))
    assert found.places.tolist() == plain.places.tolist()
    assert np.isnan(found.relative).all()
