"""Matches smoothed along a run: those that move as the robot did hold each other up.

Every checked candidate of a query is a hypothesis with a relative pose. Two hypotheses of
neighbouring queries agree where the motion between the queries carries one pose to the other. Where
a query found nothing, its neighbours' matches say where to look. Forward-backward over the
hypotheses and "somewhere else" gives the probability of each. An answer changes only where the
sequence decides for another place; there it is stated as the sequence sees it, within bounds.

The motion is odometry where the log has it, else what the system's check says of neighbouring
signatures; truth is never used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.geometry import wrap_array
from fpnav.localization.verify import Checked
from fpnav.systems.base import Recall, System
from fpnav.values import FloatArray, Signature

NEAR_M, NEAR_RAD, NEAR_SHARE = 0.4, np.deg2rad(12.0), 0.1
"""How far two hypotheses may be off after the motion, and the share of the motion on top."""

APART, ELSEWHERE = 0.02, 0.15
"""Worth of two hypotheses that disagree, and of one beside "somewhere else"; agreeing: 1."""

SURE, LOGIT_MOST = 0.8, 7.0
WINDOW_ROWS, AROUND_M, AROUND_RAD, LOOKS = 15, 1.5, np.deg2rad(60.0), 3
SAME_M, DECIDED = 1.0, 0.5
"""How near guesses are one place, and the share from which the sequence decides for it."""

SWAY = 1.0
"""Log-odds by which the sequence may move what is stated of a match. Neighbours tell where the
robot is, not whether that is near enough to be called the same place."""


@dataclass(frozen=True, slots=True, eq=False)
class Guesses:
    """Hypotheses of one query: reference ``rows`` (n,), ``logits`` (n,) of the single observation,
    ``poses`` (n, 3) of the query from each row."""

    rows: NDArray[np.int64]
    logits: FloatArray
    poses: FloatArray

    @property
    def sure(self) -> int:
        """The best one where it is sure, else -1."""
        if len(self.rows) == 0:
            return -1
        best = int(np.argmax(self.logits))
        return best if self.logits[best] > np.log(SURE / (1.0 - SURE)) else -1


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Motions of a run summed up: ``poses`` (N, 3) within each ``stretch`` (N,) without a gap."""

    poses: FloatArray
    stretch: NDArray[np.int64]

    def between(self, first: NDArray[np.int64], second: NDArray[np.int64]) -> FloatArray:
        """Poses (..., 3) of second rows from first ones, NaN across a gap."""
        found = composed(inverted(self.poses[first]), self.poses[second])
        return np.where((self.stretch[first] == self.stretch[second])[..., None], found, np.nan)


def smoothed(
    system: System,
    reference: Sequence[Signature],
    queries: Sequence[Signature],
    candidates: NDArray[np.int64],
    checked: Checked,
) -> Checked:
    """Rankings after the whole sequence was seen.

    Raises
    ------
    UsageError
        The system's check gives no relative poses to go by.
    """
    if len(queries) and not np.isfinite(checked.poses).all(axis=-1).any():
        raise UsageError(
            f"{system.NAME} gives no relative poses of candidates, which smoothing goes by; "
            "use --method match"
        )
    motion = motions(system, queries)
    chain = chained(motions(system, reference))
    guesses = [guesses_of(checked, row) for row in range(len(queries))]
    for order in (range(1, len(queries)), range(len(queries) - 2, -1, -1)):
        for row in order:
            before = row - 1 if order.step > 0 else row + 1
            step = motion[row] if order.step > 0 else inverted(motion[row + 1])
            rows = expected(guesses[before], guesses[row], step, chain, int(candidates[row]))
            if len(rows):
                guesses[row] = looked(system, reference, queries[row], guesses[row], rows)
    return answered(checked, guesses, posteriors(guesses, motion, chain), chain)


def motions(system: System, run: Sequence[Signature]) -> FloatArray:
    """Pose of each signature from the one before it, (N, 3); NaN where nothing tells it."""
    out = np.full((len(run), 3), np.nan)
    before: Signature | None = None
    for row in range(len(run)):
        here = run[row]
        if before is not None and before.reference.session == here.reference.session:
            out[row] = _motion(system, before, here)
        before = here
    return out


def _motion(system: System, before: Signature, here: Signature) -> FloatArray:
    first, second = before.reference.odometry, here.reference.odometry
    if first is not None and second is not None:
        ends = [np.array([one.x_m, one.y_m, one.heading_rad]) for one in (first, second)]
        return composed(inverted(ends[0]), ends[1])
    found = system.verify(here, [before])
    pose = None if found is None else found.relative[0]
    if found is None or found.stated is None or pose is None or found.stated[0] < 0.5:
        return np.full(3, np.nan)
    return np.array([pose.pose.x_m, pose.pose.y_m, pose.pose.heading_rad])


