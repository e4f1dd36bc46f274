"""Headings without a compass: a search all around, or the vote of recognised landmarks."""

from __future__ import annotations

import math

import numpy as np

from fpnav.geometry import TAU
from fpnav.values import FloatArray

BINS = 360
SIGMA_RAD = math.radians(6.0)


def search_grid(step_rad: float) -> FloatArray:
    """Headings tried, evenly around the circle from 0, at most ``step_rad`` apart."""
    count = max(1, math.ceil(TAU / step_rad - 1e-9))
    return np.asarray(TAU * np.arange(count) / count)


def visual_heading(level: FloatArray, bearing_rad: FloatArray, azimuth_rad: FloatArray) -> float:
    """Heading that recognised landmarks vote for; NaN without any.

    Every landmark recognised at a bearing votes for azimuth - bearing with its level, on 360 bins
    smoothed by a Gaussian of 6 degrees.
    """
    if len(level) == 0 or level.max() <= 0.0:
        return math.nan
    votes = np.mod(azimuth_rad - bearing_rad, TAU)
    bins = np.floor(votes * BINS / TAU).astype(np.int64) % BINS
    field = np.bincount(bins, weights=level, minlength=BINS)
    around = (np.arange(BINS) + BINS // 2) % BINS - BINS // 2
    bump = np.exp(-0.5 * (around * TAU / BINS / SIGMA_RAD) ** 2)
    smooth = np.fft.irfft(np.fft.rfft(field) * np.fft.rfft(bump), BINS)
    best = int(np.argmax(np.round(smooth, 9)))
    return (best + 0.5) * TAU / BINS
