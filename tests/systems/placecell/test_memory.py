"""What place cells learn and answer, on constellations made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.constellations import PARAMS, constellation
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from fpnav.errors import StoreError
from fpnav.mapping.build import build_map
from fpnav.systems.placecell import Placecell, PlacecellParams
from fpnav.systems.placecell.memory import PlacecellMemory
from fpnav.values import Signature

HERE = {0: 10.0, 1: 100.0, 2: -60.0}
THERE = {3: 0.0, 4: 50.0, 5: 170.0}


def memory(params: PlacecellParams, *learned: tuple[int, Signature]) -> PlacecellMemory:
    made = Placecell(params).memory()
    for place, signature in learned:
        made.learn(place, signature)
    return made


def ask(made: PlacecellMemory, *queries: Signature, k: int = 9) -> tuple[list, list, list]:
    found, _ = made.recall(list(queries), k, None, None)
    return found.places.tolist(), found.scores.tolist(), found.headings_rad.tolist()


def variant(**values: object) -> PlacecellParams:
    return structs.replace(PARAMS, **values)


def test_a_learned_place_answers_with_one() -> None:
    made = memory(PARAMS, (4, constellation(HERE, heading=0)), (7, constellation(THERE, heading=0)))
    places, scores, _ = ask(made, constellation(HERE, heading=0), k=2)
    assert places == [[4, 7]]
    assert scores == [[1.0, 0.0]]


def test_views_moved_in_azimuth_cost_their_diffusion() -> None:
    made = memory(PARAMS, (0, constellation(HERE, heading=0)))
    moved = {0: 10.0 + 29.7, 1: 100.0, 2: -60.0}
    _, scores, _ = ask(made, constellation(moved, heading=0), k=1)
    assert scores[0][0] == pytest.approx((0.5 + 1 + 1) / 3, abs=1e-6)


def test_the_compass_turns_the_views_back() -> None:
    made = memory(PARAMS, (0, constellation(HERE, heading=20)))
    turned = {number: bearing - 40 for number, bearing in HERE.items()}
    _, scores, headings = ask(made, constellation(turned, heading=60), k=1)
    assert scores[0][0] == pytest.approx(1.0, abs=1e-6)
    assert math.degrees(headings[0][0]) == pytest.approx(40.0)


def test_equation_4_survives_what_is_hidden() -> None:
    hidden = {0: 10.0}
    for rho, wanted in ((1.0, 1 / 3), (0.3, 1.0)):
        made = memory(variant(rho_l=rho), (0, constellation(HERE, heading=0)))
        assert ask(made, constellation(hidden, heading=0), k=1)[1][0][0] == pytest.approx(wanted)


def test_elevation_counts_where_its_diffusion_is_finite() -> None:
    learned = constellation({0: 0.0}, heading=0, elevation=[0.0])
    raised = constellation({0: 0.0}, heading=0, elevation=[9.0])
    assert ask(memory(PARAMS, (0, learned)), raised, k=1)[1] == [[1.0]]
    made = memory(variant(rho_el=0.1), (0, learned))
    assert ask(made, raised, k=1)[1][0][0] == pytest.approx(0.5)


def test_azimuth_neurons_quantise_what_is_learned() -> None:
    made = memory(variant(azimuth_bins=36), (0, constellation({0: 12.0}, heading=0)))
    assert ask(made, constellation({0: 10.0}, heading=0), k=1)[1][0][0] == pytest.approx(1.0)


def test_strict_competition_gives_a_view_to_one_place_alone() -> None:
    learned = (0, constellation({0: 0.0}, heading=0)), (1, constellation({0: 5.0}, heading=0))
    query = constellation({0: 4.0}, heading=0)
    strict = ask(memory(variant(interpretations=1), *learned), query, k=2)
    soft = ask(memory(PARAMS, *learned), query, k=2)
    assert strict[0] == [[0, 1]]
    assert strict[1][0][1] == 0.0
    assert soft[0] == [[1, 0]]
    assert soft[1][0][1] > 0.9


def test_places_not_allowed_leave_the_competition_too() -> None:
    made = memory(
        variant(interpretations=1),
        (0, constellation({0: 0.0}, heading=0)),
        (1, constellation({0: 5.0}, heading=0)),
    )
    found, _ = made.recall([constellation({0: 5.0}, heading=0)], 2, np.array([[False, True]]), None)
    assert found.places.tolist() == [[1, -1]]
    assert found.scores[0, 0] == pytest.approx(1.0)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_allowed_answers_as_a_memory_of_the_allowed_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    signatures = [
        constellation({int(n): float(rng.uniform(-180, 180)) for n in rng.integers(0, 6, 4)})
        for _ in range(6)
    ]
    params = variant(heading="search", interpretations=2, rho_l=0.5)
    allowed = rng.random(5) < 0.6
    whole = memory(params, *enumerate(signatures[:5]))
    part = memory(params, *((i, signatures[i]) for i in np.flatnonzero(allowed)))
    found, _ = whole.recall(signatures[5:], 5, allowed[None, :], None)
    wanted, _ = part.recall(signatures[5:], 5, None, None)
    assert found.places.tolist() == wanted.places.tolist()
    assert found.scores == pytest.approx(wanted.scores)


def turned(views: dict[int, float], by: float) -> dict[int, float]:
    return {number: bearing - by for number, bearing in views.items()}


def test_a_search_needs_no_compass_and_finds_the_heading() -> None:
    made = memory(variant(heading="search"), (0, constellation(HERE)), (1, constellation(THERE)))
    places, scores, headings = ask(made, constellation(turned(THERE, 77.0)), k=1)
    assert places == [[1]]
    assert scores[0][0] > 0.95
    assert math.degrees(headings[0][0]) == pytest.approx(77.0, abs=2.5)


def test_without_a_compass_in_the_map_the_heading_is_searched_for() -> None:
    made = memory(PARAMS, (0, constellation(HERE)))
    _, scores, headings = ask(made, constellation(turned(HERE, -50.0), heading=3.0), k=1)
    assert scores[0][0] == pytest.approx(1.0, abs=0.05)
    assert math.degrees(headings[0][0]) == pytest.approx(-50.0, abs=2.5)


def test_a_query_whose_compass_failed_is_searched_for() -> None:
    made = memory(PARAMS, (0, constellation(HERE, heading=30)))
    _, scores, headings = ask(made, constellation(turned(HERE, 90.0)), k=1)
    assert scores[0][0] == pytest.approx(1.0, abs=0.05)
    assert math.degrees(headings[0][0]) == pytest.approx(90.0, abs=2.5)


def test_landmarks_vote_for_the_heading() -> None:
    params = variant(heading="visual")
    first = constellation(HERE, odometry=10)
    made = memory(params, (0, first), (1, constellation(THERE, odometry=40)))
    _, scores, headings = ask(made, constellation(turned(THERE, 25.0)), k=1)
    assert scores[0][0] == pytest.approx(1.0, abs=0.02)
    assert math.degrees(headings[0][0]) == pytest.approx(25.0, abs=1.0)


def test_a_visual_compass_carries_its_reference_from_place_to_place() -> None:
    params = variant(heading="visual")
    both = {**HERE, **THERE}
    made = memory(params, (0, constellation(both)), (1, constellation(turned(THERE, 60.0))))
    _, _, headings = ask(made, constellation(turned(THERE, 70.0)), k=2)
    assert math.degrees(headings[0][0]) == pytest.approx(10.0, abs=1.5)
    assert math.degrees(headings[0][1]) == pytest.approx(70.0, abs=1.5)


def test_odometry_may_be_the_compass() -> None:
    params = variant(heading="odometry")
    made = memory(params, (0, constellation(HERE, odometry=0)))
    _, scores, headings = ask(made, constellation(turned(HERE, 33.0), odometry=33), k=1)
    assert scores[0][0] == pytest.approx(1.0, abs=1e-6)
    assert math.degrees(headings[0][0]) == pytest.approx(33.0)


def test_one_shot_learning_keeps_one_cell_a_place() -> None:
    made = memory(PARAMS, (0, constellation(HERE, heading=0)), (0, constellation(THERE, heading=0)))
    assert ask(made, constellation(THERE, heading=0), k=1)[1] == [[0.0]]
    assert made.landmarks == 3


def test_more_cells_answer_by_the_best() -> None:
    params = variant(cells=2)
    made = memory(
        params,
        (0, constellation(HERE, heading=0)),
        (0, constellation(THERE, heading=0)),
        (0, constellation({6: 0.0}, heading=0)),
    )
    assert ask(made, constellation(THERE, heading=0), k=1)[1] == [[1.0]]
    assert made.landmarks == 6


def test_a_cell_already_active_enough_is_not_doubled() -> None:
    params = variant(cells=0, cell_vigilance=0.9)
    made = memory(params, (0, constellation(HERE, heading=0)), (0, constellation(HERE, heading=2)))
    assert made.landmarks == 3


@pytest.mark.parametrize("odometry", [math.nan, 0.0])
def test_further_cells_share_the_frame_of_their_place(odometry: float) -> None:
    """The second cell is brought into the first one's frame by odometry or by what it sees."""
    params = variant(heading="search", cells=0)
    second = turned({**HERE, 9: 70.0}, 90.0)
    made = memory(
        params,
        (0, constellation(HERE, odometry=odometry)),
        (0, constellation(second, odometry=odometry + 90.0)),
    )
    _, _, headings = ask(made, constellation(turned(second, 20.0)), k=1)
    assert math.degrees(headings[0][0]) == pytest.approx(110.0, abs=4.0)