def chained(motion: FloatArray) -> Chain:
    """Motions summed up; each gap begins a new stretch at the origin."""
    poses = np.zeros((len(motion), 3))
    gap = np.asarray(np.isnan(motion).any(axis=1), bool)
    for row in range(1, len(motion)):
        if not gap[row]:
            poses[row] = composed(poses[row - 1], motion[row])
    return Chain(poses, np.cumsum(gap).astype(np.int64))


def guesses_of(checked: Checked, row: int) -> Guesses:
    """The candidates of a query that have a pose and a stated probability."""
    kept = np.isfinite(checked.poses[row]).all(axis=1) & np.isfinite(checked.probability[row])
    rows = checked.recall.places[row, : len(kept)][kept]
    return Guesses(rows, logit(checked.probability[row][kept]), checked.poses[row][kept])


def expected(
    before: Guesses, here: Guesses, step: FloatArray, chain: Chain, allowed: int
) -> NDArray[np.int64]:
    """Rows near where a sure neighbour says an unsure query is, not looked at yet."""
    best = before.sure
    if best < 0 or here.sure >= 0 or not np.isfinite(step).all():
        return np.zeros(0, np.int64)
    row = int(before.rows[best])
    rows = np.arange(max(0, row - WINDOW_ROWS), min(allowed, row + WINDOW_ROWS + 1))
    off = difference(
        composed(before.poses[best], step), chain.between(np.full_like(rows, row), rows)
    )
    near = (off[:, 0] <= AROUND_M) & (off[:, 1] <= AROUND_RAD) & ~np.isin(rows, here.rows)
    order = np.argsort(np.where(near, off[:, 0], np.inf), kind="stable")[:LOOKS]
    return np.asarray(rows[order[near[order]]])


def looked(
    system: System,
    reference: Sequence[Signature],
    query: Signature,
    here: Guesses,
    rows: NDArray[np.int64],
) -> Guesses:
    """The guesses with rows checked on top of them, beside the best so far."""
    best = here.rows[np.argsort(-here.logits, kind="stable")[:1]]
    found = system.verify(query, [reference[int(row)] for row in (*rows, *best)])
    if found is None or found.stated is None:
        return here
    new = [k for k in range(len(rows)) if found.relative[k] is not None]
    poses = [found.relative[k] for k in new]
    table = [(p.pose.x_m, p.pose.y_m, p.pose.heading_rad) for p in poses if p is not None]
    return Guesses(
        np.concatenate([here.rows, rows[new]]),
        np.concatenate([here.logits, logit(found.stated[new])]),
        np.concatenate([here.poses, np.reshape(table, (-1, 3))]),
    )


def posteriors(guesses: Sequence[Guesses], motion: FloatArray, chain: Chain) -> list[FloatArray]:
    """Probability of each guess of each query, and last of "somewhere else"."""
    worth = [np.exp(np.append(_bounded(one.logits), 0.0)) for one in guesses]
    pairs = [
        agreement(guesses[row - 1], guesses[row], motion[row], chain)
        for row in range(1, len(guesses))
    ]
    ahead = [worth[0] / worth[0].sum()] if worth else []
    for pair, own in zip(pairs, worth[1:], strict=True):
        there = (ahead[-1] @ pair) * own
        ahead.append(there / there.sum())
    back = [np.ones(len(own)) for own in worth]
    for row in range(len(worth) - 2, -1, -1):
        there = pairs[row] @ (worth[row + 1] * back[row + 1])
        back[row] = there / there.sum()
    both = [first * second for first, second in zip(ahead, back, strict=True)]
    return [one / one.sum() for one in both]


def agreement(before: Guesses, here: Guesses, step: FloatArray, chain: Chain) -> FloatArray:
    """Worth of each guess before beside each guess here, "somewhere else" last; (n + 1, m + 1)."""
    out = np.full((len(before.rows) + 1, len(here.rows) + 1), ELSEWHERE)
    out[-1, -1] = 1.0
    if not np.isfinite(step).all():
        out[:] = 1.0
        return out
    first, second = np.broadcast_arrays(before.rows[:, None], here.rows[None, :])
    where = composed(chain.between(first, second), here.poses[None, :, :])
    off = difference(composed(before.poses, step)[:, None, :], where)
    near = off[..., 0] <= NEAR_M + NEAR_SHARE * np.hypot(step[0], step[1])
    out[:-1, :-1] = np.where(near & (off[..., 1] <= NEAR_RAD), 1.0, APART)
    return out


