"""Coming back the way one went joins the place one came from, where odometry agrees."""

from __future__ import annotations

import numpy as np
from helpers.toy_system import Toy, one_hot, signature_of
from numpy.typing import NDArray

from fpnav.mapping.returns import merge_returns
from fpnav.values import Pose2, Reference, Signature


def seen(
    row: int, x_m: float, looks: int, *, travelled_m: float, odometry: bool = True
) -> Signature:
    pose = Pose2(x_m, 0.0, 0.0) if odometry else None
    return signature_of(
        Reference(index=row, stamp_ns=row, travelled_m=travelled_m, odometry=pose), one_hot(looks)
    )


def there_and_back(*, slip_m: float = 0.0, odometry: bool = True) -> list[Signature]:
    """Corridor (looks 0), office (1), corridor again, two signatures each, a metre apart."""
    way = [(0.0, 0), (1.0, 0), (2.0, 1), (3.0, 1), (1.0 + slip_m, 0), (0.0 + slip_m, 0)]
    return [
        seen(row, x, looks, travelled_m=float(row), odometry=odometry)
        for row, (x, looks) in enumerate(way)
    ]


def merged(
    signatures: list[Signature], owner: list[int], *, reach_m: float = 0.5, drift: float = 0.05
) -> list[int]:
    rows: NDArray[np.int64] = np.array(owner, dtype=np.int64)
    out = merge_returns(Toy(), signatures, rows, 0.5, reach_m=reach_m, drift=drift)
    assert rows.tolist() == owner
    return out.tolist()


def test_the_way_out_of_an_office_is_the_way_in() -> None:
    assert merged(there_and_back(), [0, 0, 1, 1, 2, 2]) == [0, 0, 1, 1, 0, 0]


def test_a_place_that_looks_the_same_but_lies_elsewhere_is_another() -> None:
    assert merged(there_and_back(slip_m=4.0), [0, 0, 1, 1, 2, 2]) == [0, 0, 1, 1, 2, 2]


def test_drift_over_the_path_between_is_allowed_for() -> None:
    slipped = there_and_back(slip_m=2.0)
    assert merged(slipped, [0, 0, 1, 1, 2, 2], drift=0.6) == [0, 0, 1, 1, 0, 0]


def test_a_place_that_looks_different_is_another() -> None:
    way = there_and_back()[:4]
    way += [seen(4, 1.0, 5, travelled_m=4.0), seen(5, 0.0, 5, travelled_m=5.0)]
    assert merged(way, [0, 0, 1, 1, 2, 2]) == [0, 0, 1, 1, 2, 2]


def test_without_odometry_nothing_returns() -> None:
    assert merged(there_and_back(odometry=False), [0, 0, 1, 1, 2, 2]) == [0, 0, 1, 1, 2, 2]


def test_a_long_way_back_is_merged_place_by_place() -> None:
    looks = [0, 1, 2, 3, 2, 1, 0]
    where = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0]
    way = [
        seen(row, x, look, travelled_m=float(row))
        for row, (x, look) in enumerate(zip(where, looks, strict=True))
    ]
    assert merged(way, list(range(7))) == [0, 1, 2, 3, 2, 1, 0]


def test_part_of_a_stay_returns_and_the_rest_stays() -> None:
    looks = [0, 0, 0, 1, 1, 1, 1, 0, 0]
    where = [0.0, 1.0, 2.0, 3.0, 4.0, 4.5, 3.0, 2.0, 1.0]
    way = [
        seen(row, x, look, travelled_m=float(row))
        for row, (x, look) in enumerate(zip(where, looks, strict=True))
    ]
    assert merged(way, [0, 0, 0, 1, 1, 1, 2, 2, 2]) == [0, 0, 0, 1, 1, 1, 1, 0, 0]


def test_odometry_is_not_trusted_over_a_long_way() -> None:
    way = there_and_back()[:4]
    way += [seen(4, 1.0, 0, travelled_m=40.0), seen(5, 0.0, 0, travelled_m=41.0)]
    assert merged(way, [0, 0, 1, 1, 2, 2]) == [0, 0, 1, 1, 2, 2]


def test_a_scrap_between_returns_joins_the_stay_before_it() -> None:
    way = there_and_back()
    way.insert(5, seen(9, 0.6, 7, travelled_m=4.6))
    way[6] = seen(5, 0.5, 0, travelled_m=4.9)
    assert merged(way, [0, 0, 1, 1, 2, 3, 2]) == [0, 0, 1, 1, 0, 0, 0]
