"""Partial fields of view: which symbols of two strings the other one could have seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching.strings import Scores, Strings
from fpnav.values import FloatArray

SLACK_RAD = 1e-6


def alike(first: FloatArray, second: FloatArray) -> NDArray[np.bool_]:
    """Whether every kind of sensor covers as much in both, so that coverage excuses nothing.

    ``first``, ``second`` : (..., A, 2), broadcasting; the answer is (...).
    """
    return np.asarray((np.abs(first[..., 1] - second[..., 1]) <= SLACK_RAD).all(axis=-1))


def comparable(
    x: Strings, i: int, y: Strings, j: int, scores: Scores
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Symbols of strings i and j that the other's sensors could see, for each rotation of i.

    Rotation k of x puts x_k where y begins, which is the hypothesis that the two headings differ
    by ``angle(y_0) - angle(x_k)``. Where, under it, what one covered lies wholly within what the
    other covered, symbols outside neither earn nor cost nor count (systems.md 1.5, partial field
    of view); a kind of sensor that one of them lacks excuses all its symbols. Arcs that overlap
    in part excuse nothing: comparing less would look like matching better.

    Returns
    -------
    (n, n) symbols of x in its own order, (n, m) symbols of y, row k for rotation k.
    """
    xs, ys = slice(x.offsets[i], x.offsets[i + 1]), slice(y.offsets[j], y.offsets[j + 1])
    ax, ay = x.angles_rad[xs], y.angles_rad[ys]
    turn = ay[0] - ax
    within = _within(x.arcs[i], y.arcs[j], turn)
    seen_x = _covered(ax[None, :] + turn[:, None], y.arcs[j], within)
    seen_y = _covered(ay[None, :] - turn[:, None], x.arcs[i], within)
    return (
        scores.visible[x.codes[xs][None, :], seen_x],
        scores.visible[y.codes[ys][None, :], seen_y],
    )


def _off(angles: FloatArray) -> FloatArray:
    """Distance to the nearest multiple of 2 pi; the compiled kernel rounds the same way."""
    return np.asarray(np.abs(angles - TAU * np.rint(angles / TAU)))


def _covered(angles: FloatArray, arcs: FloatArray, within: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Bit set of the kinds of sensor that cover each angle (n, ...), or excuse nothing."""
    bits = np.zeros(angles.shape, np.int64)
    for kind, (centre, width) in enumerate(arcs):
        inside = (_off(angles - centre) <= width / 2.0 + SLACK_RAD) & (width > 0.0)
        bits |= (inside | ~within[:, kind, None]).astype(np.int64) << kind
    return bits


def _within(first: FloatArray, second: FloatArray, turn: FloatArray) -> NDArray[np.bool_]:
    """Kinds of sensor where one arc lies within the other after each turn, (n, A)."""
    a, b = first[None, :, 1], second[None, :, 1]
    apart = _off(first[None, :, 0] + turn[:, None] - second[None, :, 0])
    return np.asarray(
        (apart <= np.abs(a - b) / 2.0 + SLACK_RAD)
        | (np.minimum(a, b) <= 0.0)
        | (np.maximum(a, b) >= TAU - SLACK_RAD)
    )
