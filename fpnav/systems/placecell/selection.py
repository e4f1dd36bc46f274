"""Which landmarks are worth keeping, by what training showed, chosen greedily.

A triplet is worth, at a training panorama of its place, its activity there less its best activity
at another place. A set is worth, at a panorama, the root of the sum of its triplets: more than one
witness, but each adds less than the one before. Summed over panoramas that is monotone submodular,
so the greedy choice is within 1 - 1/e of the best.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

EVIDENCE = np.dtype([("observation", "<i4"), ("triplet", "<i4"), ("activity", "<f4")])
"""Activity of a triplet at one training panorama of its own place."""


def select(worth: FloatArray, budget: int) -> NDArray[np.int64]:
    """Columns chosen greedily, at most ``budget``, ascending.

    Among columns that add the same those worth most in sum are taken; ties by column.

    Parameters
    ----------
    worth : (observations, triplets), not negative
    """
    sums = np.zeros((len(worth), 1))
    total = worth.sum(axis=0)
    free = np.ones(worth.shape[1], bool)
    chosen: list[int] = []
    while len(chosen) < min(budget, worth.shape[1]):
        gain = (np.sqrt(sums + worth) - np.sqrt(sums)).sum(axis=0)
        candidates = np.flatnonzero(free)
        rank = np.lexsort((candidates, -total[candidates], -np.round(gain[candidates], 9)))
        best = int(candidates[rank[0]])
        chosen.append(best)
        free[best] = False
        sums += worth[:, [best]]
    return np.sort(np.array(chosen, dtype=np.int64))


def worth_of(
    evidence: NDArray[np.void], triplets: NDArray[np.int64], elsewhere: FloatArray
) -> FloatArray:
    """Worth (observations, n) of the given triplets at the panoramas there is evidence of.

    ``elsewhere`` : (n,) best activity of each at other places
    """
    column = np.searchsorted(triplets, evidence["triplet"])
    column = np.minimum(column, len(triplets) - 1)
    own = triplets[column] == evidence["triplet"]
    rows, observation = np.unique(evidence["observation"][own], return_inverse=True)
    activity = np.zeros((len(rows), len(triplets)))
    np.maximum.at(activity, (observation, column[own]), evidence["activity"][own])
    return np.maximum(activity - elsewhere[None, :], 0.0)
