"""Frame-to-frame matches smoothed along a run where nothing says how the robot moved.

A hidden Markov model over the reference frames: from one query to the next the match moves by a
number of frames within a window, or jumps. How wide the window is depends on how the two runs were
recorded and is chosen by the marginal likelihood of the data; where no window explains the run
better than queries that know nothing of one another, nothing is smoothed (systems.md 1.9.2, after
ProbFiltersVPR and the bounds of PlaceNav).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import Recall
from fpnav.values import FloatArray

WINDOWS = ((-1, 3), (-2, 6), (-2, 10), (-3, 1), (-6, 2), (-10, 2))
"""Frames a match may move by between two queries, the same way as the reference or against it."""

JUMP = 0.01
SHARPNESS = 2.0 * np.log(5.0)
"""A score 95 % of the spread of its row above another is so many nats more likely."""

ALONG = 5
"""Queries on either side over which the score of a smoothed match is the mean."""


def smoothed_frames(recall: Recall, starts: NDArray[np.bool_], count: int) -> Recall:
    """Rankings after the whole run was seen, by the probability of each reference frame.

    The scores of a row become the mean score along the smoothed path, lower ranks that of the row
    before less what they are less probable.

    Parameters
    ----------
    recall : of all ``count`` reference frames, ids 0 .. count - 1
    starts : (Q,) whether a query begins a run of its own
    """
    scores, turns = _by_frame(recall, count)
    likelihood = likelihoods(scores)
    evidence = [_forward(likelihood, starts, window)[1] for window in WINDOWS]
    alone = float(np.log(np.maximum(likelihood.mean(axis=1), 1e-300)).sum())
    best = int(np.argmax(evidence))
    if not evidence[best] > alone:
        return recall
    belief = posterior(likelihood, starts, WINDOWS[best])
    belief[~np.isfinite(scores)] = -1.0
    depth = recall.places.shape[1]
    order = np.argsort(-belief, axis=1, kind="stable")[:, :depth]
    kept = np.take_along_axis(belief, order, axis=1)
    there = kept >= 0.0
    first = np.take_along_axis(scores, order[:, :1], axis=1)[:, 0]
    mean = _mean_along(np.where(there[:, 0], first, np.nan), starts)
    return Recall(
        np.where(there, order, -1),
        np.where(there, mean[:, None] + kept - kept[:, :1], -np.inf),
        np.where(there, np.take_along_axis(turns, order, axis=1), np.nan),
    )


def likelihoods(scores: FloatArray) -> FloatArray:
    """exp(SHARPNESS / spread (s - max s)) of each row, the spread between its 2.5 and 97.5 %
    quantiles; 0 where a frame is no candidate, flat rows where nothing is known."""
    finite = np.isfinite(scores)
    known = np.where(finite, scores, np.nan)
    known[~finite.any(axis=1)] = 0.0
    low, high = np.nanquantile(known, [0.025, 0.975], axis=1, keepdims=True)
    rate = np.where(high - low > 1e-12, SHARPNESS / np.maximum(high - low, 1e-12), 0.0)
    values = np.exp(rate * (known - np.nanmax(known, axis=1, keepdims=True)))
    return np.asarray(np.nan_to_num(values, nan=0.0))


def posterior(
    likelihood: FloatArray, starts: NDArray[np.bool_], window: tuple[int, int]
) -> FloatArray:
    """Probability of each frame given all queries, (Q, R): forward and backward."""
    belief, _ = _forward(likelihood, starts, window)
    message = np.ones(likelihood.shape[1])
    back = -window[1], -window[0]
    for row in range(len(likelihood) - 2, -1, -1):
        ahead = likelihood[row + 1] * message
        message = np.ones_like(message) if starts[row + 1] else _normalised(_moved(ahead, back))
        belief[row] = _normalised(belief[row] * message)
    return belief


def _forward(
    likelihood: FloatArray, starts: NDArray[np.bool_], window: tuple[int, int]
) -> tuple[FloatArray, float]:
    """Belief after each query and the log marginal likelihood of all."""
    count = likelihood.shape[1]
    belief, total = np.empty_like(likelihood), 0.0
    for row in range(len(likelihood)):
        fresh = row == 0 or starts[row]
        predicted = np.full(count, 1.0 / count) if fresh else _moved(belief[row - 1], window)
        joint = likelihood[row] * predicted
        total += float(np.log(max(float(joint.sum()), 1e-300)))
        belief[row] = _normalised(joint)
    return belief, total


def _moved(belief: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Belief after a step: uniform over the window, a jump to anywhere with probability JUMP."""
    low, high = window
    sums = np.concatenate([[0.0], np.cumsum(belief)])
    frames = np.arange(len(belief))
    first = np.clip(frames - high, 0, len(belief))
    stop = np.clip(frames - low + 1, 0, len(belief))
    near = (sums[stop] - sums[first]) / (high - low + 1)
    return np.asarray((1.0 - JUMP) * near + JUMP * belief.sum() / len(belief))


def _normalised(values: FloatArray) -> FloatArray:
    total = float(values.sum())
    return values / total if total > 0.0 else np.full(len(values), 1.0 / len(values))


def _by_frame(recall: Recall, count: int) -> tuple[FloatArray, FloatArray]:
    scores = np.full((len(recall.places), count), -np.inf)
    turns = np.full((len(recall.places), count), np.nan)
    rows, ranks = np.nonzero(recall.places >= 0)
    scores[rows, recall.places[rows, ranks]] = recall.scores[rows, ranks]
    turns[rows, recall.places[rows, ranks]] = recall.headings_rad[rows, ranks]
    return scores, turns


def _mean_along(values: FloatArray, starts: NDArray[np.bool_]) -> FloatArray:
    """Mean of the known values within ALONG queries of the same run; NaN rows stay -inf."""
    run = np.cumsum(starts)
    out = np.full(len(values), -np.inf)
    for row in np.flatnonzero(np.isfinite(values)):
        near = slice(max(0, row - ALONG), row + ALONG + 1)
        out[row] = float(np.nanmean(np.where(run[near] == run[row], values[near], np.nan)))
    return out
