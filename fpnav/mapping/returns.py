"""Coming back the way one went: a stay next to a known place may be that place again.

A robot that leaves an office passes the piece of corridor it came from. Two belief peaks cannot
show that, since nothing is old yet; but the map itself says what lies next to the last place, and
over a few metres odometry says whether the robot is back there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import distance
from fpnav.mapping.places import runs_of
from fpnav.systems.base import System
from fpnav.values import Signature


def merge_returns(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    *,
    reach_m: float,
    drift: float,
) -> NDArray[np.int64]:
    """Owners with every stay joined to the neighbouring place it returns to.

    A stay returns to a place that has an edge with the place before it, when a signature of its
    own and one of the place's stand within ``reach_m`` plus ``drift`` of the path between them, by
    odometry, and are less dissimilar than the threshold. Of several the most alike counts. Without
    odometry nothing returns.

    Parameters
    ----------
    owner : (N,) place of each signature
    threshold : dissimilarity within a place
    """
    out = owner.copy()
    near: dict[int, set[int]] = {}
    members: dict[int, list[int]] = {}
    last = -1
    for stay in runs_of([signature.reference for signature in signatures], owner):
        place = int(owner[stay[0]])
        same_session = last >= 0 and _session(signatures, stay[0] - 1) == _session(
            signatures, stay[0]
        )
        if same_session and place not in members:
            known = sorted(near.get(last, set()) - {last})
            found = [
                (_alike(system, signatures, stay, members[other], reach_m, drift), -other)
                for other in known
            ]
            best = max(found, default=(0.0, 0))
            place = -best[1] if best[0] >= 1.0 - threshold else place
        out[stay] = place
        members.setdefault(place, []).extend(int(row) for row in stay)
        if same_session and last != place:
            near.setdefault(last, set()).add(place)
            near.setdefault(place, set()).add(last)
        last = place
    return out


def _session(signatures: Sequence[Signature], row: int) -> int:
    return signatures[int(row)].reference.session


def _alike(
    system: System,
    signatures: Sequence[Signature],
    stay: NDArray[np.int64],
    members: Sequence[int],
    reach_m: float,
    drift: float,
) -> float:
    """Similarity of the nearest pair of a stay and a place; 0 where none is near enough."""
    pairs = [
        (_apart(signatures[int(mine)], signatures[theirs], drift), int(mine), theirs)
        for mine in stay
        for theirs in members
    ]
    apart, mine, theirs = min(pairs)
    if not apart <= reach_m:
        return 0.0
    return system.similarity(signatures[mine], signatures[theirs])


def _apart(first: Signature, second: Signature, drift: float) -> float:
    """Metres between two signatures by odometry beyond what drift explains; inf if unknown."""
    a, b = first.reference, second.reference
    if a.odometry is None or b.odometry is None:
        return math.inf
    return distance(a.odometry, b.odometry) - drift * abs(a.travelled_m - b.travelled_m)
