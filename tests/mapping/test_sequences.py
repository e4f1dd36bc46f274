"""Laps show as sequences of places that come again, also where places look alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.mapping.loops import LoopParams
from fpnav.mapping.sequences import best_chain, repeated, way_of
from fpnav.sensing.cues import CUE
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.record import record_of
from fpnav.systems.gateway.system import Gateway
from fpnav.values import ORIGIN, Pose2, Reference, Signature

SYSTEM = Gateway(GatewayParams())
LAP = (1, 2, 2, 5, 3, 2, 4)
"""Types of the gateways of a lap; some are alike."""

WAYS_M = (4.0, 9.0, 3.0, 7.0, 12.0, 5.0, 10.0)
"""Way from each gateway to the next."""


def met(at_m: float, code: int, row: int, session: int = 0, *, known: bool = True) -> Signature:
    pose = Pose2(at_m, 0.0, 0.0) if known else None
    travelled = at_m if known else math.nan
    reference = Reference(row, round(at_m * 1e10), session, travelled, pose, None, math.nan, "")
    return Signature(reference, record_of(code, 0, None, ORIGIN), {"cues": np.zeros(0, CUE)})


def laps(
    count: int, *, missing: Sequence[int] = (), known: bool = True, session: int = 0
) -> tuple[list[Signature], NDArray[np.int64]]:
    """Signatures of some laps, each length off by up to 5 percent, and which gateway each is."""
    rng = np.random.default_rng(session)
    at, made, own = 0.0, [], []
    for number in range(count * len(LAP)):
        gateway = number % len(LAP)
        if number not in missing:
            made.append(met(at, LAP[gateway], len(made), session, known=known))
            own.append(gateway)
        at += WAYS_M[gateway] * float(rng.uniform(0.95, 1.05))
    return made, np.array(own)


def closed(signatures: Sequence[Signature]) -> NDArray[np.int64]:
    params = LoopParams(return_m=0.0)
    return repeated(SYSTEM, signatures, np.arange(len(signatures)), params)


@pytest.mark.parametrize("known", [True, False])
def test_laps_are_closed_by_the_ways_between_gateways_or_the_time_they_take(known: bool) -> None:
    signatures, own = laps(3, known=known)
    assert (closed(signatures) == own).all()


def test_a_gateway_that_is_missed_once_does_not_break_a_lap() -> None:
    signatures, own = laps(4, missing=[9, 24])
    found = closed(signatures)
    late = np.arange(len(found)) >= len(LAP)
    assert (found[late] == own[late]).mean() > 0.9
    assert len(np.unique(found)) <= len(LAP) + 1


def test_gateways_of_chance_types_and_lengths_make_no_lap() -> None:
    rng = np.random.default_rng(3)
    at = np.cumsum(rng.uniform(3.0, 12.0, 40))
    codes = rng.choice(LAP, 40)
    signatures = [
        met(float(a), int(code), row) for row, (a, code) in enumerate(zip(at, codes, strict=True))
    ]
    assert len(np.unique(closed(signatures))) == 40


def test_a_second_session_along_the_same_gateways_is_joined_to_the_first() -> None:
    first, own = laps(1)
    second, _ = laps(1, session=1)
    assert (closed([*first, *second]) == np.concatenate([own, own])).all()


def test_neighbours_in_travel_order_never_become_one_place() -> None:
    signatures, _ = laps(5)
    found = closed(signatures)
    assert all(len(set(found[row : row + 3].tolist())) == 3 for row in range(len(found) - 2))


def test_time_stands_for_length_only_where_no_length_is_known() -> None:
    timed, _ = laps(1, known=False)
    driven, _ = laps(1)
    seconds = np.array([s.reference.stamp_ns for s in timed]) * 1e-9
    np.testing.assert_allclose(way_of([s.reference for s in timed]).at, seconds)
    metres = np.array([s.reference.travelled_m for s in driven])
    np.testing.assert_allclose(way_of([s.reference for s in driven]).at, metres)


def test_the_best_chain_is_that_with_the_largest_sum() -> None:
    pairs = np.full((5, 5), -np.inf)
    pairs[2, 0], pairs[3, 1], pairs[4, 0] = 1.0, 2.0, 2.5
    step = {(1, 1): np.full((5, 5), 0.5)}
    chain, total = best_chain(pairs, step)
    assert (chain, total) == ([(2, 0), (3, 1)], 3.5)