def test_landmarks_are_reused_where_asked() -> None:
    params = variant(reuse=True)
    again = {0: 30.0, 1: 120.0, 9: 5.0}
    made = memory(params, (0, constellation(HERE, heading=0)), (1, constellation(again, heading=0)))
    assert made.landmarks == 4
    places, scores, _ = ask(made, constellation(again, heading=0), k=2)
    assert places == [[1, 0]]
    assert scores[0][0] == pytest.approx(1.0, abs=1e-6)


def test_repeatability_lets_what_was_seen_again_count_more() -> None:
    params = variant(weights="repeatability")
    first = constellation(HERE, heading=0)
    again = constellation({0: 10.0, 1: 100.0}, heading=0)
    made = memory(params, (0, first), (0, again), (0, again))
    stable = ask(made, again, k=1)[1][0][0]
    fickle = ask(made, constellation({1: 100.0, 2: -60.0}, heading=0), k=1)[1][0][0]
    assert stable == pytest.approx((0.75 + 0.75) / (0.75 + 0.75 + 0.25))
    assert fickle < stable


def test_short_term_memory_carries_over_panoramas() -> None:
    made = memory(variant(qmax=2), (0, constellation(HERE, heading=0)))
    nothing = constellation({}, heading=0)
    _, scores, _ = ask(made, constellation(HERE, heading=0), nothing, nothing, k=1)
    assert [row[0] for row in scores] == [1.0, 1.0, 0.0]


