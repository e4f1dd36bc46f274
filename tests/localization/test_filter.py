"""Belief over places against enumeration, hmmlearn and closed forms."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.localization.filter import (
    FilterParams,
    Step,
    Transitions,
    entropy,
    filter_belief,
    make_steps,
    most_likely_path,
    smooth_belief,
)
from fpnav.topomap.graph import Edge, TopoMap
from fpnav.values import FloatArray, Place, Reference

Case = tuple[FloatArray, list[Step]]

PARAMS = FilterParams(kidnap=0.01)
UNKNOWN = math.nan


def edge(source: int, target: int, out: float = UNKNOWN, back: float = UNKNOWN) -> Edge:
    return Edge(source, target, 1.0, out, back)


def topomap(places: int, edges: list[Edge], extent_m: float = 2.0) -> TopoMap:
    return TopoMap.of([Place(i, (i,), extent_m) for i in range(places)], edges)


def junction() -> TopoMap:
    """Place 1 with 0 behind, 2 ahead and 3 to the left; 3 was only travelled towards 1."""
    return topomap(
        4,
        [
            edge(0, 1, 0.0, -math.pi),
            edge(1, 2, 0.0, -math.pi),
            edge(3, 1, math.pi / 2, math.pi / 2),
        ],
    )


def drive(steps_m: list[float], session: int = 0) -> list[Reference]:
    travelled = np.concatenate([[0.0], np.cumsum(steps_m)])
    return [Reference(i, i, session, travelled_m=float(t)) for i, t in enumerate(travelled)]


def steps_of(net: Transitions, references: list[Reference], heading: float = UNKNOWN) -> list[Step]:
    return make_steps(net, references, np.full((len(references), len(net)), heading))


def one_step(graph: TopoMap, params: FilterParams, *, d: float = 1.0, heading: float = 0.0) -> Step:
    return steps_of(Transitions.of(graph, params), drive([d]), heading)[0]


def matrix(step: Step) -> FloatArray:
    """T[s, s'] of a step, by pushing unit beliefs through it."""
    return np.array([step.forward(row) for row in np.eye(len(step.transitions))])


def enumerated(likelihood: FloatArray, matrices: list[FloatArray]) -> dict[tuple[int, ...], float]:
    """Joint probability of every path of places and the observations."""
    queries, places = likelihood.shape
    joint = {}
    for path in product(range(places), repeat=queries):
        value = likelihood[0, path[0]] / places
        for t, (a, b) in enumerate(pairwise(path)):
            value *= matrices[t][a, b] * likelihood[t + 1, b]
        joint[path] = float(value)
    return joint


@pytest.fixture(scope="module")
def four_by_six() -> Case:
    rng = np.random.default_rng(7)
    net = Transitions.of(junction(), PARAMS)
    headings = rng.uniform(-3, 3, (6, 4))
    headings[2, 1] = UNKNOWN
    return rng.uniform(0.05, 1.0, (6, 4)), make_steps(
        net, drive([0.3, 1.0, 0.0, 2.0, 5.0]), headings
    )


def test_transitions_follow_the_formula_of_the_specification() -> None:
    step = one_step(junction(), FilterParams(kidnap=0.01, kappa=2.0), d=0.5, heading=0.3)
    leave = 1.0 - math.exp(-0.5 / 2.0)
    pull = {0: math.exp(2 * math.cos(math.pi + 0.3)), 2: math.exp(2 * math.cos(-0.3))}
    pull[3] = math.exp(2 * math.cos(math.pi / 2 - 0.3))
    row = np.array([0.99 * leave * pull.get(s, 0.0) / sum(pull.values()) for s in range(4)])
    row[1] = 0.99 * (1.0 - leave)
    assert matrix(step)[1] == pytest.approx(row + 0.01 / 4)


@given(
    st.floats(0.0, 20.0),
    st.floats(-4.0, 4.0) | st.just(UNKNOWN),
    st.floats(0.0, 1.0),
    st.floats(0.0, 100.0),
)
def test_rows_of_the_transition_matrix_sum_to_one(
    step_m: float, heading: float, kidnap: float, kappa: float
) -> None:
    islands = TopoMap.of(
        [Place(i, (i,), 0.0) for i in range(5)], [edge(0, 1, 0.5, 2.0), edge(2, 1)]
    )
    step = one_step(islands, FilterParams(kidnap=kidnap, kappa=kappa), d=step_m, heading=heading)
    assert matrix(step).sum(axis=1) == pytest.approx(np.ones(5))
    assert (matrix(step) >= 0).all()


def test_the_way_back_of_an_edge_can_be_taken_along_the_bearing_one_came_from() -> None:
    net = Transitions.of(junction(), PARAMS)
    arcs = dict(
        zip(
            zip(net.source.tolist(), net.target.tolist(), strict=True), net.bearing_rad, strict=True
        )
    )
    assert arcs == {
        (0, 1): 0.0, (1, 0): -math.pi, (1, 2): 0.0,
        (2, 1): -math.pi, (3, 1): math.pi / 2, (1, 3): math.pi / 2,
    }  # fmt: skip


def test_a_way_travelled_both_ways_keeps_the_bearings_of_setting_out() -> None:
    net = Transitions.of(topomap(2, [edge(0, 1, 0.1, 0.2), edge(1, 0, 0.3, 0.4)]), PARAMS)
    assert net.bearing_rad.tolist() == [0.1, 0.3]


def test_a_robot_is_pulled_where_it_heads() -> None:
    for heading, ahead in ((0.0, 2), (math.pi, 0), (math.pi / 2, 3)):
        moved = matrix(one_step(junction(), PARAMS, heading=heading))[1]
        assert int(np.argmax(moved[[0, 2, 3]])) == [0, 2, 3].index(ahead)


def test_without_a_heading_or_with_kappa_zero_all_neighbours_are_alike() -> None:
    for step in (
        one_step(junction(), PARAMS, heading=UNKNOWN),
        one_step(junction(), FilterParams(kappa=0.0), heading=0.7),
    ):
        assert np.ptp(matrix(step)[1, [0, 2, 3]]) == pytest.approx(0.0)


def test_a_place_is_left_the_sooner_the_farther_one_drives() -> None:
    net = Transitions.of(junction(), FilterParams(leave_min=0.1, leave_max=0.6))
    assert net.leaving(0.0).tolist() == [0.1] * 4
    assert net.leaving(1.0) == pytest.approx([1 - math.exp(-0.5)] * 4)
    assert net.leaving(50.0).tolist() == [0.6] * 4


def test_a_place_without_neighbours_is_never_left() -> None:
    net = Transitions.of(topomap(2, []), PARAMS)
    assert net.leaving(5.0).tolist() == [0.0, 0.0]


def test_where_odometry_gave_no_extent_a_place_is_as_long_as_its_signatures() -> None:
    places = [Place(0, (0, 1, 2, 3), 0.0), Place(1, (4,), 0.0)]
    net = Transitions.of(TopoMap.of(places, [edge(0, 1)]), FilterParams(mean_step_m=0.5))
    assert net.extent_m.tolist() == [2.0, 0.5]
    (step,) = steps_of(net, [Reference(0, 0), Reference(1, 1)])
    assert step.leave == pytest.approx([1 - math.exp(-0.25), 1 - math.exp(-1.0)], abs=1e-12)


def test_across_sessions_the_robot_may_be_anywhere() -> None:
    net = Transitions.of(junction(), PARAMS)
    (step,) = steps_of(net, [drive([])[0], drive([], session=1)[0]])
    assert matrix(step) == pytest.approx(np.full((4, 4), 0.25))


def test_belief_sums_to_one_and_starts_from_the_uniform(four_by_six: Case) -> None:
    likelihood, steps = four_by_six
    for belief in (filter_belief(likelihood, steps), smooth_belief(likelihood, steps)):
        assert belief.sum(axis=1) == pytest.approx(np.ones(6))
    first = filter_belief(likelihood, steps)[0]
    assert first == pytest.approx(likelihood[0] / likelihood[0].sum())


def test_a_uniform_observation_leaves_the_predicted_prior(four_by_six: Case) -> None:
    likelihood, steps = four_by_six
    likelihood = likelihood.copy()
    likelihood[3] = 0.4
    belief = filter_belief(likelihood, steps)
    assert belief[3] == pytest.approx(steps[2].forward(belief[2]))


def test_an_observation_that_nothing_explains_leaves_an_even_belief() -> None:
    net = Transitions.of(junction(), FilterParams(kidnap=0.0))
    steps = steps_of(net, drive([1.0, 1.0]))
    likelihood = np.ones((3, 4))
    likelihood[1] = 0.0
    assert filter_belief(likelihood, steps)[1].tolist() == [0.25] * 4
    assert np.isfinite(smooth_belief(likelihood, steps)).all()
    assert len(most_likely_path(likelihood, steps)) == 3


def test_filter_smoother_and_path_equal_enumeration(four_by_six: Case) -> None:
    likelihood, steps = four_by_six
    matrices = [matrix(step) for step in steps]
    filtered, smoothed = filter_belief(likelihood, steps), smooth_belief(likelihood, steps)
    for t in range(6):
        joint = enumerated(likelihood[: t + 1], matrices[:t])
        marginal = np.zeros(4)
        for path, value in joint.items():
            marginal[path[-1]] += value
        assert filtered[t] == pytest.approx(marginal / marginal.sum())
    joint = enumerated(likelihood, matrices)
    marginals = np.zeros((6, 4))
    for path, value in joint.items():
        marginals[np.arange(6), list(path)] += value
    assert smoothed == pytest.approx(marginals / marginals.sum(axis=1, keepdims=True))
    assert tuple(most_likely_path(likelihood, steps)) == max(joint, key=lambda path: joint[path])


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-3, 0.3, 1.0]))
def test_the_most_likely_path_is_the_best_of_all_paths(seed: int, kidnap: float) -> None:
    rng = np.random.default_rng(seed)
    edges = [edge(a, b, rng.uniform(-3, 3)) for a in range(4) for b in range(4) if a != b]
    graph = topomap(4, [e for e in edges if rng.random() < 0.4])
    net = Transitions.of(graph, FilterParams(kidnap=kidnap))
    steps = make_steps(net, drive(rng.uniform(0, 3, 3).tolist()), rng.uniform(-3, 3, (4, 4)))
    likelihood = rng.choice([0.1, 0.5, 1.0], (4, 4))
    joint = enumerated(likelihood, [matrix(step) for step in steps])
    path = tuple(most_likely_path(likelihood, steps).tolist())
    assert joint[path] == pytest.approx(max(joint.values()))


