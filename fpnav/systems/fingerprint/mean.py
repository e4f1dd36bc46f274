"""The mean fingerprint of a place: pairwise fusion of what was seen there (systems.md 1.7)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.systems.fingerprint.symbols import CAMERA, LASER, codes, unsigned
from fpnav.systems.fingerprint.symbols import C as CORNER
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Mean:
    """Running mean of N observations.

    ``features`` : (F,) FEATURE in the frame of the first observation, by angle; the certainty of
    each is the running estimate of the probability that it is seen here. ``arcs`` (2, 2) what the
    sensors covered in any of them.
    """

    features: NDArray[Any]
    arcs: FloatArray
    observations: int


@dataclass(frozen=True, slots=True)
class FuseRule:
    """How features become one and when they are forgotten."""

    merge_rad: float
    settle: int
    certainty_min: float
    features_max: int


def fuse(
    mean: Mean,
    features: NDArray[Any],
    arcs: FloatArray,
    matched: NDArray[np.int64],
    turn_rad: float,
    rule: FuseRule,
    observations: int = 1,
) -> Mean:
    """The mean after one more observation, or after another mean of several.

    Parameters
    ----------
    features, arcs : what was seen, in its own frame
    matched : (P, 2) rows of the mean's and of the new features that the alignment matched
    turn_rad : turn to add to the new angles to bring them into the mean's frame
    """
    old, new = mean.features.copy(), features.copy()
    new["angle_rad"] = unsigned(new["angle_rad"] + turn_rad)
    turned = np.array(arcs)
    turned[:, 0] += turn_rad
    n, m = mean.observations, observations
    keep_old, keep_new = np.ones(len(old), bool), np.ones(len(new), bool)
    keep_old[matched[:, 0]] = keep_new[matched[:, 1]] = False
    rows = np.concatenate(
        [
            _blended(old[matched[:, 0]], new[matched[:, 1]], n, m),
            _faded(old[keep_old], turned, n, m),
            _faded(new[keep_new], mean.arcs, m, n),
        ]
    )
    return Mean(
        _pruned(_merged(rows, rule.merge_rad), n + m, rule), _united(mean.arcs, turned), n + m
    )


def strongest(mean: Mean, count: int) -> Mean:
    """The mean with its ``count`` most certain features."""
    kept = _strongest(mean.features, count)
    return Mean(mean.features[kept], mean.arcs, mean.observations)


def _blended(old: NDArray[Any], new: NDArray[Any], n: int, m: int) -> NDArray[Any]:
    """Matched features: means weighted by evidence; of two hues that with more of it stays."""
    weight_old = n * old["certainty"].astype(np.float64)
    weight_new = m * new["certainty"].astype(np.float64)
    share = weight_new / np.maximum(weight_old + weight_new, 1e-12)
    rows = np.where(weight_new > weight_old, new, old)
    turn = (new["angle_rad"] - old["angle_rad"] + np.pi) % TAU - np.pi
    rows["angle_rad"] = unsigned(old["angle_rad"] + share * turn)
    rows["certainty"] = (weight_old + weight_new) / (n + m)
    rows["width_rad"] = old["width_rad"] + share * (new["width_rad"] - old["width_rad"])
    rows["range_m"] = old["range_m"] + share * (new["range_m"] - old["range_m"])
    rows["seen"] = old["seen"] + new["seen"]
    return rows


def _faded(rows: NDArray[Any], other_arcs: FloatArray, n: int, m: int) -> NDArray[Any]:
    """Features the other side did not see, though its sensors covered them."""
    rows = rows.copy()
    kind = np.where(codes(rows["type"]) == CORNER, LASER, CAMERA)
    centre, width = other_arcs[kind, 0], other_arcs[kind, 1]
    off = np.abs((rows["angle_rad"] - centre + np.pi) % TAU - np.pi)
    covered = (off <= width / 2.0) & (width > 0.0)
    rows["certainty"] = np.where(covered, rows["certainty"] * (n / (n + m)), rows["certainty"])
    return rows


def _merged(rows: NDArray[Any], merge_rad: float) -> NDArray[Any]:
    """Neighbouring features of one type nearer than ``merge_rad`` become one; evidence adds."""
    out = []
    for letter in np.unique(rows["type"]):
        same = np.sort(rows[rows["type"] == letter], order="angle_rad")
        out.append(_merged_type(same, merge_rad))
    found = np.concatenate([rows[:0], *out])
    return found[np.lexsort((found["type"], found["angle_rad"]))]


def _merged_type(rows: NDArray[Any], merge_rad: float) -> NDArray[Any]:
    while len(rows) > 1:
        gaps = np.diff(rows["angle_rad"], append=rows["angle_rad"][0] + TAU)
        at = int(np.argmin(gaps))
        if gaps[at] >= merge_rad:
            break
        other = (at + 1) % len(rows)
        rows[at] = _joined(rows[at : at + 1], rows[other : other + 1])[0]
        rows = np.sort(np.delete(rows, other), order="angle_rad")
    return rows


def _joined(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    row = _blended(first, second, 1, 1)
    row["certainty"] = np.minimum(1.0, first["certainty"] + second["certainty"])
    row["seen"] = np.maximum(first["seen"], second["seen"])
    return row


def _pruned(rows: NDArray[Any], observations: int, rule: FuseRule) -> NDArray[Any]:
    if observations > rule.settle:
        rows = rows[rows["certainty"] >= rule.certainty_min]
    return rows[_strongest(rows, rule.features_max)]


def _strongest(rows: NDArray[Any], count: int) -> NDArray[np.int64]:
    """Rows of the ``count`` most certain features, in their order; of equal ones the first."""
    order = np.argsort(-rows["certainty"].astype(np.float64), kind="stable")
    return np.sort(order[:count])


def _united(first: FloatArray, second: FloatArray) -> FloatArray:
    """Smallest arc that holds both, per sensor."""
    out = np.array(first)
    for kind, (a, b) in enumerate(zip(first, second, strict=True)):
        if a[1] <= 0.0 or b[1] <= 0.0:
            out[kind] = b if a[1] <= 0.0 else a
            continue
        apart = (b[0] - a[0] + np.pi) % TAU - np.pi
        low = min(-a[1] / 2.0, apart - b[1] / 2.0)
        high = max(a[1] / 2.0, apart + b[1] / 2.0)
        width = min(high - low, TAU)
        middle = a[0] if width >= TAU else a[0] + (low + high) / 2.0
        out[kind] = (middle + np.pi) % TAU - np.pi, width
    return out