def test_a_place_that_memory_alone_holds_still_tells_the_heading() -> None:
    made = memory(variant(qmax=2), (0, constellation(HERE, heading=0)))
    _, scores, headings = ask(
        made, constellation(HERE, heading=0), constellation({}, heading=30), k=1
    )
    assert scores[1][0] == 1.0
    assert math.degrees(headings[1][0]) == pytest.approx(30.0)


@pytest.mark.parametrize("stm", ["counter", "literal", "window"])
@pytest.mark.parametrize("qmax", [2, 3])
def test_a_batch_is_a_stream(stm: str, qmax: int) -> None:
    made = memory(variant(stm=stm, qmax=qmax), (0, constellation(HERE, heading=0)))
    queries = [constellation(v, heading=0) for v in ({0: 5.0}, {1: 90.0}, {}, {2: -60.0}, {})]
    whole, _ = made.recall(queries, 1, None, None)
    trace, scores = None, []
    for query in queries:
        found, trace = made.recall([query], 1, None, trace)
        scores.append(found.scores[0, 0])
    assert whole.scores[:, 0] == pytest.approx(scores)


def test_streaming_images_are_remembered_one_by_one() -> None:
    params = variant(streaming=True, images=2, qmax=2)
    made = memory(params, (0, constellation(HERE, heading=0)))
    first = constellation({0: 10.0, 1: 100.0}, heading=0, image=[1, 0])
    second = constellation({1: 100.0, 2: -60.0}, heading=0, image=[1, 0])
    _, scores, _ = ask(made, first, second, k=1)
    assert [row[0] for row in scores] == pytest.approx([2 / 3, 2 / 3])


def test_novelty_is_what_the_present_place_lacks() -> None:
    params = variant(refractory=0)
    made = memory(params, (0, constellation(HERE, heading=0)))
    value, trace = made.novelty(constellation({0: 10.0}, heading=0), None, None)
    assert value == pytest.approx(2 / 3)
    assert made.novelty(constellation(HERE, heading=0), None, trace)[0] == pytest.approx(0.0)


def test_novelty_is_measured_at_the_cell_that_founded_the_place() -> None:
    params = variant(refractory=0, cells=0)
    first = constellation(HERE, heading=0)
    made = memory(params, (0, first), (0, constellation({**HERE, 0: 50.0}, heading=0)))
    query = constellation({0: 50.0}, heading=0)
    value, _ = made.novelty(query, None, None)
    assert value == pytest.approx(1 - (1 - 40 / 59.4) / 3, abs=1e-3)


