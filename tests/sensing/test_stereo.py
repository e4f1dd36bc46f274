"""Distance of edges from two images side by side."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fpnav.sensing.cues import CUE
from fpnav.sensing.pairing import in_order
from fpnav.sensing.stereo import UNMATCHED, Rig, focal_px, pair_costs, with_distances

RIG = Rig(focal_px(math.radians(60.0)), 0.18)


def edge(
    x: float, top: float = 100, bottom: float = 299, direction: int = 1, strength: float = 1.0
) -> tuple[float, ...]:
    return (0, direction, x, top, bottom, strength, math.nan)


def cues(*rows: tuple[float, ...]) -> NDArray[np.void]:
    return np.array(list(rows), CUE)


def test_sixty_degrees_are_a_focal_length_of_415_7_pixels() -> None:
    assert focal_px(math.radians(60.0)) == pytest.approx(415.69, abs=0.01)


def test_two_metres_are_37_pixels() -> None:
    found = with_distances(cues(edge(240)), cues(edge(240 - 37.41)), RIG)
    assert found["distance_m"] == pytest.approx([2.0], abs=0.01)


def test_a_second_camera_on_the_left_sees_edges_shift_the_other_way() -> None:
    left = Rig(RIG.focal_px, RIG.baseline_m, second_right=False)
    assert np.isnan(with_distances(cues(edge(240)), cues(edge(203)), left)["distance_m"]).all()
    found = with_distances(cues(edge(240)), cues(edge(277)), left)
    assert found["distance_m"] == pytest.approx([2.02], abs=0.01)


@pytest.mark.parametrize(
    "other",
    [
        edge(203, direction=-1),
        edge(203, top=320, bottom=460),
        edge(203, top=100, bottom=170),
        edge(240.5),
        edge(70),
    ],
    ids=["direction", "height", "length", "nearer than infinity", "beyond the limit"],
)
def test_edges_that_cannot_be_one_have_no_distance(other: tuple[float, ...]) -> None:
    assert np.isnan(with_distances(cues(edge(240)), cues(other), RIG)["distance_m"]).all()


def test_partners_keep_their_order() -> None:
    first = cues(edge(200), edge(240))
    second = cues(edge(160), edge(210))
    found = with_distances(first, second, RIG)["distance_m"]
    expected = RIG.focal_px * 0.18 / np.array([40.0, 30.0])
    assert found == pytest.approx(expected, rel=1e-5)


def test_an_edge_has_one_partner_at_most() -> None:
    found = with_distances(cues(edge(240), edge(244)), cues(edge(203)), RIG)["distance_m"]
    assert np.isnan(found).sum() == 1


def test_the_cost_is_that_of_length_height_and_strength() -> None:
    first = cues(edge(240, 100, 299, strength=1.0))
    second = cues(edge(203, 120, 279, strength=0.5))
    cost = pair_costs(first, second, np.array([[37.0]]), (1.0, 160.0))
    assert cost[0, 0] == pytest.approx(0.5 * math.log(200 / 160) + 0.0 + 0.2 * 0.5)
    lower = cues(edge(203, 124, 323))
    assert pair_costs(first, lower, np.array([[37.0]]), (1.0, 160.0))[0, 0] == pytest.approx(0.1)


def test_nothing_has_no_distances() -> None:
    assert len(with_distances(cues(), cues(edge(203)), RIG)) == 0
    assert np.isnan(with_distances(cues(edge(240)), cues(), RIG)["distance_m"]).all()


def cheapest(cost: NDArray[np.float64], unmatched: float) -> float:
    """Least total over all order-preserving pairings, by trying them."""
    n, m = cost.shape
    best = (n + m) * unmatched
    for size in range(1, min(n, m) + 1):
        for rows in itertools.combinations(range(n), size):
            for columns in itertools.combinations(range(m), size):
                pairs = sum(cost[i, j] for i, j in zip(rows, columns, strict=True))
                best = min(best, pairs + (n + m - 2 * size) * unmatched)
    return best


@given(st.integers(0, 4), st.integers(0, 4), st.lists(st.floats(0, 2), min_size=16, max_size=16))
def test_the_pairing_is_the_cheapest_that_keeps_the_order(
    n: int, m: int, values: list[float]
) -> None:
    cost = np.array(values).reshape(4, 4)[:n, :m].copy()
    cost[cost > 1.5] = np.inf
    partner = in_order(cost, UNMATCHED)
    used = partner[partner >= 0]
    assert (np.diff(used) > 0).all()
    total = sum(cost[i, j] for i, j in enumerate(partner) if j >= 0)
    total += (n + m - 2 * len(used)) * UNMATCHED
    assert total == pytest.approx(cheapest(cost, UNMATCHED))
