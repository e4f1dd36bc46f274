"""Laser sweeps laid over each other, in a corridor with side rooms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.geometry import TAU, compose, relative
from fpnav.matching import sweep_kernels as kernels
from fpnav.matching.sweeps import (
    CELL_M,
    HALF_M,
    Sweep,
    inverted,
    overlaid,
    searched,
    turns_between,
)
from fpnav.values import FloatArray, Pose2

HERE = Pose2(3.0, 0.1, 0.2)
PLACES = (Pose2(3.6, -0.2, 0.5), Pose2(2.2, 0.4, -0.2), Pose2(4.0, 0.0, 0.0))


def sweep(pose: Pose2, fov_deg: float = 180.0) -> Sweep:
    beams = round(fov_deg)
    scan = small_world.scan(pose, beams, math.radians(fov_deg))
    return Sweep(scan.ranges_m.astype(np.float64), scan.angle_min_rad, scan.angle_increment_rad)


def laid(query: Sweep, other: Sweep, keep: int = 3):  # type: ignore[no-untyped-def]
    turns = turns_between(query, other, math.radians(60), math.radians(6))
    return overlaid(query, other, searched(query, other, turns, keep))


@pytest.mark.parametrize("fov_deg", [180.0, 360.0])
@pytest.mark.parametrize("there", PLACES)
def test_where_the_other_scan_was_taken_is_found(there: Pose2, fov_deg: float) -> None:
    found = laid(sweep(HERE, fov_deg), sweep(there, fov_deg))
    truth = relative(HERE, there)
    assert found.pose[0] == pytest.approx(truth.x_m, abs=0.05)
    assert found.pose[1] == pytest.approx(truth.y_m, abs=0.05)
    assert found.pose[2] == pytest.approx(truth.heading_rad, abs=math.radians(1.0))
    assert found.balance > 1.0


def test_full_circles_are_laid_over_each_other_at_any_heading() -> None:
    there = Pose2(3.3, 0.0, 0.2 + math.pi)
    found = laid(sweep(HERE, 360.0), sweep(there, 360.0))
    off = (found.pose[2] - relative(HERE, there).heading_rad + math.pi) % TAU - math.pi
    assert abs(off) < math.radians(1.0)
    assert found.balance > 1.0


def test_another_place_agrees_less_and_conflicts_more() -> None:
    here, same, other = sweep(HERE), sweep(PLACES[0]), sweep(Pose2(8.2, 0.0, 2.0))
    right, wrong = laid(here, same), laid(here, other)
    assert right.balance > wrong.balance + 0.2


def test_a_sweep_lies_upon_itself() -> None:
    here = sweep(HERE)
    found = laid(here, here)
    assert found.pose == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)
    assert found.forward[kernels.AGREE] == pytest.approx(1.0)
    assert found.forward[kernels.CONFLICT] == 0.0


def test_the_answer_is_the_same_every_time() -> None:
    first, second = (laid(sweep(HERE), sweep(PLACES[1])) for _ in range(2))
    assert first.pose.tobytes() == second.pose.tobytes()
    assert first.information.tobytes() == second.information.tobytes()


def test_inverting_twice_gives_the_pose_again() -> None:
    pose = np.array([0.4, -1.2, 0.7])
    assert inverted(inverted(pose)) == pytest.approx(pose)
    both = compose(Pose2(*pose), Pose2(*inverted(pose)))
    assert (both.x_m, both.y_m, both.heading_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_the_search_equals_every_overlay_tried_in_numpy() -> None:
    query, other = sweep(HERE), sweep(PLACES[0])
    _, coarse = query.fields
    turns = turns_between(query, other, math.radians(60), math.radians(6))
    found = np.empty((len(turns), 4))
    kernels.widest(coarse, 2 * CELL_M, HALF_M, *other.outline, turns, 2.0, 0.5, 1, found)
    points = np.column_stack(other.outline)
    for turn, row in zip(turns, found, strict=True):
        c, s = math.cos(turn), math.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        best = max(
            value(coarse, 2 * CELL_M, turned + 0.5 * np.array([a, b]))
            for a in range(-4, 5)
            for b in range(-4, 5)
            if a * a + b * b <= 17
        )
        assert row[0] == pytest.approx(
            best, abs=0.035
        )  # a point on a cell's edge may fall either way


def value(field: FloatArray, cell: float, points: FloatArray) -> float:
    cells = np.floor((points + HALF_M) / cell).astype(int)
    inside = ((cells >= 0) & (cells < len(field))).all(axis=1)
    return float(field[cells[inside, 0], cells[inside, 1]].sum() / len(points))


def test_beams_that_pass_through_what_the_other_saw_are_a_conflict() -> None:
    near = Sweep(np.full(180, 2.0), -np.pi / 2, np.pi / 180)
    far = Sweep(np.full(180, 4.0), -np.pi / 2, np.pi / 180)
    pose, out = np.zeros(3), np.zeros(5)
    frame = far.start_rad, far.step_rad, far.closed
    kernels.check(*far.points, far.ranges_m, *frame, *near.points, near.weights, pose, out)
    assert out[kernels.CONFLICT] == pytest.approx(1.0)
    kernels.check(*near.points, near.ranges_m, *frame, *far.points, far.weights, pose, out)
    assert out[kernels.HIDDEN] == pytest.approx(1.0)


def test_what_no_beam_looked_at_is_outside() -> None:
    ahead = Sweep(np.full(180, 2.0), -np.pi / 2, np.pi / 180)
    behind = Sweep(np.full(180, 2.0), np.pi / 2 + 0.1, np.pi / 180)
    out = np.zeros(5)
    kernels.check(
        *ahead.points, ahead.ranges_m, ahead.start_rad, ahead.step_rad, ahead.closed,
        *behind.points, behind.weights, np.zeros(3), out,
    )  # fmt: skip
    assert out[kernels.OUTSIDE] == pytest.approx(1.0, abs=0.12)
    assert out[kernels.CONFLICT] == 0.0


def test_normals_of_a_wall_point_across_it() -> None:
    bearings = -np.pi / 4 + np.deg2rad(np.arange(91.0))
    wall = Sweep(2.0 / np.cos(bearings), -np.pi / 4, np.pi / 180)
    assert np.abs(wall.normals[5:-5, 0]) == pytest.approx(np.ones(81), abs=1e-6)


def test_a_sweep_of_nothing_is_survived() -> None:
    nothing = Sweep(np.full(180, np.inf), -np.pi / 2, np.pi / 180)
    found = laid(sweep(HERE), nothing)
    assert found.pairs == 0
    assert np.isfinite(found.balance)
