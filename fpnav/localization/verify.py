"""Rankings reordered by the system's geometric check of their best candidates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import Recall, System, Verification
from fpnav.values import FloatArray, Signature


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A ranking after the check. Of the best of each query: ``relative`` (Q, 3) and
    ``covariance`` (Q, 3, 3) where the check gave a pose, ``stated`` (Q,) where it stated a
    probability. Of every rank: ``poses`` (Q, k, 3) and ``probability`` (Q, k) as well; NaN
    elsewhere. ``done`` (Q,): whether the query was checked at all."""

    recall: Recall
    relative: FloatArray
    covariance: FloatArray
    stated: FloatArray
    poses: FloatArray
    probability: FloatArray
    done: NDArray[np.bool_]


def verified(
    system: System,
    reference: Sequence[Signature],
    queries: Sequence[Signature],
    recall: Recall,
    top: int,
) -> Checked:
    """The ``top`` best rows of each ranking, which index ``reference``, by what the check says.

    What was not checked keeps its order and scores no better than the least that was.
    """
    out = unchecked(Recall(recall.places.copy(), recall.scores.copy(), recall.headings_rad.copy()))
    for row in range(len(queries)):
        ranked = recall.places[row, :top][recall.places[row, :top] >= 0]
        if len(ranked):
            checked = system.verify(queries[row], [reference[int(place)] for place in ranked])
            if checked is not None:
                _reorder(out, row, ranked, checked)
    return out


def unchecked(recall: Recall) -> Checked:
    """A ranking of which nothing more is known."""
    count = len(recall.places)
    return Checked(
        recall,
        np.full((count, 3), np.nan),
        np.full((count, 3, 3), np.nan),
        np.full(count, np.nan),
        np.full((*recall.places.shape, 3), np.nan),
        np.full(recall.places.shape, np.nan),
        np.zeros(count, dtype=np.bool_),
    )


def places_by_check(
    recall: Recall, checked: Checked, owner: NDArray[np.int64]
) -> tuple[Recall, NDArray[np.int64]]:
    """Places in the order of their best checked members, and those members (Q, k), -1 elsewhere.

    Parameters
    ----------
    recall : every place ranked by likeness, (Q, k); kept where a query was not checked
    checked : rows of the map's signatures after the check, of places in ``recall`` only
    owner : place of each of the map's signatures, (R,)

    Places of which no member was checked follow in their order, and score no better than those.
    """
    out = Recall(recall.places.copy(), recall.scores.copy(), recall.headings_rad.copy())
    members = np.full(recall.places.shape, -1, dtype=np.int64)
    for row in np.flatnonzero(checked.done).tolist():
        rows = checked.recall.places[row][checked.recall.places[row] >= 0]
        ranks = np.sort(np.unique(owner[rows], return_index=True)[1])
        best, scores = rows[ranks], checked.recall.scores[row, ranks]
        rest = ~np.isin(recall.places[row], owner[best])
        least = np.minimum(recall.scores[row, rest], scores.min())
        headings = checked.recall.headings_rad[row, ranks]
        out.places[row] = np.append(owner[best], recall.places[row, rest])
        out.scores[row] = np.append(scores, least)
        out.headings_rad[row] = np.append(headings, recall.headings_rad[row, rest])
        members[row, : len(best)] = best
    return out, members


def checked_scores(
    system: System,
    reference: Sequence[Signature],
    queries: Sequence[Signature],
    places: NDArray[np.int64],
    scores: FloatArray,
) -> FloatArray:
    """Scores of one place per query on the scale of the check, where the system has one."""
    out = scores.copy()
    for row in np.flatnonzero(places >= 0).tolist():
        checked = system.verify(queries[row], [reference[int(places[row])]])
        if checked is not None:
            out[row] = checked.scores[0]
    return out


def _reorder(out: Checked, row: int, ranked: NDArray[np.int64], checked: Verification) -> None:
    """One ranking in the order of the check, with what it says of the best."""
    out.done[row] = True
    order = np.lexsort((ranked, -checked.scores))
    places, scores, headings = (
        column[row] for column in (out.recall.places, out.recall.scores, out.recall.headings_rad)
    )
    places[: len(ranked)] = ranked[order]
    scores[: len(ranked)] = checked.scores[order]
    headings[: len(ranked)] = headings[: len(ranked)][order]
    rest = scores[len(ranked) :]
    rest[:] = np.minimum(rest, checked.scores.min())
    for rank, candidate in enumerate(order.tolist()):
        found = checked.relative[candidate]
        if found is not None:
            headings[rank] = found.pose.heading_rad
            out.poses[row, rank] = found.pose.x_m, found.pose.y_m, found.pose.heading_rad
    if checked.stated is not None:
        out.probability[row, : len(ranked)] = checked.stated[order]
    best = int(order[0])
    found = checked.relative[best]
    if found is not None:
        out.relative[row] = found.pose.x_m, found.pose.y_m, found.pose.heading_rad
        out.covariance[row] = np.reshape(found.covariance, (3, 3))
    if checked.stated is not None:
        out.stated[row] = checked.stated[best]