def test_ties_go_to_the_lowest_place() -> None:
    net = Transitions.of(topomap(3, [edge(0, 1), edge(2, 1)]), FilterParams(kidnap=0.0))
    steps = steps_of(net, drive([50.0]))
    likelihood = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    assert most_likely_path(likelihood, steps).tolist() == [0, 1]


def test_filter_and_path_equal_hmmlearn_on_static_transitions() -> None:
    hmm = pytest.importorskip("hmmlearn.hmm")
    rng = np.random.default_rng(3)
    step = one_step(junction(), PARAMS, d=0.7, heading=UNKNOWN)
    model = hmm.CategoricalHMM(n_components=4, init_params="", params="")
    model.startprob_ = np.full(4, 0.25)
    model.transmat_ = matrix(step)
    model.emissionprob_ = rng.dirichlet(np.ones(5), 4)
    model.n_features = 5
    seen = rng.integers(0, 5, 40)
    likelihood = model.emissionprob_[:, seen].T
    steps = [step] * 39
    assert smooth_belief(likelihood, steps) == pytest.approx(
        model.predict_proba(seen.reshape(-1, 1))
    )
    assert (
        most_likely_path(likelihood, steps).tolist() == model.predict(seen.reshape(-1, 1)).tolist()
    )


def corridor(places: int) -> TopoMap:
    return topomap(places, [edge(i, i + 1, 0.0, -math.pi) for i in range(places - 1)], 1.0)


