"""From signatures to answers: ranking, decision and what is stated about it.

``place`` -1 means not localized; it is never replaced by the nearest guess, which stays readable
in the ranking.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnav.localization.confidence import Confidence
from fpnav.localization.filter import (
    FilterParams,
    Step,
    Transitions,
    entropy,
    filter_belief,
    make_steps,
    most_likely_path,
    smooth_belief,
)
from fpnav.localization.recall import by_place, frame_memory, recall_all
from fpnav.localization.spots import Along
from fpnav.localization.verify import Checked, places_by_check, verified
from fpnav.systems.base import Memory, Recall, System
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Signature

LARGEST_BELIEF = 20_000_000

CHECKED_PLACES, CHECKED_MEMBERS = 25, 200
"""Best places whose members are candidates of the geometric check, and how many of those."""


class Method(StrEnum):
    """How a sequence of signatures is turned into places."""

    MATCH = "match"
    FILTER = "filter"
    SMOOTH = "smooth"


@dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """Columns of a result, see store.tables.Result; Q queries, k ranks, P places."""

    places: NDArray[np.int64]
    members: NDArray[np.int64]
    scores: FloatArray
    headings_rad: FloatArray
    decision: NDArray[np.int64]
    stated: FloatArray
    entropy: FloatArray
    belief: NDArray[np.float32]
    relative: FloatArray
    covariance: FloatArray


def locate(
    system: System,
    topomap: TopoMap,
    mapped: Sequence[Signature],
    queries: Sequence[Signature],
    recall: Recall,
    *,
    method: Method,
    params: FilterParams,
    confidence: Confidence,
    depth: int,
    along: Along | None = None,
) -> Answers:
    """Locate a run on a map; matches are ordered by the system's geometric check, if it has one.

    Parameters
    ----------
    mapped : the map's signatures, which the places' members index
    recall : all places ranked for each query, as ``recall_all`` gives
    depth : ranks kept per query
    along : the run along the mapping path, as ``along_spots`` gives; None = belief over places
    """
    if method is Method.MATCH:
        belief = np.zeros((len(queries), 0))
        ranked, stated = recall, confidence.stated(recall.scores[:, 0])
        decided = stated >= 0.5
    else:
        belief, path = _belief(system, topomap, queries, recall, along, method, params)
        ranked = _ranked_by(belief, path, recall, topomap.ids)
        stated = ranked.scores[:, 0]
        limit = params.entropy_share * np.log(max(2, len(topomap)))
        decided = (stated >= params.confident) | (entropy(belief) <= limit)
    members = np.full(ranked.places.shape, -1, dtype=np.int64)
    memory, owner = frame_memory(system, mapped), topomap.owner(len(mapped))
    top = _best_members(memory, owner, queries, ranked.places[:, :1], 1)
    members[:, 0] = top.places[:, 0]
    headings = ranked.headings_rad.copy()
    headings[:, 0] = top.headings_rad[:, 0]
    answers = Answers(
        places=ranked.places[:, :depth],
        members=members[:, :depth],
        scores=ranked.scores[:, :depth],
        headings_rad=headings[:, :depth],
        decision=np.where(decided, ranked.places[:, 0], -1),
        stated=stated,
        entropy=entropy(belief) if belief.shape[1] else np.full(len(queries), np.nan),
        belief=belief.astype(np.float32) if belief.size <= LARGEST_BELIEF else _none(len(queries)),
        **_no_pose(len(queries)),
    )
    if method is Method.MATCH and _has_check(system, mapped, queries, members[:, 0]):
        near = recall.places[:, :CHECKED_PLACES]
        rows = _best_members(memory, owner, queries, near, CHECKED_MEMBERS)
        checked = verified(system, mapped, queries, rows, CHECKED_MEMBERS)
        return _by_check(answers, recall, checked, owner, confidence)
    return answers


def _has_check(
    system: System,
    mapped: Sequence[Signature],
    queries: Sequence[Signature],
    members: NDArray[np.int64],
) -> bool:
    """Whether any query, asked with its best member, can be checked by all it was ranked by.

    A check that overlooks a sensor says less than the ranking: it does not reorder places.
    """
    pairs = zip(queries, members.tolist(), strict=True)
    found = (system.verify(query, [mapped[row]]) for query, row in pairs if row >= 0)
    return any(one is not None and one.whole for one in found)


def _by_check(
    answers: Answers,
    recall: Recall,
    checked: Checked,
    owner: NDArray[np.int64],
    confidence: Confidence,
) -> Answers:
    """Answers by likeness in the order of the check, with the poses it gives.

    Where the check states no probability it is that of the chosen place's likeness.
    """
    depth = answers.places.shape[1]
    ranked, members = places_by_check(recall, checked, owner)
    chosen = ranked.places[:, :1]
    likeness = np.max(recall.scores, axis=1, initial=-np.inf, where=recall.places == chosen)
    stated = np.where(np.isnan(checked.stated), confidence.stated(likeness), checked.stated)
    done = checked.done[:, None]
    headings = np.where(done, ranked.headings_rad[:, :depth], answers.headings_rad)
    return replace(
        answers,
        places=ranked.places[:, :depth],
        members=np.where(done, members[:, :depth], answers.members),
        scores=ranked.scores[:, :depth],
        headings_rad=headings,
        decision=np.where(stated >= 0.5, chosen[:, 0], -1),
        stated=stated,
        relative=checked.relative,
        covariance=checked.covariance,
    )


def _belief(
    system: System,
    topomap: TopoMap,
    queries: Sequence[Signature],
    recall: Recall,
    along: Along | None,
    method: Method,
    params: FilterParams,
) -> tuple[FloatArray, NDArray[np.int64] | None]:
    """Belief over places, (Q, P), and the most likely path through them where asked for."""
    likelihood: FloatArray
    steps: Sequence[Step]
    if along is None:
        scores, headings = by_place(recall, topomap.ids)
        column = np.arange(len(topomap))
        likelihood = system.likelihood(scores) ** params.power
        references = [query.reference for query in queries]
        steps = make_steps(Transitions.of(topomap, params), references, headings)
    else:
        column, likelihood, steps = along.path.column, along.likelihood, along.steps
    if method is Method.FILTER:
        return _over_places(filter_belief(likelihood, steps), column, len(topomap)), None
    way = most_likely_path(likelihood, steps) if params.decode == "viterbi" else None
    belief = _over_places(smooth_belief(likelihood, steps), column, len(topomap))
    return belief, None if way is None else column[way]


def _over_places(belief: FloatArray, column: NDArray[np.int64], places: int) -> FloatArray:
    """Belief over states (Q, S) summed over the states of each place, (Q, P)."""
    out = np.zeros((len(belief), places))
    for state, place in enumerate(column.tolist()):
        out[:, place] += belief[:, state]
    return out


def _ranked_by(
    belief: FloatArray, path: NDArray[np.int64] | None, recall: Recall, ids: NDArray[np.int64]
) -> Recall:
    """Places by falling belief, ties by id; the Viterbi path, where given, takes the first rank."""
    keyed = belief.copy()
    if path is not None:
        keyed[np.arange(len(path)), path] += 1.0
    order = np.argsort(-keyed, axis=1, kind="stable")
    _, headings = by_place(recall, ids)
    return Recall(
        ids[order],
        np.take_along_axis(belief, order, axis=1),
        np.take_along_axis(headings, order, axis=1),
    )


def _best_members(
    memory: Memory,
    owner: NDArray[np.int64],
    queries: Sequence[Signature],
    places: NDArray[np.int64],
    k: int,
) -> Recall:
    """The k members of the given places (Q, n) each query is most like; -1 without place.

    Headings are relative to the member, not to the place's frame: a long place has one frame,
    but what is seen turns along it.
    """

    def allowed(start: int, stop: int) -> NDArray[np.bool_]:
        asked = places[start:stop]
        known = [(owner >= 0) & np.isin(owner, row) for row in asked]
        return np.array(known, dtype=np.bool_).reshape(len(asked), len(owner))

    return recall_all(memory, queries, k, allowed, lambda done: None)


def _none(queries: int) -> NDArray[np.float32]:
    return np.zeros((queries, 0), dtype=np.float32)


def _no_pose(queries: int) -> dict[str, FloatArray]:
    return {
        "relative": np.full((queries, 3), np.nan),
        "covariance": np.full((queries, 3, 3), np.nan),
    }
