"""Strings whose symbols carry bearing and range: the kernel against the recurrence written out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching.attributed import BAND, SYMBOL, Strings, Tolerance, ratios
from fpnav.values import FloatArray

TOLERANCE = Tolerance(np.deg2rad(15.0), (0.35, 0.5), 0.5)
TURNS = np.deg2rad(np.arange(-60.0, 61.0, 6.0))
AHEAD = np.array([0.0, np.pi])
ROUND = np.array([0.0, TAU])


def string(seed: int, count: int, half: float = np.pi / 2) -> NDArray[np.void]:
    rng = np.random.default_rng(seed)
    rows = np.zeros(count, SYMBOL)
    rows["angle_rad"] = np.sort(rng.uniform(-half, half, count))
    rows["log_range"] = rng.normal(1.0, 0.8, count)
    rows["weight"] = rng.uniform(0.2, 1.0, count)
    rows["kind"] = rng.integers(0, 2, count)
    return rows


def plainly(
    x: NDArray[np.void], arc_x: FloatArray, y: NDArray[np.void], arc_y: FloatArray, turn: float
) -> float:
    """Needleman and Wunsch over the whole table, no band, no tricks."""

    def on(rows: NDArray[np.void], turn: float, arc: FloatArray, moved: float) -> NDArray[np.void]:
        rows = rows.copy()
        rows["angle_rad"] = (rows["angle_rad"] + turn + np.pi) % TAU - np.pi
        off = np.abs((rows["angle_rad"] - arc[0] - moved + np.pi) % TAU - np.pi)
        return rows[off <= arc[1] / 2 + 1e-9][np.argsort(
            rows["angle_rad"][off <= arc[1] / 2 + 1e-9], kind="stable")]  # fmt: skip

    x, y = on(x, turn, arc_y, 0.0), on(y, 0.0, arc_x, turn)
    gaps = [TOLERANCE.gap * rows["weight"] for rows in (x, y)]
    table = np.zeros((len(x) + 1, len(y) + 1))
    table[1:, 0], table[0, 1:] = -np.cumsum(gaps[0]), -np.cumsum(gaps[1])
    for i, a in enumerate(x):
        for j, b in enumerate(y):
            best = max(table[i, j + 1] - gaps[0][i], table[i + 1, j] - gaps[1][j])
            off = (a["angle_rad"] - b["angle_rad"]) / TOLERANCE.angle_rad
            if a["kind"] == b["kind"] and abs(off) <= BAND:
                far = (a["log_range"] - b["log_range"]) / TOLERANCE.log_range[a["kind"]]
                weight = 0.5 * (a["weight"] + b["weight"])
                best = max(best, table[i, j] + weight * (1.0 - off * off - far * far))
            table[i + 1, j + 1] = best
    total = x["weight"].sum() + y["weight"].sum()
    return float(table[-1, -1] / (0.5 * total)) if total else 0.0


@pytest.mark.parametrize("arc", [AHEAD, ROUND], ids=["half", "round"])
@pytest.mark.parametrize("seed", range(6))
def test_the_kernel_equals_the_recurrence_written_out(seed: int, arc: FloatArray) -> None:
    half = arc[1] / 2
    rows = [string(seed * 10 + k, 3 + 4 * k, half) for k in range(5)]
    one, many = Strings.of(rows[:1], [arc]), Strings.of(rows, [arc] * 5)
    scores, turns = ratios(one, many, np.arange(5), TURNS, TOLERANCE)
    for k in range(5):
        expected = [plainly(rows[0], arc, rows[k], arc, turn) for turn in TURNS]
        assert scores[k] == pytest.approx(max(expected), abs=1e-12)
        assert expected[int(np.argmin(np.abs(TURNS - turns[k])))] == pytest.approx(
            max(expected), abs=1e-12
        )


def test_equal_strings_are_worth_one_without_a_turn() -> None:
    one = Strings.of([string(1, 20)], [AHEAD])
    scores, turns = ratios(one, one, np.zeros(1, np.int64), TURNS, TOLERANCE)
    assert scores[0] == pytest.approx(1.0)
    assert turns[0] == pytest.approx(0.0)


def test_the_turn_is_that_of_the_query_against_the_other() -> None:
    rows = string(2, 30, np.pi)
    seen = rows.copy()  # the query's robot looks 30 degrees further left: all moves right
    seen["angle_rad"] = (rows["angle_rad"] - np.deg2rad(30.0) + np.pi) % TAU - np.pi
    seen = seen[np.argsort(seen["angle_rad"])]
    query, other = Strings.of([seen], [ROUND]), Strings.of([rows], [ROUND])
    scores, turns = ratios(query, other, np.zeros(1, np.int64), TURNS, TOLERANCE)
    assert scores[0] == pytest.approx(1.0)
    assert np.rad2deg(turns[0]) == pytest.approx(30.0)


def test_ranges_tell_apart_what_looks_alike_by_bearing() -> None:
    near, far = string(3, 12), string(3, 12)
    far["log_range"] += 0.7
    one, both = Strings.of([near], [AHEAD]), Strings.of([near, far], [AHEAD, AHEAD])
    scores, _ = ratios(one, both, np.arange(2), TURNS, TOLERANCE)
    assert scores[0] == pytest.approx(1.0)
    assert scores[1] < 0.0


def test_what_the_other_sensor_could_not_see_costs_nothing() -> None:
    rows = string(4, 24, np.pi)
    part = rows[np.abs(rows["angle_rad"]) <= np.pi / 2]
    scores, _ = ratios(
        Strings.of([part], [AHEAD]), Strings.of([rows], [ROUND]),
        np.zeros(1, np.int64), np.zeros(1), TOLERANCE,
    )  # fmt: skip
    assert scores[0] == pytest.approx(1.0)


def test_nothing_against_nothing_is_worth_nothing() -> None:
    empty = Strings.of([np.zeros(0, SYMBOL)], [AHEAD])
    scores, _ = ratios(empty, empty, np.zeros(1, np.int64), TURNS, TOLERANCE)
    assert scores.tolist() == [0.0]