def test_soon_after_a_place_nothing_is_new() -> None:
    made = memory(variant(refractory=2), (0, constellation(HERE, heading=0)))
    trace, values = None, []
    for _ in range(4):
        value, trace = made.novelty(constellation(THERE, heading=0), None, trace)
        values.append(value >= 0.5)
    assert values == [False, False, True, True]


def test_places_may_be_learned_by_distance() -> None:
    made = memory(variant(spacing_m=1.0), (0, constellation(HERE, heading=0, travelled=2.0)))
    for travelled, wanted in ((2.5, 0.0), (3.0, 1.0)):
        query = constellation(THERE, heading=0, travelled=travelled)
        assert made.novelty(query, None, None)[0] == wanted


def test_merged_places_answer_as_one() -> None:
    made = memory(PARAMS, (3, constellation(HERE, heading=0)), (8, constellation(THERE, heading=0)))
    made.merge(8, 3)
    assert made.places.tolist() == [8]
    assert ask(made, constellation(HERE, heading=0), constellation(THERE, heading=0), k=1)[1] == [
        [1.0],
        [1.0],
    ]


def test_merging_brings_both_into_one_frame() -> None:
    params = variant(heading="search")
    common = {**HERE, 7: 30.0}
    made = memory(params, (0, constellation(HERE)), (1, constellation(turned(common, 120.0))))
    made.merge(0, 1)
    _, _, headings = ask(made, constellation(turned(common, 150.0)), k=1)
    assert math.degrees(headings[0][0]) == pytest.approx(150.0, abs=4.0)


def test_shrinking_keeps_what_tells_places_apart() -> None:
    params = variant(cells=1)
    made = memory(
        params,
        (0, constellation({0: 0.0, 1: 90.0}, heading=0)),
        (1, constellation({0: 0.0, 2: 90.0}, heading=0)),
    )
    made.shrink(1)
    assert made.landmarks == 2
    places, scores, _ = ask(made, constellation({1: 90.0}, heading=0), k=1)
    assert (places, scores) == ([[0]], [[1.0]])
    assert ask(made, constellation({0: 0.0}, heading=0), k=1)[1] == [[0.0]]


def test_a_map_is_built_within_its_budget() -> None:
    run = [constellation(HERE, heading=0, index=0), constellation(THERE, heading=0, index=1)]
    for budget, kept in ((0, 6), (2, 4), (1, 2)):
        built = build_map(
            Placecell(variant(budget=budget, refractory=0)), run, advance=lambda done: None
        )
        assert len(built.memory.save()["triplets"]) == kept


def test_shrinking_prefers_what_was_seen_again() -> None:
    made = memory(
        PARAMS,
        (0, constellation(HERE, heading=0)),
        (0, constellation({1: 100.0}, heading=0)),
    )
    made.shrink(1)
    assert ask(made, constellation({1: 100.0}, heading=0), k=1)[1] == [[1.0]]


def test_a_saved_memory_answers_and_learns_on() -> None:
    params = variant(cells=0, heading="search", reuse=True)
    made = memory(params, (0, constellation(HERE)), (1, constellation(THERE)))
    other = Placecell(params).memory()
    other.load(made.save())
    for one in (made, other):
        one.learn(1, constellation({**THERE, 9: 20.0}))
    query = constellation(turned({**THERE, 9: 20.0}, 10.0))
    for mine, theirs in zip(ask(made, query), ask(other, query), strict=True):
        assert np.array_equal(mine, theirs, equal_nan=True)


def test_a_state_for_other_views_is_refused() -> None:
    state = memory(PARAMS, (0, constellation(HERE, heading=0))).save()
    other = Placecell(variant(patch_rows=5)).memory()
    with pytest.raises(StoreError, match="do not fit together"):
        other.load(state)


def test_a_state_that_names_landmarks_it_lacks_is_refused() -> None:
    state = dict(memory(PARAMS, (0, constellation(HERE, heading=0))).save())
    state["pixels"] = state["pixels"][:16]
    with pytest.raises(StoreError, match="build the map again"):
        Placecell(PARAMS).memory().load(state)


def test_similarity_is_symmetric_and_one_for_equal_places() -> None:
    system = Placecell(PARAMS)
    first, second = constellation(HERE, heading=0), constellation({0: 20.0}, heading=0)
    assert system.similarity(first, first) == 1.0
    assert system.similarity(first, second) == system.similarity(second, first)
    assert 0.0 < system.similarity(first, second) < 1.0
