"""Frame-to-frame place recognition: one run against its own past, or query against reference."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.localization.confidence import Confidence, fit_confidence
from fpnav.localization.frames import smoothed_frames
from fpnav.localization.locate import Answers, Method
from fpnav.localization.recall import Advance, frame_memory, recall_all
from fpnav.localization.sequence import smoothed
from fpnav.localization.verify import checked_scores, unchecked, verified
from fpnav.store.tables import SignatureTable
from fpnav.systems.base import Memory, Recall, System
from fpnav.values import FloatArray

SAMPLE = 200
"""Reference signatures looked at to learn what right and wrong scores look like."""

ELSEWHERE = 2.0
"""Radii of travelled path beyond which signatures of one run count as another place."""


def past_candidates(
    references: NDArray[np.void], exclude_path_m: float, exclude_frames: int
) -> NDArray[np.int64]:
    """How many of the first rows each row may be matched with, (R,).

    A row may be matched with rows at least ``exclude_path_m`` of travel and ``exclude_frames``
    messages of the primary role before it, and with every row of earlier sessions.

    Raises
    ------
    LogError
        A path is to be excluded and the run has neither odometry nor truth to measure it by.
    """
    travelled = references["travelled_m"]
    if exclude_path_m > 0 and not np.isfinite(travelled).all():
        raise LogError(
            "--exclude-path needs odometry or truth to measure the path; "
            "the run has neither: use --exclude-frames"
        )
    counts = np.zeros(len(references), dtype=np.int64)
    for session in np.unique(references["session"]):
        rows = np.flatnonzero(references["session"] == session)
        first = rows[0]
        allowed = np.full(len(rows), len(rows))
        if exclude_path_m > 0:
            reach = travelled[rows] - exclude_path_m
            allowed = np.minimum(allowed, np.searchsorted(travelled[rows], reach, side="right"))
        reach = references["index"][rows] - max(exclude_frames, 1)
        allowed = np.minimum(
            allowed, np.searchsorted(references["index"][rows], reach, side="right")
        )
        counts[rows] = first + allowed
    return counts


def recognize(
    system: System,
    reference: SignatureTable,
    queries: SignatureTable,
    candidates: NDArray[np.int64],
    *,
    depth: int,
    verify_top: int,
    radius_m: float,
    rows: NDArray[np.int64] | None = None,
    method: Method = Method.MATCH,
    advance: Advance,
) -> Answers:
    """Match each query with the first ``candidates`` reference rows it is allowed.

    Parameters
    ----------
    candidates : (Q,)
    depth : ranks kept per query
    verify_top : best candidates handed to the system's geometric check, where it has one
    radius_m : how near two signatures show the same place
    rows : (Q,) which reference row each query is, where a run is matched with its own past
    method : each query by itself (match), or the whole run forward and backward (smooth): by
        relative poses where the check gives them, else over reference frames
    """
    memory = frame_memory(system, reference)
    every = np.arange(len(reference))

    def allowed(start: int, stop: int) -> NDArray[np.bool_]:
        return np.asarray(every[None, :] < candidates[start:stop, None])

    recall = recall_all(memory, queries, max(depth, verify_top), allowed, advance)
    checked = verified(system, reference, queries, recall, verify_top)
    if method is Method.SMOOTH and np.isfinite(checked.poses).any():
        checked = smoothed(system, reference, queries, candidates, checked, rows)
    elif method is Method.SMOOTH:
        whole = recall_all(memory, queries, len(reference), allowed, lambda done: None)
        checked = unchecked(smoothed_frames(whole, _starts(queries), len(reference)))
    recall, stated = checked.recall, checked.stated
    silent = np.isnan(stated)
    if silent.any():
        confidence = _confidence(system, memory, reference, radius_m, verify=verify_top > 0)
        stated = np.where(silent, confidence.stated(recall.scores[:, 0]), stated)
    decided = (recall.places[:, 0] >= 0) & (stated >= 0.5)
    return Answers(
        places=recall.places[:, :depth],
        members=recall.places[:, :depth],
        scores=recall.scores[:, :depth],
        headings_rad=recall.headings_rad[:, :depth],
        decision=np.where(decided, recall.places[:, 0], -1),
        stated=stated,
        entropy=np.full(len(queries), np.nan),
        belief=np.zeros((len(queries), 0), dtype=np.float32),
        relative=checked.relative,
        covariance=checked.covariance,
    )


def _starts(queries: SignatureTable) -> NDArray[np.bool_]:
    """Whether a query is the first of its session."""
    sessions = queries.references["session"]
    return np.concatenate([[True], sessions[1:] != sessions[:-1]])[: len(sessions)]


def _confidence(
    system: System, memory: Memory, reference: SignatureTable, radius_m: float, *, verify: bool
) -> Confidence:
    """What right and wrong scores look like in the reference run, without any truth.

    Right: the next signature of the run, half a radius on where it is denser than that. Wrong: the
    tenth best of those elsewhere (or the last, where there are fewer), which revisits of the run
    itself cannot reach.
    """
    if len(reference) < 4:
        return fit_confidence(np.array([]), np.array([]))
    every = max(1, len(reference) // SAMPLE)
    apart = path_apart(reference.references)
    rows = np.arange(0, len(reference) - 1, every)
    next_rows = np.array([ahead(apart, int(row), radius_m / 2.0) for row in rows])
    queries = [reference[int(row)] for row in rows]

    def following(start: int, stop: int) -> NDArray[np.bool_]:
        return np.asarray(np.arange(len(reference))[None, :] == next_rows[start:stop, None])

    def others(start: int, stop: int) -> NDArray[np.bool_]:
        return np.array([elsewhere(apart, int(row), radius_m) for row in rows[start:stop]])

    right = recall_all(memory, queries, 1, following, lambda done: None)
    wrong = recall_all(memory, queries, 10, others, lambda done: None)
    found = [_last(recall) for recall in (right, wrong)]
    if verify:
        return fit_confidence(*(checked_scores(system, reference, queries, *one) for one in found))
    return fit_confidence(*(scores for _, scores in found))


def path_apart(references: NDArray[np.void]) -> Callable[[int], FloatArray]:
    """Metres of travel between a row and every row: infinite between sessions, and beyond the row
    itself where none is known."""
    travelled, session = references["travelled_m"], references["session"]

    def apart(row: int) -> FloatArray:
        metres = np.abs(travelled - travelled[row])
        metres[row] = 0.0
        known = np.isfinite(metres) & (session == session[row])
        return np.asarray(np.where(known, metres, np.inf))

    return apart


def ahead(apart: Callable[[int], FloatArray], row: int, metres: float) -> int:
    """The first later row at least so far on, within twice that; else the next."""
    later = apart(row)[row + 1 :]
    far = np.flatnonzero((later >= metres) & (later <= 2.0 * metres))
    return row + 1 + (int(far[0]) if len(far) else 0)


def elsewhere(apart: Callable[[int], FloatArray], row: int, radius_m: float) -> NDArray[np.bool_]:
    """Rows that are another place: neither next to a row in the run nor a few radii of travel."""
    found = apart(row)
    rows_off = np.abs(np.arange(len(found)) - row)
    return np.asarray((rows_off > min(10, len(found) // 4)) & (found > ELSEWHERE * radius_m))


def _last(recall: Recall) -> tuple[NDArray[np.int64], FloatArray]:
    """Place and score of the last rank filled in each row; -1 and -inf where none is."""
    rows = np.arange(len(recall.places))
    last = np.maximum((recall.places >= 0).sum(axis=1) - 1, 0)
    return recall.places[rows, last], recall.scores[rows, last]
