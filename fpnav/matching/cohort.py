"""Scores in units of how scores spread over a cohort: a fixed sample of the mapping run.

What is like everything says little. The cohort does not depend on the candidates, so a score is
the same whoever else is asked about (test normalisation, Auckenthaler et al. 2000).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

SIZE = 64
KEPT = 0.9
"""Share of the cohort, the least alike, that counts: the rest may show the query's own place."""


def cohort_rows(count: int, size: int = SIZE) -> NDArray[np.int64]:
    """At most ``size`` rows of ``count``, evenly spaced."""
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, size))).astype(np.int64))


def standard_scores(scores: FloatArray, cohort: FloatArray, least: float = 1e-9) -> FloatArray:
    """Scores (n,) less the mean of a cohort's (c,), by its spread; 0 where it has none.

    ``least`` is added to the spread.
    """
    kept = np.sort(cohort)[: max(1, int(KEPT * len(cohort)))]
    spread = float(kept.std()) if len(kept) > 1 else 0.0
    if not spread > 0.0:
        return np.zeros_like(scores)
    return np.asarray((scores - kept.mean()) / (spread + least), np.float64)
