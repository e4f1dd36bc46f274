"""Members, extents, lengths and bearings in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from helpers.toy_system import Toy, one_hot, signature_of

from fpnav.mapping.places import learned, make_edges, make_places, runs_of
from fpnav.topomap.graph import Edge
from fpnav.values import Pose2, Reference, Signature

LEFT, BACK = math.pi / 2, -math.pi


def at(
    x: float,
    y: float,
    heading: float,
    travelled: float,
    *,
    session: int = 0,
    truth: Pose2 | None = None,
    odometry: bool = True,
    label: str = "",
) -> Signature:
    pose = Pose2(x, y, heading)
    return signature_of(
        Reference(
            index=0,
            stamp_ns=0,
            session=session,
            travelled_m=travelled,
            odometry=pose if odometry else None,
            truth=truth,
            label=label,
        ),
        one_hot(0),
    )


def corner(session: int = 0) -> list[Signature]:
    """Three steps along x, then a left turn and three along y: places A and B."""
    ahead = [at(x, 0.0, 0.0, x, session=session) for x in (0.0, 1.0, 2.0)]
    up = [at(2.0, y, LEFT, 2.0 + y, session=session) for y in (1.0, 2.0, 3.0)]
    return ahead + up


def back_again() -> list[Signature]:
    """From B, turned round, down to A once more by a way that is 0.5 m longer."""
    down = [at(2.0, 2.0, -LEFT, 6.5), at(2.0, 1.0, -LEFT, 7.5)]
    return [*down, at(2.0, 0.0, -LEFT, 8.5), at(1.0, 0.0, BACK, 9.5)]


def edges_of(signatures: list[Signature], owner: Sequence[int]) -> list[Edge]:
    return make_edges(signatures, np.array(owner))


def test_stays_end_where_the_owner_or_the_session_changes() -> None:
    references = [row.reference for row in corner() + corner(session=1)]
    owner = np.array([0, 0, 0, 1, 1, 1, 1, 0, 0, 1, 1, 1])
    stays = [stay.tolist() for stay in runs_of(references, owner)]
    assert stays == [[0, 1, 2], [3, 4, 5], [6], [7, 8], [9, 10, 11]]


def test_an_edge_leads_between_middle_members_with_bearings_in_the_frame_of_each_place() -> None:
    (edge,) = edges_of(corner(), [0, 0, 0, 1, 1, 1])
    assert (edge.source, edge.target, edge.count) == (0, 1, 1)
    assert edge.length_m == pytest.approx(3.0)  # from (1, 0) over (2, 0) to (2, 2)
    assert edge.bearing_out_rad == pytest.approx(LEFT)  # B lies to the left of A's first heading
    assert edge.bearing_in_rad == pytest.approx(BACK)  # seen from B, one came from behind


def test_bearings_do_not_depend_on_where_odometry_began() -> None:
    turned = [
        at(5.0 - s.reference.odometry.y_m, 7.0 + s.reference.odometry.x_m,
           s.reference.odometry.heading_rad + LEFT, s.reference.travelled_m)
        for s in corner() if s.reference.odometry is not None
    ]  # fmt: skip
    (edge,) = edges_of(turned, [0, 0, 0, 1, 1, 1])
    assert edge.bearing_out_rad == pytest.approx(LEFT)
    assert edge.bearing_in_rad == pytest.approx(BACK)


def test_the_way_back_is_an_edge_of_its_own_in_the_frames_of_the_first_visits() -> None:
    there, back = edges_of(corner() + back_again(), [0, 0, 0, 1, 1, 1, 1, 1, 0, 0])
    assert (there.source, there.target) == (0, 1)
    assert (back.source, back.target) == (1, 0)
    assert back.bearing_out_rad == pytest.approx(BACK)  # B was first seen heading up: down is rear
    assert back.bearing_in_rad == pytest.approx(LEFT)  # A was first seen heading along x
    # B's stay is rows 3..7, its middle row 5 at 5.0 m; A's is rows 8, 9, its middle row 9 at 9.5 m
    assert back.length_m == pytest.approx(4.5)


def test_an_edge_travelled_twice_has_the_mean_length_and_the_first_bearings() -> None:
    rows = [at(x, 0.0, 0.0, t) for x, t in ((0, 0.0), (1, 1.0), (0, 2.5), (1, 5.5))]
    there, back = edges_of(rows, [0, 1, 0, 1])
    assert (there.count, back.count) == (2, 1)
    assert there.length_m == pytest.approx((1.0 + 3.0) / 2)
    assert there.bearing_out_rad == pytest.approx(0.0)


def test_sessions_are_not_joined_by_an_edge() -> None:
    rows = corner() + corner(session=1)
    edges = edges_of(rows, [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3])
    assert [(edge.source, edge.target) for edge in edges] == [(0, 1), (2, 3)]
    assert edges[1].bearing_out_rad == pytest.approx(LEFT)


def test_a_stay_over_a_session_border_counts_as_two() -> None:
    rows = corner() + corner(session=1)[3:] + back_again()[2:]
    owner = [0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 0]
    (edge,) = edges_of(rows[:9], owner[:9])
    assert edge.length_m == pytest.approx(3.0)


def test_bearings_in_the_odometry_of_another_session_are_unknown_until_known() -> None:
    second = [at(0.0, 9.0, 1.0, 0.0, session=1), at(0.0, 8.0, 1.0, 1.0, session=1)]
    edges = edges_of(corner() + second, [0, 0, 0, 1, 1, 1, 1, 0])
    assert math.isnan(edges[1].bearing_out_rad)
    assert math.isnan(edges[1].bearing_in_rad)
    assert edges[1].length_m == pytest.approx(1.0)
    both = edges_of(corner() + second, [0, 0, 0, 1, 1, 1, 0, 1])
    assert both[0].count == 2
    assert both[0].bearing_out_rad == pytest.approx(LEFT)


def test_without_odometry_truth_gives_the_bearings_and_the_two_are_never_mixed() -> None:
    truth = [Pose2(9.0, 9.0, 0.0), Pose2(9.0, 10.0, 0.0)]
    rows = [at(0.0, 0.0, 0.0, t, truth=pose, odometry=False) for t, pose in enumerate(truth)]
    assert edges_of(rows, [0, 1])[0].bearing_out_rad == pytest.approx(LEFT)
    half = [at(0.0, 0.0, 0.0, 0.0), rows[1]]
    assert math.isnan(edges_of(half, [0, 1])[0].bearing_out_rad)


def test_without_any_pose_bearings_are_unknown_and_lengths_zero() -> None:
    rows = [at(0.0, 0.0, 0.0, math.nan, odometry=False) for _ in range(2)]
    (edge,) = edges_of(rows, [0, 1])
    assert math.isnan(edge.bearing_out_rad)
    assert edge.length_m == 0.0


def test_a_turn_on_the_spot_has_no_bearing() -> None:
    rows = [at(1.0, 1.0, 0.0, 1.0), at(1.0, 1.0, LEFT, 1.0)]
    assert math.isnan(edges_of(rows, [0, 1])[0].bearing_out_rad)


def test_places_have_members_in_travel_order_and_the_extent_of_a_mean_stay() -> None:
    places = make_places(corner() + back_again(), np.array([0, 0, 0, 1, 1, 1, 1, 1, 0, 0]))
    assert [place.id for place in places] == [0, 1]
    assert places[0].members == (0, 1, 2, 8, 9)
    assert places[1].members == (3, 4, 5, 6, 7)
    assert places[0].extent_m == pytest.approx((2.0 + 1.0) / 2)
    assert places[1].extent_m == pytest.approx(7.5 - 3.0)


def test_an_extent_does_not_reach_from_one_session_into_the_next() -> None:
    rows = [*corner()[:3], *corner(session=1)[:2]]
    (place,) = make_places(rows, np.zeros(5, dtype=np.int64))
    assert place.extent_m == pytest.approx((2.0 + 1.0) / 2)


def test_a_place_bears_the_first_label_of_its_members() -> None:
    rows = [at(0, 0, 0, 0), at(0, 0, 0, 0, label="hall"), at(0, 0, 0, 0, label="lab")]
    (place,) = make_places(rows, np.zeros(3, dtype=np.int64))
    assert place.label == "hall"


def test_the_memory_learns_every_signature_at_its_place() -> None:
    memory = learned(Toy(), corner(), np.array([0, 0, 0, 4, 4, 4]))
    assert memory.places.tolist() == [0, 4]
    assert memory.save()["counts"].tolist() == [3, 3]
