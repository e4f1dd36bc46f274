"""Loop closing by sequence: the same places met again in the same order, so far apart.

Where every signature is a place of its own, a gateway say, no belief has time to settle on one. But
a sequence of places that comes again does so with the lengths and the turns between them. Every
pair of an earlier and a later signature is given the evidence that they are one place: how much
better the later fits the earlier one's place than it fits the others of the map, and how much
better the way since the last pair agrees than ways on this map do. Sums along a sequence that
pass a limit are a loop; some places of either passing may be missing.

Both terms are likelihood ratios whose mean over the map is 1, so that a limit of ``sure`` times
the number of pairs is passed by chance at most once in ``sure`` maps (Markov's inequality).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap_array
from fpnav.localization.recall import by_place, recall_all
from fpnav.mapping.loops import LoopParams, renumbered, returned
from fpnav.mapping.places import learned, make_edges, make_places
from fpnav.systems.base import System
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Reference, Signature

REACH = 3
"""Most steps from one pair to the next, on either side: up to two places may be missing."""

FLOOR = 0.05
"""Lengths are no surer than this share of the usual one."""

TURN_RAD = math.radians(20.0)
NOTHING = -np.inf


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """How far along and which way each signature was met; ``turn`` NaN without odometry.

    ``at`` : (N,) metres travelled; where a log does not say, seconds, which grow with them.
    """

    at: FloatArray
    heading: FloatArray
    session: NDArray[np.int64]


def close_sequences(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    params: LoopParams,
) -> tuple[NDArray[np.int64], dict[int, tuple[int, ...]]]:
    """Owners with the places of repeated sequences merged into those met first, as
    ``loops.close_loops`` gives them."""
    known = returned(system, signatures, owner, threshold, params)
    return renumbered(owner, repeated(system, signatures, known, params))


def repeated(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    params: LoopParams,
) -> NDArray[np.int64]:
    """Owners (N,) with the places of sequences that come again merged into those met first."""
    pairs = evidence(system, signatures, owner, params)
    way = way_of([signature.reference for signature in signatures])
    steps = {(a, b): _agreement(way, a, b, params) for a in _STEPS for b in _STEPS}
    possible = int(np.isfinite(pairs).sum())
    limit = math.log(params.sure * max(possible, 1))
    out = owner.copy()
    while True:
        chain, total = best_chain(pairs, steps)
        if total < limit or len(chain) <= params.changes:
            return out
        for late, early in chain:
            if _apart(out, way.session, late, early, params.recent_places):
                out[out == max(out[late], out[early])] = min(out[late], out[early])
        for late, early in chain:
            pairs[late, max(early - REACH, 0) : early + REACH + 1] = NOTHING


_STEPS = range(1, REACH + 1)


def evidence(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    params: LoopParams,
) -> FloatArray:
    """Log ratio (N, N) of each signature (row) being at an earlier one's place (column) rather
    than at any; -inf where the column is not earlier, or was left a moment ago."""
    topomap = TopoMap.of(make_places(signatures, owner), make_edges(signatures, owner))
    memory = learned(system, signatures, owner)
    recall = recall_all(memory, signatures, len(topomap), None, lambda done: None)
    scores, _ = by_place(recall, topomap.ids)
    column = np.searchsorted(topomap.ids, owner)
    scores = scores[:, column]
    scores[owner[:, None] == owner[None, :]] = NOTHING
    likelihood = system.likelihood(scores)
    usual = likelihood.mean(axis=1, where=np.isfinite(scores))
    ratio = np.log(np.maximum(likelihood, 1e-300)) - np.log(usual)[:, None]
    rows = np.arange(len(owner))
    session = np.array([signature.reference.session for signature in signatures])
    near = (session[:, None] == session) & (rows[:, None] - rows < params.recent_places)
    old = (rows[:, None] > rows) & ~near & np.isfinite(scores)
    return np.where(old, ratio, NOTHING)


def way_of(references: Sequence[Reference]) -> Way:
    """The way the references tell of; lengths of one unit throughout."""
    travelled = np.array([reference.travelled_m for reference in references])
    seconds = np.array([reference.stamp_ns for reference in references], np.float64) * 1e-9
    poses = [reference.odometry for reference in references]
    heading = np.array([math.nan if pose is None else pose.heading_rad for pose in poses])
    session = np.array([reference.session for reference in references], dtype=np.int64)
    return Way(seconds if np.isnan(travelled).any() else travelled, heading, session)


def best_chain(
    pairs: FloatArray, steps: dict[tuple[int, int], FloatArray]
) -> tuple[list[tuple[int, int]], float]:
    """Pairs (later, earlier) of the sequence with most evidence, in travel order, and the sum.

    Local alignment (Smith and Waterman 1981) of the sequence with its own past.

    Parameters
    ----------
    pairs : (N, N) evidence of each pair; -inf where there is none
    steps : by steps taken (later, earlier), (N, N) evidence of the way to each pair
    """
    total, before = pairs.copy(), np.full((*pairs.shape, 2), -1)
    for late in range(len(pairs)):
        for (a, b), way in steps.items():
            if late < a:
                continue
            reached = np.full(len(pairs), NOTHING)
            reached[b:] = total[late - a, :-b]
            value = pairs[late] + np.where(np.isfinite(reached), reached + way[late], NOTHING)
            better = np.flatnonzero(value > total[late])
            total[late, better] = value[better]
            before[late, better] = np.column_stack([np.full(len(better), late - a), better - b])
    late, early = (int(at) for at in np.unravel_index(int(np.argmax(total)), total.shape))
    most, chain = float(total[late, early]), []
    while late >= 0:
        chain.append((late, early))
        late, early = (int(at) for at in before[late, early])
    return chain[::-1], most


def _agreement(way: Way, late: int, early: int, params: LoopParams) -> FloatArray:
    """Log ratio (N, N) of the ways that ``late`` and ``early`` steps led to two signatures being
    one, against ways of ``early`` steps on this map; what they leave out has its price."""
    first, turned = _since(way, late)
    second, other = _since(way, early)
    known = np.isfinite(second)
    if not np.isfinite(first).any() or not known.any():
        return np.full((len(first), len(first)), NOTHING)
    spread = params.length_share * second + FLOOR * float(np.median(second[known]))
    density = np.exp(-0.5 * ((first[:, None] - second) / spread) ** 2) / spread
    turns = np.exp(-0.5 * (wrap_array(turned[:, None] - other) / TURN_RAD) ** 2)
    density = density * np.where(np.isnan(turns), 1.0, turns)
    usual = density[:, known].mean(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(density) - np.log(usual)[:, None]
    missed = (late - 1) + (early - 1)
    return np.where(np.isfinite(ratio), ratio + missed * math.log(params.missed), NOTHING)


def _since(way: Way, steps: int) -> tuple[FloatArray, FloatArray]:
    """Length and turn of the way that so many steps led to each signature, NaN across sessions."""
    length, turn = np.full(len(way.at), np.nan), np.full(len(way.at), np.nan)
    same = way.session[steps:] == way.session[:-steps]
    length[steps:] = np.where(same, way.at[steps:] - way.at[:-steps], np.nan)
    turn[steps:] = np.where(same, wrap_array(way.heading[steps:] - way.heading[:-steps]), np.nan)
    return length, turn


def _apart(
    owner: NDArray[np.int64], session: NDArray[np.int64], late: int, early: int, least: int
) -> bool:
    """Whether two places may be one: no signatures of them follow one another so soon."""
    ours, theirs = np.flatnonzero(owner == owner[late]), np.flatnonzero(owner == owner[early])
    soon = np.abs(ours[:, None] - theirs) < least
    return not bool((soon & (session[ours][:, None] == session[theirs])).any())
