"""Which queries of a result are shown one by one."""

from __future__ import annotations

import numpy as np

from fpnav.evaluation.evaluate import Evaluation

_EACH = 8


def chosen(evaluation: Evaluation) -> list[int]:
    """Query rows: the most confident wrong decisions, then right ones spread over the run."""
    table = evaluation.table
    wrong = np.flatnonzero(table["outcome"] == 1)
    sure = np.nan_to_num(table["score"][wrong], nan=-np.inf)
    wrong = wrong[np.argsort(-sure, kind="stable")][:_EACH]
    right = np.flatnonzero(table["outcome"] == 0)
    if len(right):
        right = right[np.unique(np.linspace(0, len(right) - 1, _EACH).astype(int))]
    return [int(query) for query in [*wrong, *right]]