def answered(
    checked: Checked, guesses: Sequence[Guesses], found: Sequence[FloatArray], chain: Chain
) -> Checked:
    """Rankings by posterior, guesses first, where the sequence decides for another place than the
    single observation did; elsewhere all stays as it was, so that aliased stretches, which agree
    with themselves as well, gain nothing."""
    places, scores = checked.recall.places.copy(), checked.recall.scores.copy()
    headings = checked.recall.headings_rad.copy()
    relative, stated = checked.relative.copy(), checked.stated.copy()
    covariance, depth = checked.covariance.copy(), places.shape[1]
    for row, (one, shares) in enumerate(zip(guesses, found, strict=True)):
        if len(one.rows) == 0:
            continue
        shares = shares[:-1]
        best = int(np.argmax(shares))
        together = _together(one, best, chain)
        if places[row, 0] in one.rows[together] or shares[together].sum() < DECIDED:
            continue
        total = _swayed(one.logits[best], shares[together].sum())
        order = np.argsort(-shares, kind="stable")
        rest = places[row][~np.isin(places[row], one.rows)]
        kept = np.concatenate([one.rows[order], rest])[:depth]
        values = np.minimum(logit(np.append(total, shares[order[1:]])), logit(np.array(total)))
        low = min(float(values.min()), float(checked.recall.scores[row].min(initial=np.inf)))
        filled = np.concatenate([values, np.full(len(rest), low)])[:depth]
        relative[row], covariance[row] = one.poses[best], np.nan
        turns = np.concatenate([one.poses[order, 2], np.full(len(rest), np.nan)])[:depth]
        places[row, : len(kept)], scores[row, : len(kept)] = kept, filled
        headings[row, : len(kept)] = turns
        scores[row][places[row] < 0] = -np.inf
        stated[row] = total
    return Checked(
        Recall(places, scores, headings), relative, covariance, stated,
        checked.poses, checked.probability, checked.done,
    )  # fmt: skip


def _swayed(own: float, share: float) -> float:
    """Probability of a guess: the sequence's, no further above its own than SWAY allows."""
    moved = float(logit(np.array(share)) - _bounded(np.array(own)))
    value = own + float(np.clip(moved, 0.0, SWAY))
    return 1.0 / (1.0 + float(np.exp(-value)))


def _together(one: Guesses, best: int, chain: Chain) -> NDArray[np.bool_]:
    """Guesses that put the query where the best one does, (n,)."""
    first = np.full_like(one.rows, one.rows[best])
    off = difference(one.poses[best], composed(chain.between(first, one.rows), one.poses))
    together = off[:, 0] <= SAME_M
    together[best] = True
    return np.asarray(together)


def composed(first: FloatArray, second: FloatArray) -> FloatArray:
    """Poses (..., 3) given in the frames of others, in those others' frame; broadcasting."""
    first, second = np.broadcast_arrays(first, second)
    c, s = np.cos(first[..., 2]), np.sin(first[..., 2])
    x = first[..., 0] + c * second[..., 0] - s * second[..., 1]
    y = first[..., 1] + s * second[..., 0] + c * second[..., 1]
    return np.stack([x, y, wrap_array(first[..., 2] + second[..., 2])], axis=-1)


def inverted(pose: FloatArray) -> FloatArray:
    """Poses (..., 3) of the first frames in the second ones."""
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = -c * pose[..., 0] - s * pose[..., 1], s * pose[..., 0] - c * pose[..., 1]
    return np.stack([x, y, wrap_array(-pose[..., 2])], axis=-1)


def difference(first: FloatArray, second: FloatArray) -> FloatArray:
    """Metres and radians between poses (..., 3), (..., 2); infinite where one is unknown."""
    first, second = np.broadcast_arrays(first, second)
    apart = np.hypot(first[..., 0] - second[..., 0], first[..., 1] - second[..., 1])
    turn = np.abs(wrap_array(first[..., 2] - second[..., 2]))
    return np.asarray(np.nan_to_num(np.stack([apart, turn], axis=-1), nan=np.inf))


def logit(probability: FloatArray) -> FloatArray:
    """Log-odds."""
    p = np.clip(probability, 1e-15, 1.0 - 1e-15)
    return np.asarray(np.log(p) - np.log1p(-p))


def _bounded(logits: FloatArray) -> FloatArray:
    """What one observation may claim beside its neighbours."""
    return np.asarray(np.clip(logits, -LOGIT_MOST, LOGIT_MOST))
