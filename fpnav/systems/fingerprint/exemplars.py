"""A few exemplars of a place beside its mean: means of what looked most alike there.

A mean blurs what a long place looks like from its two ends (systems.md 1.13, I-A6). Every
fingerprint starts as an exemplar of its own; while there are too many, the two whose fusion
loses least become one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fpnav.systems.fingerprint.aligner import Aligner
from fpnav.systems.fingerprint.mean import Mean
from fpnav.values import FloatArray


def added(exemplars: Sequence[Mean], one: Mean, most: int, aligner: Aligner) -> list[Mean]:
    """The exemplars, all in the place's frame, with one more taken in; at most ``most``."""
    found = [*exemplars, one]
    while len(found) > max(most, 0):
        if len(found) == 1:
            return []
        first, second = closest(found, aligner)
        found[first] = aligner.fused(found[first], found[second], turn_rad=0.0)
        del found[second]
    return found


def closest(exemplars: Sequence[Mean], aligner: Aligner) -> tuple[int, int]:
    """The two whose fusion loses least, first < second; of equals the first.

    The loss is their dissimilarity weighed as in Ward's method, n m / (n + m), so that no
    exemplar swallows the others.
    """
    loss = losses(exemplars, aligner)
    at = int(np.argmin(loss))
    first, second = divmod(at, len(exemplars))
    return first, second


def losses(exemplars: Sequence[Mean], aligner: Aligner) -> FloatArray:
    """Loss of fusing each pair, (E, E); infinite on and below the diagonal."""
    strings = [aligner.pack([mean]) for mean in exemplars]
    counts = [mean.observations for mean in exemplars]
    out = np.full((len(exemplars), len(exemplars)), np.inf)
    for i in range(len(exemplars)):
        for j in range(i + 1, len(exemplars)):
            share = counts[i] * counts[j] / (counts[i] + counts[j])
            out[i, j] = share * (1.0 - aligner.probability(strings[i], strings[j]))
    return out
