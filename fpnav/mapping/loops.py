"""Loop closing: two belief peaks that move together (Tomatis et al. 2003; systems.md 1.10).

On an open chain map a robot that comes back starts new places where old ones stand. The belief
over the places left long ago, with an explicit "none of them", then has a peak that moves along
the map as the robot moves. Where that lasts over several places, and the places look alike, the
new places are merged into the old ones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap
from fpnav.localization.filter import FilterParams, Step, Transitions, make_steps
from fpnav.localization.recall import by_place, recall_all
from fpnav.mapping.places import learned, make_edges, make_places, runs_of
from fpnav.mapping.returns import merge_returns
from fpnav.params import Params
from fpnav.systems.base import System
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Signature


class LoopParams(Params, frozen=True):
    """Block ``loops``.

    recent_observations, recent_places : a place left less than this ago is not old
    least_belief : second peaks below this are none
    changes : place changes the two peaks must make together
    sure : or one change and this likelihood ratio against "none of them"
    none_quantile : score between unlike places that "none of them" is given
    enter : probability per observation that an old place is entered, or left for new ground
    accept_share : share of the pairs that must look alike
    heading_deg : how well the rotations between the paired places must agree
    rounds : passes over the map, each with the loops of the last one closed
    return_m, drift : a stay returns to a neighbouring place within this distance by odometry, plus
        this share of the path between; 0 metres = never
    length_share, missed : where loops are sequences that come again: how well lengths agree, as a
        share of them, and the probability that a place is missed
    """

    recent_observations: int = 30
    recent_places: int = 3
    least_belief: float = 0.15
    changes: int = 3
    sure: float = 100.0
    none_quantile: float = 0.95
    enter: float = 0.02
    accept_share: float = 2.0 / 3.0
    heading_deg: float = 20.0
    rounds: int = 10
    return_m: float = 0.7
    drift: float = 0.03
    length_share: float = 0.1
    missed: float = 0.2


@dataclass(frozen=True, slots=True)
class Pair:
    """One stay at a new place, paired with the old place it is thought to be."""

    stay: int
    place: int
    old: int
    evidence: float


def close_loops(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    params: LoopParams,
) -> tuple[NDArray[np.int64], dict[int, tuple[int, ...]]]:
    """Owners with the loops closed, and which places each kept place was merged from.

    Parameters
    ----------
    owner : (N,) place of each signature on the open chain map
    threshold : dissimilarity within a place; pairs must be more alike than that

    Returns
    -------
    owner : (N,), ids renumbered from 0 in the order the places are first visited
    merged : kept id -> ids on the open chain map, where more than one
    """
    origin = owner
    owner = returned(system, signatures, owner, threshold, params)
    for _ in range(params.rounds):
        merges = find_loops(system, signatures, owner, threshold, params)
        if not merges:
            break
        owner = np.array([_root(merges, int(place)) for place in owner], dtype=np.int64)
    return renumbered(origin, owner)


def returned(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    params: LoopParams,
) -> NDArray[np.int64]:
    """Owners with the ways back that odometry shows merged, where that is asked for."""
    if params.return_m <= 0:
        return owner.copy()
    return merge_returns(
        system, signatures, owner, threshold, reach_m=params.return_m, drift=params.drift
    )


def renumbered(
    origin: NDArray[np.int64], owner: NDArray[np.int64]
) -> tuple[NDArray[np.int64], dict[int, tuple[int, ...]]]:
    """Ids from 0 in the order the places are first visited, and what each was merged from."""
    _, first = np.unique(owner, return_index=True)
    order = owner[np.sort(first)]
    closed = np.array([int(np.flatnonzero(order == place)[0]) for place in owner], dtype=np.int64)
    merged = {
        int(place): tuple(int(old) for old in np.unique(origin[closed == place]))
        for place in np.unique(closed)
    }
    return closed, {place: ids for place, ids in merged.items() if len(ids) > 1}


def find_loops(
    system: System,
    signatures: Sequence[Signature],
    owner: NDArray[np.int64],
    threshold: float,
    params: LoopParams,
) -> dict[int, int]:
    """Places to merge, new id -> old id; empty where no loop is found."""
    topomap = TopoMap.of(make_places(signatures, owner), make_edges(signatures, owner))
    if len(topomap) <= params.recent_places:
        return {}
    recall = recall_all(
        learned(system, signatures, owner), signatures, len(topomap), None, lambda done: None
    )
    scores, headings = by_place(recall, topomap.ids)
    rows = np.searchsorted(topomap.ids, owner)
    old = old_places(rows, len(topomap), params)
    likelihood, none = _likelihoods(system, scores, old, params)
    belief = second_peak(topomap, signatures, headings, likelihood, none, old, params)
    stays = runs_of([signature.reference for signature in signatures], owner)
    evidence = np.log(np.maximum(likelihood, 1e-300)) - np.log(np.maximum(none, 1e-300))[:, None]
    pairs = _pair_stays(topomap, stays, owner, belief, evidence, params)
    merges: dict[int, int] = {}
    looks = Looks(system, signatures, owner, stays, headings, topomap.ids, threshold)
    for chain in _chains(topomap, pairs):
        if _long_enough(chain, params):
            kept = _acceptable(looks, chain, params)
            merges.update({pair.place: pair.old for pair in kept if pair.place != pair.old})
    return merges


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """What a pair of places is compared by."""

    system: System
    signatures: Sequence[Signature]
    owner: NDArray[np.int64]
    stays: Sequence[NDArray[np.int64]]
    headings: FloatArray
    ids: NDArray[np.int64]
    threshold: float

    def alike(self, pair: Pair) -> bool:
        """Whether the middle of the stay looks like some signature of the old place."""
        middle = self.signatures[self._middle(pair)]
        members = np.flatnonzero(self.owner == pair.old)
        best = max(self.system.similarity(middle, self.signatures[int(m)]) for m in members)
        return best >= 1.0 - self.threshold

    def turn(self, pair: Pair) -> float:
        """Rotation seen against the old place less the one odometry gives; NaN where unknown."""
        query, first = self._middle(pair), int(np.argmax(self.owner == pair.old))
        here = self.signatures[query].reference.odometry
        there = self.signatures[first].reference.odometry
        seen = float(self.headings[query, int(np.searchsorted(self.ids, pair.old))])
        if here is None or there is None or not math.isfinite(seen):
            return math.nan
        return wrap(seen - (here.heading_rad - there.heading_rad))

    def _middle(self, pair: Pair) -> int:
        stay = self.stays[pair.stay]
        return int(stay[len(stay) // 2])


def old_places(rows: NDArray[np.int64], places: int, params: LoopParams) -> NDArray[np.bool_]:
    """Places left long enough before each signature to be come back to, (N, P).

    ``rows`` : (N,) row of the place that owns each signature.
    """
    old = np.zeros((len(rows), places), dtype=bool)
    last = np.full(places, -1)
    last_change = np.full(places, -1)
    change = 0
    for t, row in enumerate(rows):
        change += int(t > 0 and rows[t - 1] != row)
        old[t] = (
            (last >= 0)
            & (last < t - params.recent_observations)
            & (last_change <= change - params.recent_places)
        )
        old[t, row] = False
        last[row], last_change[row] = t, change
    return old


def _likelihoods(
    system: System, scores: FloatArray, old: NDArray[np.bool_], params: LoopParams
) -> tuple[FloatArray, FloatArray]:
    """Likelihood of each observation at every place (N, P) and at none of the old ones (N,).

    The state "none" is scored as one more place that scores what unlike places do.
    """
    unlike = scores[old & np.isfinite(scores)]
    level = float(np.quantile(unlike, params.none_quantile)) if len(unlike) else 0.0
    column = np.full((len(scores), 1), level)
    both = system.likelihood(np.hstack([scores, column]))
    return np.where(old, both[:, :-1], 0.0), both[:, -1]


def second_peak(
    topomap: TopoMap,
    signatures: Sequence[Signature],
    headings: FloatArray,
    likelihood: FloatArray,
    none: FloatArray,
    old: NDArray[np.bool_],
    params: LoopParams,
) -> FloatArray:
    """Smoothed belief over the old places, (N, P); what is missing to 1 is "none of them"."""
    transitions = Transitions.of(topomap, FilterParams(kidnap=0.0))
    steps = make_steps(transitions, [signature.reference for signature in signatures], headings)
    observed = np.hstack([likelihood, none[:, None]])
    forward = np.empty_like(observed)
    predicted = np.append(np.zeros(len(topomap)), 1.0)
    for t in range(len(observed)):
        if t > 0:
            predicted = _forward(steps[t - 1], forward[t - 1], old[t], params.enter)
        forward[t] = _normalised(observed[t] * predicted)
    smoothed = forward.copy()
    message = np.ones(observed.shape[1])
    for t in range(len(observed) - 2, -1, -1):
        message = _backward(steps[t], observed[t + 1] * message, old[t + 1], params.enter)
        message /= max(float(message.max()), 1e-300)
        smoothed[t] = _normalised(forward[t] * message)
    return smoothed[:, :-1]


def _forward(step: Step, belief: FloatArray, old: NDArray[np.bool_], enter: float) -> FloatArray:
    share = old / max(1, int(old.sum()))
    places = (1.0 - enter) * step.forward(belief[:-1]) + enter * belief[-1] * share
    none = (1.0 - enter * bool(old.any())) * belief[-1] + enter * belief[:-1].sum()
    return np.append(places, none)


def _backward(step: Step, message: FloatArray, old: NDArray[np.bool_], enter: float) -> FloatArray:
    share = old / max(1, int(old.sum()))
    places = (1.0 - enter) * step.backward(message[:-1]) + enter * message[-1]
    none = (1.0 - enter * bool(old.any())) * message[-1] + enter * float(share @ message[:-1])
    return np.append(places, none)


def _normalised(values: FloatArray) -> FloatArray:
    total = float(values.sum())
    return values / total if total > 0 else np.full(len(values), 1.0 / len(values))


def _pair_stays(
    topomap: TopoMap,
    stays: Sequence[NDArray[np.int64]],
    owner: NDArray[np.int64],
    belief: FloatArray,
    evidence: FloatArray,
    params: LoopParams,
) -> list[Pair | None]:
    """The old place each stay is thought to be, None where there is no second peak."""
    pairs: list[Pair | None] = []
    for number, stay in enumerate(stays):
        mean = belief[stay].mean(axis=0)
        best = int(np.argmax(mean))
        if mean[best] < params.least_belief:
            pairs.append(None)
            continue
        against = float(evidence[stay, best].sum())
        pairs.append(Pair(number, int(owner[stay[0]]), int(topomap.ids[best]), against))
    return pairs


def _chains(topomap: TopoMap, pairs: Sequence[Pair | None]) -> list[list[Pair]]:
    """Longest runs of stays whose old places follow one another on the map."""
    chains: list[list[Pair]] = []
    for pair in pairs:
        if pair is None:
            chains.append([])
        elif chains and chains[-1] and _moves_along(topomap, chains[-1], pair):
            chains[-1].append(pair)
        else:
            chains.append([pair])
    return [chain for chain in chains if chain]


def _moves_along(topomap: TopoMap, chain: list[Pair], pair: Pair) -> bool:
    """Whether the old place stays or moves along an edge, and does not turn back."""
    last = chain[-1].old
    if pair.old == last:
        return True
    visited = {earlier.old for earlier in chain[:-1]}
    near = {last, *topomap.neighbours(last)}
    within = near | {n for place in near for n in topomap.neighbours(place)}
    return pair.old in within and pair.old not in visited


def _long_enough(chain: Sequence[Pair], params: LoopParams) -> bool:
    """Enough changes made together, or one change and overwhelming evidence."""
    moved = sum(
        first.place != second.place and first.old != second.old for first, second in pairwise(chain)
    )
    total = sum(pair.evidence for pair in chain)
    return moved >= params.changes or (moved >= 1 and total >= math.log(params.sure))


def _acceptable(looks: Looks, chain: Sequence[Pair], params: LoopParams) -> Sequence[Pair]:
    """The pairs of a chain that are a loop; none where it is not one.

    The smoother comes early to where a loop begins and stays late where it ends, so a loop reaches
    from the first pair that looks alike to the last. Enough of those between must look alike, and
    the rotations between their frames must agree.
    """
    alike = np.array([looks.alike(pair) for pair in chain])
    found = np.flatnonzero(alike)
    if len(found) == 0:
        return ()
    kept = chain[found[0] : found[-1] + 1]
    if len(found) < params.accept_share * len(kept) or not _long_enough(kept, params):
        return ()
    turns = np.array([looks.turn(pair) for pair in kept])
    known = turns[np.isfinite(turns)]
    agree = len(known) < 2 or _spread(known) <= math.radians(params.heading_deg)
    return kept if agree else ()


def _spread(angles: FloatArray) -> float:
    """Median deviation from the circular median direction, radians."""
    mean = math.atan2(float(np.sin(angles).mean()), float(np.cos(angles).mean()))
    return float(np.median([abs(wrap(float(angle) - mean)) for angle in angles]))


def _root(merges: dict[int, int], place: int) -> int:
    """Follow merges to the place that stays."""
    seen = {place}
    while place in merges and merges[place] not in seen:
        place = merges[place]
        seen.add(place)
    return place
