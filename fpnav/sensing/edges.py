"""Vertical edges of a view: columns where many pixels see a horizontal step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

STEP_MIN = 0.06
STEP_FULL = 0.25
STEEPNESS = 1.5
SMOOTH_COLUMNS = 3
RADIUS_COLUMNS = 6


def vertical_edges(grey: NDArray[np.float32], *, circular: bool) -> tuple[FloatArray, FloatArray]:
    """Columns and uncertainties of vertical edges (systems.md 1.3.2).

    Every pixel with a steep horizontal step votes for its column; columns above mean plus
    standard deviation of the tallies (Siegwart and Nourbakhsh, fingerprint extraction) that are
    the largest within 3 degrees are edges.

    Parameters
    ----------
    grey : (H, W) float32 in [0, 1], 0.5 degrees a column

    Returns
    -------
    columns : (E,) fractional, increasing, in [-0.5, W - 0.5]
    certainty : (E,) in [0.3, 1]
    """
    tally = smooth(column_votes(grey, circular=circular), SMOOTH_COLUMNS, circular=circular)
    threshold = float(tally.mean() + tally.std())
    peaks = _peaks(tally, threshold, circular=circular)
    span = max(float(tally.max(initial=0.0)) - threshold, 0.0) + 1e-9
    certainty = np.clip(0.3 + 0.7 * (tally[peaks] - threshold) / span, 0.3, 1.0)
    return peaks + _sub_column(tally, peaks, circular=circular), certainty


def column_votes(grey: NDArray[np.float32], *, circular: bool) -> FloatArray:
    """Sum over each column of the strengths of its edge pixels, (W,)."""
    across, down = _gradients(grey, circular=circular)
    votes = (across > STEP_MIN) & (across > STEEPNESS * down)
    strength = np.minimum(across * np.float32(1.0 / STEP_FULL), np.float32(1.0))
    return np.asarray((strength * votes).sum(axis=0, dtype=np.float64))


def smooth(values: FloatArray, columns: int, *, circular: bool) -> FloatArray:
    """Box mean over an odd number of columns along the last axis."""
    half = columns // 2
    width = [(0, 0)] * (values.ndim - 1) + [(half + 1, half)]
    padded = np.pad(values, width, mode="wrap" if circular else "edge")
    total = np.cumsum(padded, axis=-1)
    return np.asarray((total[..., columns:] - total[..., :-columns]) / columns)


def _gradients(
    grey: NDArray[np.float32], *, circular: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Absolute central differences across and down, (H, W) each; zero at open borders."""
    across, down = np.zeros_like(grey), np.zeros_like(grey)
    np.abs(grey[:, 2:] - grey[:, :-2], out=across[:, 1:-1])
    np.abs(grey[2:] - grey[:-2], out=down[1:-1])
    if circular and grey.shape[1] > 2:
        across[:, 0] = np.abs(grey[:, 1] - grey[:, -1])
        across[:, -1] = np.abs(grey[:, 0] - grey[:, -2])
    return across, down


def _peaks(tally: FloatArray, threshold: float, *, circular: bool) -> NDArray[np.int64]:
    """Columns above the threshold that are the largest within the radius; of equals the first."""
    reach = RADIUS_COLUMNS
    padded = np.pad(tally, reach, mode="wrap" if circular else "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    before = windows[:, :reach].max(axis=1)
    if not circular and len(tally):
        before[0] = -np.inf
    after = windows[:, reach + 1 :].max(axis=1)
    found = (tally > threshold) & (tally > before) & (tally >= after)
    return np.flatnonzero(found)


def _sub_column(tally: FloatArray, peaks: NDArray[np.int64], *, circular: bool) -> FloatArray:
    """Offset of the vertex of the parabola through each peak and its neighbours."""
    padded = np.pad(tally, 1, mode="wrap" if circular else "edge")
    left, top, right = padded[peaks], padded[peaks + 1], padded[peaks + 2]
    bend = left - 2.0 * top + right
    safe = np.where(bend < -1e-12, bend, -1.0)
    offset = np.where(bend < -1e-12, 0.5 * (left - right) / safe, 0.0)
    return np.asarray(np.clip(offset, -0.5, 0.5))
