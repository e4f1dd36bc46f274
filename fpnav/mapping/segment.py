"""Where one place ends and the next begins: thresholds on a stream of novelties."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fpnav.systems.base import MapRule
from fpnav.values import FloatArray

OTSU_LIMITS = (0.3, 0.8)
_BINS = 64


def resolve_threshold(rule: MapRule, consecutive: Callable[[], FloatArray]) -> float:
    """The number a rule's threshold stands for, given the novelties of consecutive signatures.

    ``auto`` is their quantile at 1 - (K - 1) / (N - 1) for K places of N signatures, and without
    K the Otsu valley of their histogram limited to 0.3 .. 0.8 (systems.md 1.8).

    Parameters
    ----------
    consecutive : gives (N - 1,) novelty of each signature against the one before it; asked only
        where the threshold is not a number
    """
    if not isinstance(rule.threshold, str):
        return float(rule.threshold)
    values = consecutive()
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return float(np.mean(OTSU_LIMITS))
    if rule.threshold == "auto" and rule.nodes == 1:
        return float(np.nextafter(values.max(), np.inf))
    if rule.threshold == "auto" and rule.nodes > 1:
        return float(np.quantile(values, max(0.0, 1.0 - (rule.nodes - 1) / len(values))))
    return float(np.clip(otsu(values), *OTSU_LIMITS))


def otsu(values: FloatArray) -> float:
    """Threshold in [0, 1] that best splits the values in two classes (Otsu 1979)."""
    counts, edges = np.histogram(np.clip(values, 0.0, 1.0), bins=_BINS, range=(0.0, 1.0))
    centres = 0.5 * (edges[:-1] + edges[1:])
    below = np.cumsum(counts)
    above = below[-1] - below
    sums = np.cumsum(counts * centres)
    with np.errstate(divide="ignore", invalid="ignore"):
        means = sums / below, (sums[-1] - sums) / above
        between = below * above * (means[0] - means[1]) ** 2
    best = np.nan_to_num(between, nan=-1.0)
    ties = np.flatnonzero(best == best.max())
    return float(edges[1:][ties].mean())
