"""Spots of the mapping path as states of a belief, and what is known of each.

The map's memory tells a spot by its profile, how like each place the view there was. A mean of a
place cannot tell two tracks side by side in one room; the fingerprints that were fused in it can.
So a first belief, from the profiles, names the few spots the robot may be at, the view alone some
more where a robot set down elsewhere may be, and the view is compared with those that the mapping
run had there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fpnav.localization.filter import FilterParams, Step, filter_belief
from fpnav.localization.path import Path, PathSteps, make_path, path_likelihood, spots_of
from fpnav.localization.recall import by_place, frame_memory, recall_all
from fpnav.systems.base import Memory, Recall, System
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Signature

RANGE = (0.025, 0.975)
"""Quantiles between which scores are taken to lie."""


@dataclass(frozen=True, slots=True, eq=False)
class Spots:
    """Spots of the mapping path: ``rows`` (C,) of the map's signatures and their ``profiles``
    (C, P), scores at all places, ids ascending."""

    rows: NDArray[np.int64]
    profiles: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Along:
    """A run of Q queries along a path of C spots: ``likelihood`` (Q, C) and the steps between."""

    path: Path
    likelihood: FloatArray
    steps: Sequence[Step]


def recall_spots(
    memory: Memory, topomap: TopoMap, mapped: Sequence[Signature], params: FilterParams
) -> Spots | None:
    """How like each place the views along the mapping path are; None where there is no path."""
    rows = spots_of(topomap, mapped, params)
    if not len(rows):
        return None
    views = [mapped[int(row)] for row in rows]
    recall = recall_all(memory, views, len(topomap), None, lambda done: None)
    return Spots(rows, by_place(recall, topomap.ids)[0])


def along_spots(
    system: System,
    topomap: TopoMap,
    mapped: Sequence[Signature],
    queries: Sequence[Signature],
    recall: Recall,
    spots: Spots,
    params: FilterParams,
) -> Along:
    """What a run says of the spots: by profiles, then by the views at those that are likely."""
    scores, headings = by_place(recall, topomap.ids)
    references = [query.reference for query in queries]
    path = make_path(topomap, mapped, spots.rows, spots.profiles, references, params)
    likelihood = path_likelihood(
        path, spots.profiles, scores, system.likelihood(scores), params.profile
    )
    likelihood[:1] /= np.bincount(path.column)[path.column]  # at first all places are as likely
    rough = Along(path, likelihood, PathSteps(path, references, headings, params))
    if params.asked == 0 or params.seen <= 0.0 or not len(queries):
        return rough
    by_belief = _likely(filter_belief(likelihood, rough.steps), params.asked)
    likely = by_belief | _likely(likelihood, params.asked // 2)
    views = frame_scores(system, mapped, queries, spots.rows, likely)
    told = view_likelihood(views, spread(spots.profiles), params.seen)
    return replace(rough, likelihood=likelihood * told)


def frame_scores(
    system: System,
    mapped: Sequence[Signature],
    queries: Sequence[Signature],
    rows: NDArray[np.int64],
    asked: NDArray[np.bool_],
) -> FloatArray:
    """Score of each query at the mapping signatures of the spots it is asked of, (Q, C), else NaN.

    ``rows`` (C,) of ``mapped``; ``asked`` (Q, C).
    """
    memory = frame_memory(system, [mapped[int(row)] for row in rows])

    def allowed(start: int, stop: int) -> NDArray[np.bool_]:
        return asked[start:stop]

    k = int(asked.sum(axis=1).max(initial=1))
    recall = recall_all(memory, queries, k, allowed, lambda done: None)
    scores, _ = by_place(recall, np.arange(len(rows)))
    return np.where(np.isfinite(scores), scores, np.nan)


def view_likelihood(scores: FloatArray, unit: float, nats: float) -> FloatArray:
    """Likelihood of views at spots, (Q, C), the largest of a row 1.

    Spots that were not asked, NaN, are as unlikely as the least of those that were.

    Parameters
    ----------
    unit : difference of scores that says ``nats``; 0 = they do not differ, and say nothing
    """
    known = np.isfinite(scores)
    best = np.where(known, scores, -np.inf).max(axis=1, keepdims=True, initial=-np.inf)
    least = np.where(known, scores, np.inf).min(axis=1, keepdims=True, initial=np.inf)
    below = np.where(known, scores, least) - best
    weight = nats / unit if unit > 0.0 else 0.0
    return np.exp(weight * np.where(np.isfinite(below), below, 0.0))


def spread(scores: FloatArray) -> float:
    """How far known scores lie apart, by quantiles; 0 without any."""
    known = scores[np.isfinite(scores)]
    if not len(known):
        return 0.0
    low, high = np.quantile(known, RANGE)
    return float(high - low)


def _likely(belief: FloatArray, count: int) -> NDArray[np.bool_]:
    """The ``count`` most likely spots of each row, of equal ones the first, (Q, C)."""
    found = np.zeros(belief.shape, bool)
    order = np.argsort(-belief, axis=1, kind="stable")[:, :count]
    np.put_along_axis(found, order, True, axis=1)
    return found
