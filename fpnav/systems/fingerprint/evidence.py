"""How much what an overlay of two scans shows is worth: a logistic learned on recordings.

Learned by ``python -m benchmarks.laser_verification`` on two CARMEN logs with corrected poses,
intel (294 queries) and freiburg-079 (236), same place = 1.5 m and 45 degrees; which columns are
used was chosen with each log tested by the weights of the other. Other recordings use the weights
of both, below.
"""

from __future__ import annotations

import numpy as np

from fpnav.values import FloatArray

WEIGHTS = {
    "agree_least": 9.59,
    "conflict": -49.51,
    "seen_least": -1.22,
    "distance_m": -82.72,
    "offset_beyond": -14.14,
    "turn_beyond": -25.52,
    "behind_best": -1.80,
}
"""Shares of the scan that agree and are seen, the lesser of both ways, and that conflict, their
mean; root mean square distance of what was matched, metres; how far offset and turn go beyond what
surely is the same place, in units of what still is; balance less that of the query's best."""

BIAS = -0.75
NAMES = tuple(WEIGHTS)
LEAST = -30.0


def logits(features: FloatArray) -> FloatArray:
    """Log-odds of rows of features (n, NAMES), at least LEAST."""
    weights = np.array(list(WEIGHTS.values()))
    return np.asarray(np.maximum(features @ weights + BIAS, LEAST))
