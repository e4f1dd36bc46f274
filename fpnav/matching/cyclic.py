"""Exact cyclic alignment with uncertainty: one string against many, pruned, with orientation.

Two engines give the same answers to the last bit: numpy, and numba kernels that are some fifty
times faster but take half a second to load. The second is loaded when a process has done, or is
about to do, enough cells of alignment tables for that to pay.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching import rotations
from fpnav.matching.bounds import Bags, ratio_bounds
from fpnav.matching.strings import Scores, Strings
from fpnav.values import FloatArray

WORTH_COMPILING = 30_000_000

_done = 0


def best_ratios(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    scores: Scores,
    keep: int = 0,
    bags: tuple[Bags, Bags] | None = None,
) -> FloatArray:
    """Best normalised score of string i of x with each named string of y, over all rotations.

    With ``keep`` > 0 and the bags of symbols of x and y, strings that provably cannot be among the
    best ``keep`` are not aligned and answer -inf; the rest is as without.

    Returns
    -------
    (T,) in [-1, 1]; negative where gaps and mismatches outweigh, 0 where nothing weighs anything.
    """
    engine = _engine(x, i, y, rows, scores)
    if bags is None or not 0 < keep < len(rows):
        return _scores(engine, x, i, y, rows, np.full(len(rows), np.inf), 0, scores)
    earned: FloatArray = engine.most(bags[0], i, bags[1], rows, scores)
    bounds = ratio_bounds(x, i, y, rows, earned)
    order = np.argsort(-bounds, kind="stable")
    out = np.empty(len(rows))
    out[order] = _scores(engine, x, i, y, rows[order], bounds[order], keep, scores)
    return out


@dataclass(frozen=True, slots=True, eq=False)
class Alignments:
    """How one string x goes onto T strings y.

    ``ratios`` (T,) normalised scores; ``cuts`` (T,) the symbol of x that comes first;
    ``partner`` (T, M) symbol of x matched for a gain with each symbol of y, else -1;
    ``psi_rad`` (T,) turn to add to x's angles, NaN where no feature tells it; ``concentration``
    (T,) R in [0, 1]; ``spread_rad`` (T,) standard deviation of the residuals, sqrt(-2 ln R).
    """

    ratios: FloatArray
    cuts: NDArray[np.int64]
    partner: NDArray[np.int64]
    psi_rad: FloatArray
    concentration: FloatArray
    spread_rad: FloatArray


def align(
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    scores: Scores,
    silent: NDArray[np.bool_],
) -> Alignments:
    """Best rotation of string i of x on each named string of y, traced back.

    Of rotations with equal scores the one with the least orientation residual counts, then the
    smallest (systems.md 1.5, 1.6). ``silent`` (C,) marks codes that say nothing about orientation.
    """
    engine = _engine(x, i, y, rows, scores)
    ratios: FloatArray = engine.rotation_ratios(x, i, y, rows, scores)
    best = ratios.max(axis=1)
    which, cuts = np.nonzero(ratios == best[:, None])
    partner: NDArray[np.int64] = engine.partners(x, i, y, rows[which], cuts, scores)
    psi, concentration = _orientation(x, i, y.take(rows[which]), partner, silent)
    order = np.lexsort((cuts, -np.round(concentration, 9), which))
    first = order[np.searchsorted(which[order], np.arange(len(rows)))]
    with np.errstate(divide="ignore"):
        spread = np.sqrt(-2.0 * np.log(concentration[first]))
    return Alignments(best, cuts[first], partner[first], psi[first], concentration[first], spread)


def _orientation(
    x: Strings,
    i: int,
    y: Strings,
    partner: NDArray[np.int64],
    silent: NDArray[np.bool_],
) -> tuple[FloatArray, FloatArray]:
    """psi and R of every row of partners (T, M): weighted circular mean of the turns."""
    codes_y, weights_y, angles_y, _ = y.padded()
    own = slice(x.offsets[i], x.offsets[i + 1])
    codes_x, weights_x, angles_x = x.codes[own], x.weights[own], x.angles_rad[own]
    if partner.size == 0 or len(codes_x) == 0:
        return np.full(len(partner), np.nan), np.zeros(len(partner))
    mate = np.maximum(partner, 0)
    counts = (partner >= 0) & ~silent[codes_y] & ~silent[codes_x[mate]]
    weights = np.where(counts, 0.5 * (weights_x[mate] + weights_y), 0.0)
    total = _added(weights)
    z = _added(weights * np.exp(1j * (angles_y - angles_x[mate])))
    known = total > 0.0
    z = z / np.where(known, total, 1.0)
    return np.where(known, np.angle(z), np.nan), np.minimum(np.abs(z), 1.0)


def _added(values: NDArray[Any]) -> NDArray[Any]:
    """Row sums in order, so that padding does not change their last bit."""
    return np.asarray(np.cumsum(values, axis=1)[:, -1])


def _scores(
    engine: ModuleType,
    x: Strings,
    i: int,
    y: Strings,
    rows: NDArray[np.int64],
    bounds: FloatArray,
    keep: int,
    scores: Scores,
) -> FloatArray:
    out: FloatArray = engine.best_ratios(x, i, y, rows, bounds, keep, scores)
    return out


def _engine(x: Strings, i: int, y: Strings, rows: NDArray[np.int64], scores: Scores) -> ModuleType:
    """The module that does the work; a matter of time only, never of the answer."""
    global _done
    _done += int(x.lengths[i]) ** 2 * int(y.lengths[rows].sum())
    if _done < WORTH_COMPILING:
        return rotations
    from fpnav.matching import compiled

    return compiled if compiled.fits(x, i, y, scores) else rotations
