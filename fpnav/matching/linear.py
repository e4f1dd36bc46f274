"""Global alignment with uncertainty in numpy: the plain recurrence, many alignments at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.strings import SCORE_GRID, Scores, on_grid
from fpnav.values import FloatArray


def pair_scores(
    x_codes: NDArray[np.uint8],
    x_weights: FloatArray,
    y_codes: NDArray[np.uint8],
    y_weights: FloatArray,
    scores: Scores,
) -> FloatArray:
    """``0.5 (w_i + w_j) sigma(a_i, b_j)`` on the score grid, (..., n, m) (systems.md 1.5)."""
    sigma = scores.sigma[x_codes[..., :, None], y_codes[..., None, :]]
    return np.asarray(
        on_grid(0.5 * x_weights[..., :, None] * sigma, SCORE_GRID)
        + on_grid(0.5 * y_weights[..., None, :] * sigma, SCORE_GRID)
    )


def gap_costs(codes: NDArray[np.uint8], weights: FloatArray, scores: Scores) -> FloatArray:
    """``gamma w`` on the score grid, (..., n)."""
    return on_grid(scores.gap[codes] * weights, SCORE_GRID)


def next_row(
    row: FloatArray, pair: FloatArray, gap_x: FloatArray, gaps_y: FloatArray
) -> FloatArray:
    """One row of the Needleman-Wunsch recurrence for many alignments, along the first axis.

    ``row`` (m + 1, ...) the previous row, ``pair`` (m, ...) scores of the row's symbol of x,
    ``gap_x`` (...) its gap cost, ``gaps_y`` (m + 1, ...) cumulated gap costs of y. Chains of gaps
    are a running maximum, which is exact because all values lie on the score grid.
    """
    out = row - gap_x
    np.maximum(out[1:], row[:-1] + pair, out=out[1:])
    out += gaps_y
    np.maximum.accumulate(out, axis=0, out=out)
    out -= gaps_y
    return out


def cumulated(gaps: FloatArray) -> FloatArray:
    """Running sums with a leading zero along the first axis."""
    return np.concatenate([np.zeros((1, *gaps.shape[1:])), np.cumsum(gaps, axis=0)])


def table(pair: FloatArray, gaps_x: FloatArray, gaps_y: FloatArray) -> FloatArray:
    """Whole alignment table (n + 1, m + 1) of pair scores (n, m) and gap costs (n,), (m,)."""
    total = cumulated(gaps_y)
    rows = [-total]
    for scores, gap in zip(pair, gaps_x, strict=True):
        rows.append(next_row(rows[-1], scores, gap, total))
    return np.array(rows)


def traceback(values: FloatArray, pair: FloatArray, gaps_x: FloatArray) -> NDArray[np.int64]:
    """Partner in x of every symbol of y, -1 where it has none, (m,).

    Of equal paths the one that matches, then the one that skips x, is taken from the end.
    """
    i, j = pair.shape
    partner = np.full(j, -1, np.int64)
    while i > 0 and j > 0:
        here = values[i, j]
        if here == values[i - 1, j - 1] + pair[i - 1, j - 1]:
            i, j = i - 1, j - 1
            partner[j] = i
        elif here == values[i - 1, j] - gaps_x[i - 1]:
            i -= 1
        else:
            j -= 1
    return partner
