"""Frame-to-frame recognition: who may be matched with whom, in which order, and when not at all."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.toy_system import (
    BIN,
    RECORD,
    Toy,
    ToyParams,
    drive,
    mixed,
    one_hot,
    signature_of,
)
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import LogError
from fpnav.localization.locate import Answers
from fpnav.localization.recognize import (
    ahead,
    elsewhere,
    past_candidates,
    path_apart,
    recognize,
)
from fpnav.store.signatures import collect
from fpnav.store.tables import REFERENCE, Ragged, SignatureTable
from fpnav.values import Reference, Signature


def table(signatures: Sequence[Signature]) -> SignatureTable:
    return collect(signatures, RECORD, Toy.PARTS)


def references(
    travelled: Sequence[float], index: Sequence[int] | None = None, session: Sequence[int] = ()
) -> np.ndarray:  # type: ignore[type-arg]
    rows = np.zeros(len(travelled), dtype=REFERENCE)
    rows["travelled_m"] = travelled
    rows["index"] = np.arange(len(travelled)) if index is None else index
    rows["session"] = session if len(session) else 0
    return rows


def past(run: SignatureTable, path_m: float = 0.0, frames: int = 1) -> np.ndarray:  # type: ignore[type-arg]
    return past_candidates(run.references, path_m, frames)


def match(
    reference: SignatureTable,
    queries: SignatureTable | None = None,
    candidates: Sequence[int] | None = None,
    *,
    depth: int = 5,
    verify_top: int = 0,
    verifies: bool = False,
) -> Answers:
    queries = reference if queries is None else queries
    if candidates is None:
        candidates = [len(reference)] * len(queries)
    return recognize(
        Toy(ToyParams(verifies=verifies)),
        reference,
        queries,
        np.array(candidates),
        depth=depth,
        verify_top=verify_top,
        radius_m=1.5,
        advance=lambda done: None,
    )


def test_a_row_is_matched_with_rows_at_least_so_much_path_before_it() -> None:
    rows = references([0.0, 5.0, 10.0, 15.0, 20.0, 29.9])
    assert past_candidates(rows, 15.0, 0).tolist() == [0, 0, 0, 1, 2, 3]


def test_a_row_is_matched_with_rows_at_least_so_many_frames_before_it() -> None:
    rows = references([0.0] * 5, index=[0, 10, 20, 21, 30])
    assert past_candidates(rows, 0.0, 10).tolist() == [0, 1, 2, 2, 3]


def test_both_exclusions_hold_together_and_never_is_a_row_its_own_match() -> None:
    rows = references([0.0, 1.0, 2.0, 3.0])
    assert past_candidates(rows, 0.0, 0).tolist() == [0, 1, 2, 3]
    assert past_candidates(rows, 1.0, 3).tolist() == [0, 0, 0, 1]
    assert past_candidates(rows, 3.0, 1).tolist() == [0, 0, 0, 1]


def test_standing_still_is_no_path() -> None:
    rows = references([0.0, 0.0, 0.0, 15.0, 15.0])
    assert past_candidates(rows, 15.0, 0).tolist() == [0, 0, 0, 3, 3]


def test_every_row_of_earlier_sessions_may_be_matched() -> None:
    rows = references([0.0, 20.0, 0.0, 10.0, 20.0], [0, 1, 0, 1, 2], [0, 0, 1, 1, 1])
    assert past_candidates(rows, 15.0, 0).tolist() == [0, 1, 2, 2, 3]


def test_a_path_cannot_be_excluded_where_none_is_known() -> None:
    rows = references([0.0, np.nan])
    with pytest.raises(LogError, match="use --exclude-frames"):
        past_candidates(rows, 15.0, 0)
    assert past_candidates(rows, 0.0, 1).tolist() == [0, 1]


@given(
    st.lists(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=8), min_size=1, max_size=3),
    st.floats(0.0, 6.0),
    st.integers(0, 4),
)
def test_candidates_equal_a_search_row_by_row(
    sessions: list[list[float]], path_m: float, frames: int
) -> None:
    travelled = [np.cumsum(steps) for steps in sessions]
    session = np.repeat(np.arange(len(sessions)), [len(steps) for steps in sessions])
    index = np.concatenate([3 * np.arange(len(steps)) for steps in sessions])
    rows = references(np.concatenate(travelled).tolist(), index.tolist(), session.tolist())
    expected = [
        sum(
            session[other] < session[row]
            or (
                session[other] == session[row]
                and other < row
                and rows["travelled_m"][other] <= rows["travelled_m"][row] - path_m
                and index[other] <= index[row] - frames
            )
            for other in range(len(rows))
        )
        for row in range(len(rows))
    ]
    assert past_candidates(rows, path_m, frames).tolist() == expected


def test_a_run_finds_its_own_past_but_not_what_is_excluded() -> None:
    run = table(drive([0, 0, 1, 1, 2, 2, 0, 0, 1, 1]))
    found = match(run, candidates=past(run, frames=3).tolist())
    assert found.decision.tolist() == [-1, -1, -1, -1, -1, -1, 0, 0, 2, 2]
    assert found.places[:3, 0].tolist() == [-1, -1, -1]
    assert found.places[3, 0] == 0  # the only row allowed, though unlike
    assert found.members.tolist() == found.places.tolist()


def test_queries_are_matched_with_all_of_another_run() -> None:
    reference, queries = table(drive([0, 0, 1, 1, 2, 2])), table(drive([2, 7, 1]))
    found = match(reference, queries)
    assert found.decision.tolist() == [4, -1, 2]
    assert found.places.shape == (3, 5)
    assert found.places[1].tolist() == [0, 1, 2, 3, 4]
    assert np.isnan(found.entropy).all()


def test_rankings_are_padded_where_fewer_rows_are_allowed_than_asked_for() -> None:
    run = table(drive([0, 0, 0]))
    found = match(run, candidates=[0, 1, 2], depth=4)
    assert found.places.tolist() == [[-1] * 4, [0, -1, -1, -1], [0, 1, -1, -1]]
    assert np.isneginf(found.scores[0]).all()
    assert found.stated[0] < 1e-9


def test_equal_scores_are_ranked_by_row() -> None:
    assert match(table(drive([0] * 6)), depth=6).places[2].tolist() == [0, 1, 2, 3, 4, 5]


def with_details(details: Sequence[float], looks: Sequence[int] | None = None) -> SignatureTable:
    looks = [0] * len(details) if looks is None else looks
    return table(
        [
            signature_of(Reference(row, row, travelled_m=float(row)), one_hot(look), detail=detail)
            for row, (look, detail) in enumerate(zip(looks, details, strict=True))
        ]
    )


def test_verification_reorders_the_best_candidates_and_gives_their_pose() -> None:
    reference = with_details([10.0, 20.0, 30.0, 40.0, 50.0])
    found = match(reference, with_details([31.0]), verify_top=3, verifies=True)
    assert found.places.tolist() == [[2, 1, 0, 3, 4]]
    assert found.scores[0, :3].tolist() == [99.0, 89.0, 79.0]
    assert (np.diff(found.scores[0]) <= 0).all()
    assert found.relative[0].tolist() == [1.0, 0.0, 0.0]
    assert found.covariance[0].tolist() == np.eye(3).tolist()


def test_verification_goes_beyond_the_depth_of_the_ranking() -> None:
    found = match(
        with_details([10.0, 20.0, 30.0, 40.0, 50.0]), with_details([51.0]),
        depth=2, verify_top=5, verifies=True,
    )  # fmt: skip
    assert found.places.tolist() == [[4, 3]]


def test_verification_leaves_out_what_is_not_allowed() -> None:
    reference = with_details([10.0, 20.0, 30.0])
    found = match(reference, with_details([31.0, 31.0]), [2, 0], verify_top=3, verifies=True)
    assert found.places[:, :2].tolist() == [[1, 0], [-1, -1]]
    assert np.isnan(found.relative[1]).all()


def test_equal_checks_are_ranked_by_row() -> None:
    found = match(with_details([5.0] * 4), with_details([5.0]), verify_top=4, verifies=True)
    assert found.places[0, :4].tolist() == [0, 1, 2, 3]


def test_a_system_without_a_check_keeps_its_ranking() -> None:
    reference = with_details([10.0, 20.0, 30.0])
    found = match(reference, with_details([31.0]), verify_top=3, verifies=False)
    assert found.places[0, :3].tolist() == [0, 1, 2]
    assert np.isnan(found.relative).all()


def test_what_is_stated_after_a_check_is_learned_on_the_scale_of_the_check() -> None:
    smooth = [float(row) for row in range(40)]
    found = match(with_details(smooth), with_details([20.2, 400.0]), verify_top=40, verifies=True)
    assert found.decision.tolist() == [20, -1]
    assert found.stated[0] > 0.5 > found.stated[1]


def test_it_abstains_where_the_best_is_no_better_than_a_chance_match() -> None:
    looks = [mixed(row // 5, row // 5 + 1, (row % 5) / 5) for row in range(35)]
    run = table(
        [signature_of(Reference(i, i, travelled_m=i), look) for i, look in enumerate(looks)]
    )
    patchwork = [0.0, 0.0, 0.3, 0.0, 0.0, 0.35, 0.0, 0.35]
    queries = table([signature_of(Reference(0, 0), patchwork), run[12]])
    found = match(run, queries)
    assert found.decision.tolist() == [-1, 12]


def test_too_short_a_reference_teaches_nothing_and_nothing_is_decided() -> None:
    found = match(table(drive([0, 1, 2])))
    assert found.decision.tolist() == [-1, -1, -1]
    assert found.places[:, 0].tolist() == [0, 1, 2]


def test_no_queries_and_no_reference_are_answered() -> None:
    run, nothing = table(drive([0, 1, 2, 3, 4])), table([])
    assert match(run, nothing).places.shape == (0, 5)
    assert match(nothing, run).decision.tolist() == [-1] * 5


def many(count: int) -> SignatureTable:
    rng = np.random.default_rng(0)
    rows = references(np.arange(count, dtype=np.float64).tolist())
    bins = np.zeros(count * 8, dtype=BIN)
    bins["height"] = rng.dirichlet(np.ones(8), count).ravel()
    return SignatureTable(
        rows, np.zeros(count, dtype=RECORD), {"bins": Ragged(bins, np.arange(count + 1) * 8)}
    )


def seconds(count: int) -> float:
    run = many(count)
    rows = np.arange(0, count, count // 50)
    asked = table([run[int(row)] for row in rows])
    started = time.perf_counter()
    match(run, asked, past(run, 15.0)[rows].tolist(), depth=25)
    return time.perf_counter() - started


@pytest.mark.slow
def test_ten_times_the_references_cost_about_ten_times_as_much() -> None:
    assert seconds(50_000) < 30 * seconds(5_000) + 2.0


def test_what_lies_a_few_radii_of_path_away_is_elsewhere_and_what_is_nearer_is_not() -> None:
    apart = path_apart(references([0.02 * k for k in range(300)]))
    found = elsewhere(apart, 100, 1.0)
    assert not found[:201].any()  # 2 m either way, though a hundred rows
    assert found[201:].all()
    assert ahead(apart, 100, 0.5) == 125


def test_rows_without_a_path_go_by_their_order_and_sessions_are_apart() -> None:
    unknown = path_apart(references([np.nan] * 40))
    assert np.flatnonzero(~elsewhere(unknown, 20, 1.5)).tolist() == list(range(10, 31))
    assert ahead(unknown, 20, 0.75) == 21
    two = path_apart(references([0.0, 1.0, 0.0, 1.0], session=[0, 0, 1, 1]))
    assert np.isinf(two(0)).tolist() == [False, False, True, True]


def test_where_the_run_is_sparse_the_next_row_is_ahead() -> None:
    assert ahead(path_apart(references([0.0, 5.0, 10.0])), 0, 0.75) == 1
