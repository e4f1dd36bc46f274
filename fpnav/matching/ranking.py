"""Rankings of references: best first, ties by row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray


def ranked(
    scores: FloatArray, k: int, allowed: NDArray[np.bool_] | None
) -> tuple[NDArray[np.int64], FloatArray]:
    """Rows and scores of the k best columns of each row of scores (Q, R).

    Columns that are not allowed never appear; short rankings are padded with -1 and -inf.

    Returns
    -------
    columns, values : (Q, k)
    """
    scores = np.asarray(scores, dtype=np.float64)
    if allowed is not None:
        scores = np.where(allowed, scores, -np.inf)
    order = np.argsort(-scores, axis=1, kind="stable")[:, :k].astype(np.int64)
    values = np.take_along_axis(scores, order, axis=1)
    columns = np.where(np.isfinite(values), order, -1)
    missing = max(0, k - order.shape[1])
    return (
        np.pad(columns, ((0, 0), (0, missing)), constant_values=-1),
        np.pad(values, ((0, 0), (0, missing)), constant_values=-np.inf),
    )
