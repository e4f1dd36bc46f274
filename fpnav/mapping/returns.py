"""Coming back the way one went: what is seen where the robot already was belongs to that place.

A robot that leaves an office drives over the ground it came in by. Two belief peaks cannot show
that, since nothing is old yet; but over a few metres odometry says where the robot was before, and
what it sees there must look the same. Otherwise one spot would belong to two places, the one of
the way in and the one of the way out, and nobody could say which of them a robot on it is in.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fpnav.mapping.places import runs_of
from fpnav.systems.base import System
from fpnav.values import FloatArray, Reference, Signature

BACK_M = 2.0
"""Least path between two passings: less is the same passing."""

FAR_M = 25.0
"""Most path between them that odometry is trusted over; beyond it loops are closed by belief."""

ASKED = 3
"""Earlier signatures looked at before the ground counts as new."""

STAY_M = 0.5
"""Stays shorter than this, left over between returns, join the stay before them."""


def merge_returns(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    *,
    reach_m: float,
    drift: float,
) -> NDArray[np.int64]:
    """Owners with every signature on known ground given to the place that was there first.

    A signature returns to the nearest earlier one, by odometry, that lies within ``reach_m`` plus
    ``drift`` of the path between them and is less dissimilar than the threshold. Without
    odometry nothing returns.

    Parameters
    ----------
    owner : (N,) place of each signature
    threshold : dissimilarity within a place
    """
    references = [signature.reference for signature in signatures]
    xy, travelled, session = _columns(references)
    out = owner.copy()
    for row in range(len(out)):
        for before in _passed(row, xy, travelled, session, reach_m, drift)[:ASKED].tolist():
            if system.similarity(signatures[row], signatures[before]) > 1.0 - threshold:
                out[row] = out[before]
                break
    return _settled(references, out)


def _columns(references: Sequence[Reference]) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    poses = [reference.odometry for reference in references]
    nowhere = (np.nan, np.nan)
    xy = np.array([nowhere if pose is None else (pose.x_m, pose.y_m) for pose in poses])
    travelled = np.array([reference.travelled_m for reference in references])
    return xy, travelled, np.array([reference.session for reference in references])


def _passed(
    row: int,
    xy: FloatArray,
    travelled: FloatArray,
    session: NDArray[np.int64],
    reach_m: float,
    drift: float,
) -> NDArray[np.int64]:
    """Earlier signatures on the same ground, the nearest first."""
    path = travelled[row] - travelled[:row]
    away = np.hypot(*(xy[:row] - xy[row]).T)
    with np.errstate(invalid="ignore"):
        known = (path >= BACK_M) & (path <= FAR_M) & (session[:row] == session[row])
        near = known & (away <= reach_m + drift * path)
    rows = np.flatnonzero(near)
    return rows[np.argsort(away[rows], kind="stable")]


def _settled(references: Sequence[Reference], owner: NDArray[np.int64]) -> NDArray[np.int64]:
    """Owners with the scraps between returns given to the stay before them, the shortest first."""
    out = owner.copy()
    while True:
        stays = runs_of(references, out)
        scraps = [
            (length, number)
            for number, length in enumerate(_lengths(references, stays))
            if length < STAY_M
            and number > 0
            and references[stays[number][0]].session == references[stays[number - 1][0]].session
        ]
        if not scraps:
            return out
        _, number = min(scraps)
        out[stays[number]] = out[stays[number - 1][0]]


def _lengths(references: Sequence[Reference], stays: Sequence[NDArray[np.int64]]) -> list[float]:
    """Path from where each stay begins to where the next begins; inf at the end of a session."""
    firsts = [references[stay[0]] for stay in stays]
    lengths = [
        b.travelled_m - a.travelled_m if a.session == b.session else np.inf
        for a, b in pairwise(firsts)
    ]
    return [*(length if np.isfinite(length) else np.inf for length in lengths), np.inf]
