"""Gateways found against those there are, and places told by likelihoods."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.evaluation.gateways import (
    Gateways,
    Survey,
    confusion,
    error_corrected,
    errors_m,
    gateway_found,
    gateway_invented,
    gateway_type_accuracy,
    gateway_within_3_5deg,
    gateway_within_70mm,
    gateways_met,
    lap_period,
    least_margin,
    surveyed,
    told_apart,
)

Row = tuple[float, float, float, str]


def gateways(*rows: Row) -> Gateways:
    poses = np.array([row[:3] for row in rows], dtype=np.float64).reshape(-1, 3)
    return Gateways(poses, tuple(row[3] for row in rows), ("",) * len(rows))


NORTH = math.pi / 2
TRUTH = gateways((5, 0, 0, "CROSS"), (9, 0, 0, "T-SHAPE"), (9, 5, NORTH, "LEFT TURN"))


def survey(*rows: Row) -> Survey:
    return surveyed(gateways(*rows), TRUTH)


def test_errors_are_measured_along_the_way_and_of_its_direction() -> None:
    found = survey((5.06, 0.5, 0.02, "CROSS"), (9.3, 4.92, NORTH - 0.1, "LEFT TURN"))
    assert found.partner.tolist() == [0, 2]
    assert found.along_m == pytest.approx([0.06, -0.08])
    assert found.turned_rad == pytest.approx([0.02, -0.1])
    assert gateway_found([found]).n == 2
    assert gateway_found([found]).of == 3
    assert gateway_within_70mm([found]).value == 0.5
    assert gateway_within_3_5deg([found]).value == 0.5
    assert gateway_type_accuracy([found]).value == 1.0


def test_a_gateway_far_off_on_another_way_or_found_twice_is_invented() -> None:
    far, aside, twice = (7, 0, 0, "CROSS"), (5, 0, NORTH, "CROSS"), (5.3, 0, 0, "CROSS")
    found = survey((5.1, 0, 0, "CROSS"), far, aside, twice)
    assert found.partner.tolist() == [0, -1, -1, -1]
    assert np.isnan(found.along_m[1:]).all()
    assert (gateway_invented([found]).n, gateway_invented([found]).of) == (3, 4)
    assert errors_m([found]) == pytest.approx([0.1])


def test_nothing_found_counts_as_missed() -> None:
    found = survey()
    assert gateway_found([found, survey((9, 0, 0, "CROSS"))]).value == pytest.approx(1 / 6)
    assert math.isnan(gateway_type_accuracy([found]).value)


def test_the_confusion_table_counts_every_gateway_once() -> None:
    table = confusion([survey((5, 0, 0, "CROSS"), (9, 0, 0, "CROSS"))], sorted(TRUTH.types))
    assert table.tolist() == [[1, 0, 0, 0], [0, 0, 0, 1], [1, 0, 0, 0]]
    assert table.sum() == len(TRUTH)


def test_a_gateway_without_a_type_is_found_and_classified_as_none() -> None:
    table = confusion([survey((5, 0, 0, ""))], sorted(TRUTH.types))
    assert table[0].tolist() == [0, 0, 0, 1]


def test_the_gateways_of_one_route_are_read_from_the_world() -> None:
    base = {"y_m": 1.0, "axis_rad": 0.0, "type": "CROSS", "opens_m": -1, "closes_m": 1}
    world = {
        "gateways": [
            {**base, "name": "A", "route": "route-1", "x_m": 2.0},
            {**base, "name": "B", "route": "route-2", "x_m": 3.0},
        ]
    }
    met = gateways_met(world, "route-2")
    assert (met.names, met.poses.tolist()) == (("B",), [[3.0, 1.0, 0.0]])


def test_a_tie_is_no_answer() -> None:
    table = np.array([[0.5, 0.5, 0.0], [0.2, 0.6, 0.2], [0.0, 0.0, 0.0]])
    told = told_apart("both", table, np.arange(3))
    assert (told.n, told.of) == (1, 3)


def test_the_margin_is_that_of_the_least_clear_place() -> None:
    table = np.array([[0.6, 0.3, 0.1], [0.2, 0.5, 0.3]])
    assert least_margin("m", table, np.array([0, 1])).value == pytest.approx(5 / 3)


def test_a_misread_gateway_is_corrected_where_its_place_stays_ahead() -> None:
    assert error_corrected(np.array([0.13, 0.42, 0.25]), 1).value == 1.0
    assert error_corrected(np.array([0.13, 0.25, 0.42]), 1).value == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_the_lap_is_found_in_a_sequence_with_misses_inventions_and_jitter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds, places = rng.integers(0, 4, 7), np.sort(rng.uniform(0, 1, 7))
    rows = [(lap + p, k) for lap in range(5) for p, k in zip(places, kinds, strict=True)]
    rows = [row for row in rows if rng.random() > 0.15]
    rows += [(float(rng.uniform(0, 5)), int(rng.integers(0, 4))) for _ in range(4)]
    rows.sort()
    at = 900.0 * np.array([row[0] for row in rows]) + rng.normal(0.0, 10.0, len(rows)).cumsum() / 9
    types = np.array([row[1] for row in rows])
    found = lap_period(np.sort(at), (types[:, None] == types[None, :]).astype(float), 200.0)
    assert found == pytest.approx(900.0, rel=0.03)


def test_one_gateway_makes_no_lap() -> None:
    assert math.isnan(lap_period(np.array([3.0]), np.ones((1, 1)), 1.0))
