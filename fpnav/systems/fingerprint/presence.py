"""How likely a feature is seen again: a logistic of what its fingerprint says of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.fingerprint.following import ranges
from fpnav.values import FloatArray

COLUMNS = ("certainty", "seen", "parallax", "range", "ahead")
"""What is looked at: certainty as extracted; how many of the last fingerprints had it; how fast its
bearing turns, radians a metre of travel straight on; logarithm of its range in metres; cosine of
its bearing, since what is ahead comes nearer and what is behind goes."""

MOST_PARALLAX, RANGES_M = 1.5, (0.3, 30.0)
RIDGE, STEPS, LEAST_SPREAD = 3.0, 30, 1e-6
LIMIT = 30.0


def table(features: NDArray[Any]) -> FloatArray:
    """Evidence of each feature of one fingerprint, (F, COLUMNS)."""
    far, bearing = ranges(features), features["angle_rad"]
    return np.column_stack(
        [
            features["certainty"].astype(np.float64),
            features["seen"].astype(np.float64),
            np.minimum(np.abs(np.sin(bearing)) / far, MOST_PARALLAX),
            np.log(np.clip(far, *RANGES_M)),
            np.cos(bearing),
        ]
    )


def probability(evidence: FloatArray, lean: FloatArray) -> FloatArray:
    """Probability (M,) by the weights of COLUMNS and the bias, ``lean`` (COLUMNS + 1,)."""
    logits = evidence @ lean[:-1] + lean[-1]
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(logits, -LIMIT, LIMIT))))


def fitted_lean(evidence: FloatArray, again: NDArray[np.bool_]) -> FloatArray:
    """Weights and bias of a logistic with a ridge on standardised columns, by Newton's steps.

    A column that is the same in all rows says nothing.
    """
    mean, spread = evidence.mean(axis=0), evidence.std(axis=0)
    spread = np.where(spread > LEAST_SPREAD, spread, np.inf)
    x = np.column_stack([(evidence - mean) / spread, np.ones(len(evidence))])
    ridge = RIDGE * np.append(np.ones(evidence.shape[1]), 1e-6)
    weights = np.zeros(x.shape[1])
    for _ in range(STEPS):
        p = probability(x[:, :-1], weights)
        hessian = (x * (p * (1.0 - p))[:, None]).T @ x + np.diag(ridge)
        step = np.linalg.solve(hessian, x.T @ (p - again) + ridge * weights)
        weights -= step
        if np.abs(step).max() < 1e-9:
            break
    raw = weights[:-1] / spread
    return np.append(raw, weights[-1] - raw @ mean)
