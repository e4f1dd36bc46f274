"""Geometric check of a fingerprint's candidates: scans laid over each other, and what that proves.

Every candidate's scan is searched over the query's and checked both ways for free space; the best
few are refined and checked again; a logistic of what was found states the probability that the
candidate is the same place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap
from fpnav.matching.sweep_kernels import AGREE, CONFLICT
from fpnav.matching.sweeps import Overlay, Sweep, overlaid, rough_balance, searched, turns_between
from fpnav.systems.base import Verification
from fpnav.systems.fingerprint import evidence
from fpnav.systems.fingerprint.laser import mount_of, sweep_of
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.record import CAMERA_ARC, arcs_of
from fpnav.values import FloatArray, Pose2, Reference, RelativePose, Signature

CHECKED, PEAKS = 16, 3
"""How many candidates are refined, and from how many peaks of the search each."""

TURN_STEP_RAD, TURN_MOST_RAD = np.deg2rad(10.0), np.deg2rad(60.0)
LEAST_HITS = 12
UNUSABLE = -3.0

APART_M, APART_ROWS = 5.0, 10
"""Metres of path, or frames where no path is known, between candidates at different places."""

OFFSET_FREE, TURN_FREE = 0.8, 0.9
"""Shares of what counts as the same place up to which offset and turn say nothing against it."""

DISTANCE_M = 0.03
TIED = 20.0
"""Standard deviation of one point's distance to a line, and how many neighbouring points err
alike: together the scale of the covariance."""


def verified(
    query: Signature, candidates: Sequence[Signature], params: FingerprintParams
) -> Verification | None:
    """Log-odds of being the same place, and relative poses; None where the query has no scan.

    Candidates beyond the parameter block's number are not looked at. Where there are enough of
    them to show how alike other places look, all log-odds are moved by that.
    """
    if len(query.parts["rays"]) == 0 or len(candidates) == 0:
        return None
    looked = candidates[: params.candidates]
    rough, overlays = _checked(query, looked)
    found = evidence.logits(features(list(overlays.values()), params))
    if len(looked) >= evidence.ENOUGH and len(found):
        found = evidence.among(found, surroundings(looked, rough, list(overlays), found))
    logits = dict(zip(overlays, found.tolist(), strict=True))
    relative = tuple(
        _relative(overlays[k], mount_of(query), mount_of(candidate)) if k in overlays else None
        for k, candidate in enumerate(candidates)
    )
    order = np.argsort(-rough, kind="stable").astype(np.int64)
    rest = np.arange(len(order), len(candidates))
    whole = float(arcs_of(query)[CAMERA_ARC, 1]) == 0.0
    return _answer(logits, np.concatenate([order, rest]), relative, whole=whole)


def surroundings(
    candidates: Sequence[Signature], rough: FloatArray, checked: Sequence[int], logits: FloatArray
) -> FloatArray:
    """What the candidates at other places say, (evidence.AROUND,).

    How many other places pass, and how well the eighth best of all places fits, unrefined: where
    many fit, as in a building of like corridors, the best is worth less.
    """
    order = np.argsort(-logits, kind="stable")
    places = distinct([candidates[checked[k]].reference for k in order])
    passing = logits[order[places[1:]]] > evidence.PASSES
    best = np.argsort(-rough, kind="stable")
    best = best[rough[best] > UNUSABLE]
    others = distinct([candidates[k].reference for k in best.tolist()], evidence.RANK + 1)
    full = len(others) > evidence.RANK
    fit = float(rough[best[others[evidence.RANK]]]) if full else evidence.NO_FIT
    return np.array([np.log1p(passing.sum()), fit])


def distinct(references: Sequence[Reference], most: int = CHECKED) -> NDArray[np.int64]:
    """The first of each place among references, by travelled path, else by frames; at most so
    many."""
    kept: list[int] = []
    for k, here in enumerate(references):
        if len(kept) == most:
            break
        if all(_apart(here, references[other]) for other in kept):
            kept.append(k)
    return np.array(kept, np.int64)


def _apart(first: Reference, second: Reference) -> bool:
    """Whether two signatures of the reference run stand at different stretches of its path."""
    if first.session != second.session:
        return True
    metres = abs(first.travelled_m - second.travelled_m)
    return metres > APART_M if np.isfinite(metres) else abs(first.index - second.index) > APART_ROWS


@dataclass(frozen=True, slots=True, eq=False)
class LookedAt:
    """What the logistics see of a query's candidates: ``rows`` (n,) of those that were checked,
    their ``table`` (n, evidence.NAMES), and what is ``around`` (evidence.AROUND_NAMES,)."""

    rows: NDArray[np.int64]
    table: FloatArray
    around: FloatArray


def looked_at(
    query: Signature, candidates: Sequence[Signature], params: FingerprintParams
) -> LookedAt | None:
    """What ``verified`` would weigh; None where the query has no scan."""
    if len(query.parts["rays"]) == 0 or len(candidates) == 0:
        return None
    looked = candidates[: params.candidates]
    rough, overlays = _checked(query, looked)
    table = features(list(overlays.values()), params)
    around = surroundings(looked, rough, list(overlays), evidence.logits(table))
    return LookedAt(np.array(list(overlays), np.int64), table, around)


def _checked(
    query: Signature, candidates: Sequence[Signature]
) -> tuple[FloatArray, dict[int, Overlay]]:
    """Balance of every candidate's rough overlay, and the best few overlays refined."""
    mine = sweep_of(query.parts["rays"])
    others = [sweep_of(one.parts["rays"]) for one in candidates]
    rough = np.array([_rough(mine, one) for one in others])
    order = np.argsort(-rough, kind="stable")
    chosen = [k for k in np.sort(order[:CHECKED]).tolist() if rough[k] > UNUSABLE]
    return rough, {k: overlaid(mine, others[k], _search(mine, others[k], PEAKS)) for k in chosen}


