"""Metrics of position, heading and the shape of place fields."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.bootstrap import interval
from fpnav.evaluation.case import Case, neighbour_places
from fpnav.evaluation.measure import NO_MATCH, NO_POSES, Absent, map_missing, middle, truth_missing
from fpnav.values import FloatArray, Metric


def position_error(name: str, case: Case) -> Metric | Absent:
    """Median distance in metres from the truth of the query to that of the best member, the stated
    relative pose applied, over the queries that have a match."""
    if missing := truth_missing(case):
        return missing
    if not case.has_match.any():
        return NO_MATCH
    if not np.isfinite(case.position_error_m[case.has_match]).any():
        return NO_POSES
    return middle(name, case.position_error_m, case.has_match, "m")


def heading_error(name: str, case: Case) -> Metric | Absent:
    """Median error in degrees of the stated heading, over the right best answers."""
    if missing := truth_missing(case):
        return missing
    right = case.judged & case.best_right
    if not right.any():
        return Absent("no best answer is right")
    degrees = np.rad2deg(case.heading_error_rad)
    if not np.isfinite(degrees[right]).any():
        return Absent("no heading is stated, or truth has none")
    return middle(name, degrees, right, "deg")


def field_rho(name: str, case: Case) -> Metric | Absent:
    """Spearman rank correlation of matching score and distance to the place's centre.

    Over all pairs of a query with its true place and the graph neighbours of that place, as far as
    the ranking holds them: the field of a place and its surroundings. ``n`` of ``of`` counts pairs.
    """
    if missing := map_missing(case):
        return missing
    query, scores, away_m, possible = _field_pairs(case)
    if len(query) < 3 or np.ptp(scores) == 0.0 or np.ptp(away_m) == 0.0:
        return Absent("fewer than three different scores with a known distance to a place's centre")

    def rho(weights: FloatArray) -> FloatArray:
        drawn = weights[:, query]
        return weighted_spearman(scores, away_m, drawn)

    low, high = interval(rho, len(case.judged))
    value = float(rho(np.ones((1, len(case.judged))))[0])
    return Metric(name, value, len(query), possible, "", low, high)


def _field_pairs(case: Case) -> tuple[NDArray[np.int64], FloatArray, FloatArray, int]:
    """Query, score and distance to the centre of each pair, and how many pairs there could be."""
    view = case.result.view
    centre = dict(zip(view.place_ids.tolist(), view.place_pose[:, :2], strict=True))
    neighbours = neighbour_places(case.result)
    rows: list[tuple[int, float, float]] = []
    possible = 0
    for query in np.flatnonzero(case.true_place >= 0).tolist():
        place = int(case.true_place[query])
        field = {place} | neighbours.get(place, set())
        possible += len(field)
        ranking = zip(
            case.result.places[query].tolist(), case.result.scores[query].tolist(), strict=True
        )
        for answer, score in ranking:
            if answer in field and answer in centre and np.isfinite(score):
                away = np.hypot(*(case.result.queries["truth"][query, :2] - centre[answer]))
                rows.append((query, score, float(away)))
    known = np.array([row for row in rows if np.isfinite(row[2])], dtype=np.float64).reshape(-1, 3)
    return known[:, 0].astype(np.int64), known[:, 1], known[:, 2], possible


def weighted_spearman(first: FloatArray, second: FloatArray, weights: FloatArray) -> FloatArray:
    """Spearman's rho of two samples (N,) under B weightings (B, N) by whole counts: (B,).

    Equal to the rho of the sample in which unit i stands ``weights[b, i]`` times.
    """
    ranks = (_midranks(first, weights), _midranks(second, weights))
    total = weights.sum(axis=1)
    with np.errstate(all="ignore"):
        centred = [r - ((weights * r).sum(axis=1) / total)[:, None] for r in ranks]
        joint = (weights * centred[0] * centred[1]).sum(axis=1)
        spread = [(weights * c * c).sum(axis=1) for c in centred]
        return np.asarray(joint / np.sqrt(spread[0] * spread[1]))


def _midranks(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Mean rank of each unit (B, N) where unit i stands ``weights[b, i]`` times."""
    _, group = np.unique(values, return_inverse=True)
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    counts = np.add.reduceat(weights[:, order], starts, axis=1)
    before = np.cumsum(counts, axis=1) - counts
    return np.asarray((before + 0.5 * (counts + 1.0))[:, group])
