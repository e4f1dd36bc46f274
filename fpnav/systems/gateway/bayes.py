"""The Bayes net of Kortenkamp and Weymouth: a place is told by its scene and its gateway.

Both are weighed equally, so that the posterior is a plain product (systems.md 3.8).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fpnav.values import FloatArray

LEAST = 1e-30
"""Evidence of zero as a number with a logarithm."""


def normalised(values: ArrayLike) -> FloatArray:
    """Values over the last axis divided by their sum; even where that is zero."""
    values = np.asarray(values, dtype=np.float64)
    total = values.sum(axis=-1, keepdims=True)
    even = np.full(values.shape, 1.0 / max(values.shape[-1], 1))
    return np.where(total > 0.0, values / np.where(total > 0.0, total, 1.0), even)


def vision_likelihood(scores: ArrayLike, floor: float) -> FloatArray:
    """Likelihood of each place from the match scores (..., P); no match at all counts ``floor``.

    (.25, .90, .75) gives (.13, .47, .40).
    """
    scores = np.asarray(scores, dtype=np.float64)
    return normalised(np.where(scores > 0.0, scores, floor))


def posterior(prior: ArrayLike, vision: ArrayLike, sonar: ArrayLike) -> FloatArray:
    """Probability of each place: the product of prior and both likelihoods, normalised."""
    product = np.asarray(prior, np.float64) * np.asarray(vision, np.float64)
    return normalised(product * np.asarray(sonar, np.float64))


def log_evidence(values: ArrayLike) -> FloatArray:
    """Logarithm of likelihoods, those of zero very small but finite."""
    return np.log(np.maximum(np.asarray(values, dtype=np.float64), LEAST))
