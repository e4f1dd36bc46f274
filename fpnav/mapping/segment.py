"""Where one place ends and the next begins: a threshold on novelty, or changes of the whole run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.changepoint import contrast, segment_by_contrast, similarity_band
from fpnav.systems.base import MapRule, System
from fpnav.values import FloatArray, Signature

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


def change_points(
    system: System, signatures: Sequence[Signature], rule: MapRule
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Contrast at each signature, and the place it starts or joins, by changes of each session.

    Offline: what follows a border counts as much as what came before it (systems.md 1.13, I-A4).

    Returns
    -------
    contrast : (N,), NaN where a session starts
    owner : (N,) from 0 in travel order
    """
    sessions = np.array([signature.reference.session for signature in signatures])
    gains, starts = np.full(len(signatures), np.nan), np.zeros(len(signatures), dtype=np.int64)
    for rows in np.split(np.arange(len(sessions)), np.flatnonzero(np.diff(sessions)) + 1):
        views = [signatures[int(row)] for row in rows]
        band = similarity_band(len(views), rule.window + 1, partial(_alike, system, views))
        gains[rows] = contrast(band)
        starts[rows[segment_by_contrast(gains[rows], rule.penalty, rule.window)]] = 1
        gains[rows[0]] = np.nan
    return gains, np.cumsum(starts) - 1


def _alike(system: System, views: Sequence[Signature], i: int, j: int) -> float:
    return system.similarity(views[i], views[j])


def otsu(values: FloatArray) -> float:
    """Threshold in [0, 1] that best splits the values in two classes (Otsu 1979).

    The middle of the valley where it is wide; of equal valleys the lower.
    """
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
    valley = ties[ties - ties[0] == np.arange(len(ties))]
    return float(edges[1:][valley].mean())
