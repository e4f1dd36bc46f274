"""How much what overlays of scans show is worth: two logistics learned on recordings.

The first looks at one overlay. Learned on two CARMEN logs with corrected poses, intel (294 queries)
and freiburg-079 (236), same place = 1.5 m and 45 degrees; which columns are used was chosen with
each log tested by the weights of the other.

The second weighs its log-odds by what else the query's candidates show. Learned on the best
candidate of every query of five recordings: intel (883), freiburg-079 (709), killian (1126),
belgioioso (338) and Wean Hall, first run to third (246). With one recording left out in turn, its
expected calibration error and Brier skill on that one are .018 and .88, .024 and .93, .049 and .61,
.015 and .90, .119 and .22, in that order; 40 sets of columns were tried so.
``python -m benchmarks.laser_verification`` learns both again and prints these figures.
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

AROUND = {"passing": -0.997, "fit_elsewhere": -0.734}
"""Logarithm of 1 + other places whose log-odds pass, and balance of the RANKth place after the
best, unrefined."""

AROUND_OWN, AROUND_BIAS = 1.008, -0.501
AROUND_NAMES = tuple(AROUND)
PASSES, RANK, NO_FIT = -1.0, 7, -2.0
"""Log-odds from which a place passes; which place's fit is looked at, and its value where there are
not so many."""

ENOUGH = 8
"""Candidates from which on they show how alike other places look."""


def logits(features: FloatArray) -> FloatArray:
    """Log-odds of rows of features (n, NAMES), at least LEAST."""
    weights = np.array(list(WEIGHTS.values()))
    return np.asarray(np.maximum(features @ weights + BIAS, LEAST))


def among(own: FloatArray, around: FloatArray) -> FloatArray:
    """Log-odds (n,) of one query's candidates, weighed by what is around, (AROUND_NAMES,)."""
    best = float(own.max())
    moved = AROUND_OWN * best + float(around @ np.array(list(AROUND.values()))) + AROUND_BIAS
    return np.asarray(np.maximum(own + moved - best, LEAST))
