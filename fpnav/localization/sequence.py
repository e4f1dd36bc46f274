"""Matches smoothed along a run: those that move as the robot did hold each other up.

Every checked candidate of a query is a hypothesis with a relative pose. Two hypotheses of
neighbouring queries agree where the motion between the queries carries one pose to the other. Where
a query found nothing, its neighbours' matches say where to look. Forward-backward over the
hypotheses and "somewhere else" gives the probability of each.

An answer that the single observation decided for stands unless the sequence all but excludes it;
elsewhere the most probable is the answer. What is stated of an answer stays what its own overlay
says, so that aliased stretches, which agree with themselves as well, gain nothing. Within one run
the motions summed up refute matches that are further off than any drift.

The motion is odometry where the log has it, else what the system's check says of neighbouring
signatures; truth is never used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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

SURE = 0.8
WINDOW_ROWS, AROUND_M, AROUND_RAD, LOOKS = 15, 1.5, np.deg2rad(60.0), 3
SAME_M = 1.0
"""How near guesses are one place."""

DEPENDENCE, LOGIT_MOST = 0.8, 7.0
"""Share of a single observation's log-odds that counts beside its neighbours', which see much the
same, and what one may claim at most."""

EXCLUDED, DECIDED = 0.02, 0.5
"""Shares below which an answer is excluded and from which the sequence decides for another."""

DRIFT_M, DRIFT_SHARE, DRIFT_RAD, DRIFT_RAD_PER_M = 1.5, 0.1, np.deg2rad(20.0), np.deg2rad(0.7)
REFUTED, REFUTED_WORTH = 3.0, 6.0
"""How far a match may be off the motions summed up since, and the log-odds one loses that is: as
stated, and beside others. On intel, freiburg-079, belgioioso and killian none of 678 so refuted was
right."""


@dataclass(frozen=True, slots=True, eq=False)
class Guesses:
    """Hypotheses of one query: reference ``rows`` (n,), ``logits`` (n,) of the single observation,
    ``poses`` (n, 3) of the query from each row; ``refuted`` (n,) by the motions summed up, None
    where that was not asked."""

    rows: NDArray[np.int64]
    logits: FloatArray
    poses: FloatArray
    refuted: NDArray[np.bool_] | None = None

    @property
    def worth(self) -> FloatArray:
        """Log-odds (n,) that count beside those of neighbours."""
        own = np.clip(DEPENDENCE * self.logits, -LOGIT_MOST, LOGIT_MOST)
        return np.asarray(own if self.refuted is None else own - REFUTED_WORTH * self.refuted)

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
    rows: NDArray[np.int64] | None = None,
) -> Checked:
    """Rankings after the whole sequence was seen.

    Parameters
    ----------
    candidates : (Q,) how many of the first reference rows each query may match
    rows : (Q,) which row each query is, where a run is matched with its own past

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
            near = expected(guesses[before], guesses[row], step, chain, int(candidates[row]))
            if len(near):
                guesses[row] = looked(system, reference, queries[row], guesses[row], near)
    if rows is not None:
        path = np.array([one.reference.travelled_m for one in reference])
        guesses = [
            judged(one, int(row), chain, path) for one, row in zip(guesses, rows, strict=True)
        ]
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
        np.concatenate([here.logits, logit(found.stated[new]) + _anchor(here, found.stated)]),
        np.concatenate([here.poses, np.reshape(table, (-1, 3))]),
    )


def _anchor(here: Guesses, stated: FloatArray) -> float:
    """What log-odds of a second look are raised by to stand beside the first: a check of few
    candidates knows less of what else there is. The best so far was looked at last."""
    if len(here.rows) == 0:
        return 0.0
    return min(0.0, float(here.logits.max() - logit(stated[-1])))


def judged(one: Guesses, row: int, chain: Chain, path_m: FloatArray) -> Guesses:
    """The guesses of a query that is a row of the same run, with what the motions say of them."""
    off = difference(chain.between(one.rows, np.full_like(one.rows, row)), one.poses)
    gap = np.abs(path_m[row] - path_m[one.rows])
    far = off[:, 0] > DRIFT_M + DRIFT_SHARE * gap
    turned = off[:, 1] > DRIFT_RAD + DRIFT_RAD_PER_M * gap
    return replace(one, refuted=np.isfinite(off[:, 0]) & (far | turned))


def posteriors(guesses: Sequence[Guesses], motion: FloatArray, chain: Chain) -> list[FloatArray]:
    """Probability of each guess of each query, and last of "somewhere else"."""
    worth = [np.exp(np.append(one.worth, 0.0)) for one in guesses]
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
    """Rankings by posterior, the answer first; where a query has no guess all stays as it was."""
    recall = checked.recall
    recall = Recall(recall.places.copy(), recall.scores.copy(), recall.headings_rad.copy())
    relative, covariance = checked.relative.copy(), checked.covariance.copy()
    stated = checked.stated.copy()
    for row, (one, shares) in enumerate(zip(guesses, found, strict=True)):
        if len(one.rows) == 0:
            continue
        best = chosen(one, shares[:-1], int(recall.places[row, 0]), float(stated[row]), chain)
        own = float(one.logits[_together(one, best, chain)].max())
        if one.refuted is not None:
            own -= REFUTED * float(one.refuted[best])
        if one.rows[best] != recall.places[row, 0]:
            relative[row], covariance[row] = one.poses[best], np.nan
        _ranked(recall, row, one, shares[:-1], best, own)
        stated[row] = 1.0 / (1.0 + np.exp(-own))
    return replace(checked, recall=recall, relative=relative, covariance=covariance, stated=stated)


def chosen(one: Guesses, shares: FloatArray, first: int, stated: float, chain: Chain) -> int:
    """Which guess is the answer, the row ``first`` having been that of the single observation."""
    best = int(np.argmax(shares))
    own = np.flatnonzero(one.rows == first)
    if len(own) == 0 or stated < 0.5:
        return best
    excluded = shares[_together(one, int(own[0]), chain)].sum() < EXCLUDED
    decided = shares[_together(one, best, chain)].sum() > DECIDED
    return best if excluded and decided else int(own[0])


def _ranked(
    recall: Recall, row: int, one: Guesses, shares: FloatArray, best: int, score: float
) -> None:
    """One ranking by posterior, in place, the answer first; what is no guess keeps its order
    behind."""
    places, scores, turns = recall.places[row], recall.scores[row], recall.headings_rad[row]
    depth = len(places)
    order = np.argsort(-shares, kind="stable")
    order = np.concatenate([[best], order[order != best]])
    rest = ~np.isin(places, one.rows)
    values = np.minimum(np.append(score, logit(shares[order[1:]])), score)
    values = np.minimum.accumulate(values)
    low = min(float(values.min()), float(scores[places >= 0].min(initial=np.inf)))
    after = np.where(places[rest] >= 0, low, -np.inf)
    kept = np.concatenate([one.rows[order], places[rest]])[:depth]
    values = np.concatenate([values, after])[:depth]
    headings = np.concatenate([one.poses[order, 2], turns[rest]])[:depth]
    places[: len(kept)], scores[: len(kept)], turns[: len(kept)] = kept, values, headings


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