def observed(path: list[int], places: int, contrast: float = 5.0) -> FloatArray:
    likelihood = np.full((len(path), places), 1.0 / contrast)
    likelihood[np.arange(len(path)), path] = 1.0
    return likelihood


def test_a_kidnapped_robot_is_found_again_and_without_kidnapping_it_is_not() -> None:
    path = [0] * 30 + [19] * 12
    likelihood = observed(path, 20)
    found = {}
    for kidnap in (0.0, 1e-3):
        net = Transitions.of(corridor(20), FilterParams(kidnap=kidnap, leave_min=0.0))
        belief = filter_belief(likelihood, steps_of(net, drive([0.0] * 41)))
        assert int(np.argmax(belief[29])) == 0
        found[kidnap] = np.argmax(belief[30:], axis=1) == 19
    # the jump costs 1e-3 / 20; each observation wins back 5 : 1, so seven of them suffice
    assert found[1e-3][7:].all()
    assert not found[0.0].any()


def test_the_smoother_knows_the_start_that_the_filter_could_not() -> None:
    ring = topomap(5, [edge(i, (i + 1) % 5, 0.0, -math.pi) for i in range(5)])
    net = Transitions.of(ring, FilterParams(leave_min=0.9, kappa=20.0))
    steps = steps_of(net, drive([1.0] * 3), heading=0.0)
    likelihood = np.ones((4, 5))
    likelihood[3] = [0.01, 0.01, 0.01, 0.01, 1.0]
    assert np.ptp(filter_belief(likelihood, steps)[0]) == pytest.approx(0.0)
    assert np.argmax(smooth_belief(likelihood, steps), axis=1).tolist() == [1, 2, 3, 4]


def test_a_scale_of_the_likelihood_changes_nothing(four_by_six: Case) -> None:
    likelihood, steps = four_by_six
    assert smooth_belief(likelihood * 1e-9, steps) == pytest.approx(
        smooth_belief(likelihood, steps)
    )


def test_a_run_of_one_or_no_query_is_answered() -> None:
    assert smooth_belief(np.ones((1, 4)), []).tolist() == [[0.25] * 4]
    assert filter_belief(np.ones((0, 4)), []).shape == (0, 4)
    assert most_likely_path(np.ones((0, 4)), []).tolist() == []


def test_entropy_is_zero_when_sure_and_log_of_the_places_when_not() -> None:
    belief = np.array([[1.0, 0.0, 0.0, 0.0], [0.25] * 4, [0.5, 0.5, 0.0, 0.0]])
    assert entropy(belief) == pytest.approx([0.0, math.log(4), math.log(2)])


def test_a_thousand_queries_on_a_thousand_places_are_quick() -> None:
    rng = np.random.default_rng(0)
    net = Transitions.of(corridor(1000), PARAMS)
    steps = make_steps(net, drive([0.5] * 999), rng.uniform(-3, 3, (1000, 1000)))
    likelihood = rng.uniform(0.1, 1.0, (1000, 1000))
    assert smooth_belief(likelihood, steps).sum() == pytest.approx(1000.0)
    assert len(most_likely_path(likelihood, steps)) == 1000