def _rough(mine: Sweep, other: Sweep) -> float:
    """Balance of the best overlay the search finds, unrefined."""
    if min(len(mine.hits), len(other.hits)) < LEAST_HITS:
        return UNUSABLE
    return rough_balance(mine, other, _search(mine, other, 1)[0, 1:])


def _search(mine: Sweep, other: Sweep, peaks: int) -> FloatArray:
    return searched(mine, other, turns_between(mine, other, TURN_MOST_RAD, TURN_STEP_RAD), peaks)


def features(overlays: Sequence[Overlay], params: FingerprintParams) -> FloatArray:
    """What the logistic looks at, (n, evidence.NAMES); overlays of one query."""
    if not overlays:
        return np.zeros((0, len(evidence.NAMES)))
    ahead = np.array([one.forward for one in overlays])
    back = np.array([one.backward for one in overlays])
    seen = [side[:, AGREE] + side[:, CONFLICT] for side in (ahead, back)]
    balance = np.array([one.balance for one in overlays])
    off = np.array([np.hypot(*one.pose[:2]) for one in overlays]) / params.same_m
    most_deg = 180.0 if params.window_m > 0.0 else params.same_deg
    turn = np.abs([wrap(float(one.pose[2])) for one in overlays]) / np.deg2rad(most_deg)
    return np.column_stack(
        [
            np.minimum(ahead[:, AGREE], back[:, AGREE]),
            (ahead[:, CONFLICT] + back[:, CONFLICT]) / 2.0,
            np.minimum(*seen),
            np.sqrt([one.square_m2 for one in overlays]),
            np.maximum(off - OFFSET_FREE, 0.0),
            np.maximum(turn - TURN_FREE, 0.0) * (most_deg < 180.0),
            balance - balance.max(),
        ]
    )


def _relative(overlay: Overlay, query_m: FloatArray, other_m: FloatArray) -> RelativePose:
    """The query's robot as seen from the candidate's robot, with covariance.

    The overlay is the candidate's laser in the frame of the query's; both lasers stand ahead of
    their robot's centre.
    """
    x, y, psi = (float(value) for value in overlay.pose)
    c, s = np.cos(psi), np.sin(psi)
    back = np.array([[c, s], [-s, c]])
    seen = back @ (-query_m - np.array([x, y])) + other_m
    pose = Pose2(float(seen[0]), float(seen[1]), wrap(-psi))
    return RelativePose(pose, tuple(_covariance(overlay, back).ravel().tolist()))


def _covariance(overlay: Overlay, back: FloatArray) -> FloatArray:
    """Covariance (3, 3) of the relative pose; along a bare corridor it is as wide as the search."""
    variance = max(overlay.square_m2, DISTANCE_M**2) * TIED
    held = overlay.information / variance + np.diag([0.25, 0.25, 4.0])
    turned = np.eye(3)
    turned[:2, :2] = back
    return np.asarray(turned @ np.linalg.inv(held) @ turned.T)


def _answer(
    logits: Mapping[int, float],
    order: NDArray[np.int64],
    relative: tuple[RelativePose | None, ...],
    *,
    whole: bool,
) -> Verification:
    """Scores of the checked by log-odds; the others below the least of them, in search order."""
    least = min([*logits.values(), evidence.LEAST])
    scores = np.empty(len(order))
    scores[order] = least - 1.0 - np.arange(len(order)) / len(order)
    scores[list(logits)] = list(logits.values())
    return Verification(scores, relative, stated=1.0 / (1.0 + np.exp(-scores)), whole=whole)
