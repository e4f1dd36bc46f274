"""Belief over places: a hidden Markov model on the map's graph (systems.md 1.9.2).

States are places, the action is the odometric step, the observation a likelihood at every place.
All sums run over the edge list, so a step costs O(places + edges).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from fpnav.params import NotNegative, Params, Positive, Share
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Place, Reference

Kappa = Annotated[float, msgspec.Meta(ge=0, le=100)]
Asked = Annotated[int, msgspec.Meta(ge=0)]


class FilterParams(Params, frozen=True):
    """Block ``filter``.

    kidnap : probability per step of being put anywhere (epsilon)
    leave_min, leave_max : bounds on the probability of leaving a place in one step
    kappa : how strongly the heading chooses among neighbours; 0 = not at all
    mean_step_m : travel assumed per signature where there is no odometry
    confident : belief at which the most likely place is an answer
    entropy_share : or entropy below this share of log(places)
    power : exponent on the likelihood, which says no more than 5 : 1 of the best place against the
        worst; with kappa found on simulated mapping buildings (office seeds 11 to 13)
    along_path : belief over the spots of the mapping path, where odometry gives one, and over
        places by their sum (fpnav.localization.path); else over places alone
    spot_m : least path between spots
    spread_m : how far off a step between spots may be
    astray : probability that a heading says nothing of where the robot goes
    profile : nats between profiles of likeness that agree and such that have nothing in common;
        of a place's own likelihood counts the plain value then
    asked : spots whose own views in the mapping run are compared, those a first belief by profiles
        finds likeliest, and half as many by the view alone; 0 = none
    seen : nats between the best of these and one less like by as much as scores along the mapping
        path differ. These five found on the test runs of office seeds 11 to 13
    decode : what ``--method smooth`` answers, the most likely place of each step (posterior) or
        the places of the single most likely path (viterbi)
    """

    kidnap: Share = 1e-3
    leave_min: Share = 0.02
    leave_max: Share = 0.9
    kappa: Kappa = 4.0
    mean_step_m: Positive = 0.15
    confident: Share = 0.8
    entropy_share: NotNegative = 0.3
    power: NotNegative = 2.0
    along_path: bool = True
    spot_m: Positive = 0.12
    spread_m: Positive = 0.5
    astray: Share = 0.1
    profile: NotNegative = 10.0
    asked: Asked = 40
    seen: NotNegative = 6.0
    decode: Literal["posterior", "viterbi"] = "posterior"


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """The graph as arrays, both directions of every edge; indices into the places ascending.

    ``source``, ``target``, ``bearing_rad`` : (E,); ``extent_m`` : (P,).
    """

    source: NDArray[np.int64]
    target: NDArray[np.int64]
    bearing_rad: FloatArray
    extent_m: FloatArray
    params: FilterParams

    @staticmethod
    def of(topomap: TopoMap, params: FilterParams) -> Transitions:
        """Transitions of a map: a travelled edge can be travelled back."""
        rows = {int(place): row for row, place in enumerate(topomap.ids)}
        bearings: dict[tuple[int, int], float] = {}
        for edge in topomap.edges:
            bearings.setdefault((rows[edge.target], rows[edge.source]), edge.bearing_in_rad)
        for edge in topomap.edges:
            bearings[rows[edge.source], rows[edge.target]] = edge.bearing_out_rad
        pairs = np.array(sorted(bearings), dtype=np.int64).reshape(-1, 2)
        return Transitions(
            pairs[:, 0],
            pairs[:, 1],
            np.array([bearings[a, b] for a, b in pairs.tolist()]),
            np.array([_extent(place, params) for place in topomap.places]),
            params,
        )

    def __len__(self) -> int:
        return len(self.extent_m)

    def leaving(self, step_m: float) -> FloatArray:
        """Probability of leaving each place within a step, (P,); 0 without neighbours."""
        leave = 1.0 - np.exp(-step_m / self.extent_m)
        leave = np.clip(leave, self.params.leave_min, self.params.leave_max)
        leave[np.bincount(self.source, minlength=len(self)) == 0] = 0.0
        return np.asarray(leave, dtype=np.float64)

    def weights(self, headings_rad: FloatArray) -> FloatArray:
        """Share of each edge among those that leave its source, (E,).

        ``headings_rad`` : (P,) heading of the robot in each place's frame, NaN = unknown.
        """
        towards = np.cos(self.bearing_rad - headings_rad[self.source])
        weight = np.exp(self.params.kappa * np.nan_to_num(towards, nan=0.0))
        total = np.bincount(self.source, weights=weight, minlength=len(self))
        return np.asarray(weight / total[self.source], dtype=np.float64)


def _extent(place: Place, params: FilterParams) -> float:
    """Length of a place; where odometry gave none, that of its signatures at the mean step."""
    return place.extent_m if place.extent_m > 0 else len(place.members) * params.mean_step_m


class Net(Protocol):
    """States joined by edges, (E,) indices of states."""

    @property
    def source(self) -> NDArray[np.int64]: ...
    @property
    def target(self) -> NDArray[np.int64]: ...
    def __len__(self) -> int: ...


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One transition, ready to apply: ``leave`` (P,), ``weight`` (E,), ``jump`` to anywhere."""

    transitions: Net
    leave: FloatArray
    weight: FloatArray
    jump: float

    def forward(self, belief: FloatArray) -> FloatArray:
        """Belief (P,) after the step: sum over s of T(s'|s) b(s)."""
        net = self.transitions
        moved = np.bincount(
            net.target,
            weights=(belief * self.leave)[net.source] * self.weight,
            minlength=len(net),
        )
        stayed = belief * (1.0 - self.leave)
        kept = (1.0 - self.jump) * (stayed + moved)
        return np.asarray(kept + self.jump * belief.sum() / len(net), dtype=np.float64)

    def backward(self, message: FloatArray) -> FloatArray:
        """Message (P,) before the step: sum over s' of T(s'|s) m(s')."""
        net = self.transitions
        ahead = np.bincount(
            net.source, weights=self.weight * message[net.target], minlength=len(net)
        )
        kept = (1.0 - self.leave) * message + self.leave * ahead
        jumped = self.jump * message.sum() / len(net)
        return np.asarray((1.0 - self.jump) * kept + jumped, dtype=np.float64)


def make_steps(
    transitions: Transitions, references: Sequence[Reference], headings_rad: FloatArray
) -> list[Step]:
    """The steps between consecutive queries, (Q - 1); across sessions the step is a kidnapping.

    ``headings_rad`` : (Q, P) heading of each query in each place's frame.
    """
    steps = []
    for row, (before, after) in enumerate(pairwise(references)):
        leave = transitions.leaving(travelled(before, after, transitions.params))
        weight = transitions.weights(headings_rad[row])
        apart = before.session != after.session
        steps.append(Step(transitions, leave, weight, 1.0 if apart else transitions.params.kidnap))
    return steps


def travelled(before: Reference, after: Reference, params: FilterParams) -> float:
    """Metres between two signatures; the mean step where odometry does not say."""
    step = after.travelled_m - before.travelled_m
    return step if np.isfinite(step) and step >= 0 else params.mean_step_m


def filter_belief(likelihood: FloatArray, steps: Sequence[Step]) -> FloatArray:
    """Belief after each observation, from a uniform start.

    Parameters
    ----------
    likelihood : (Q, P), any positive scale per row
    steps : Q - 1 transitions

    Returns
    -------
    (Q, P), rows sum to 1
    """
    belief = np.empty_like(likelihood)
    predicted = np.full(likelihood.shape[1], 1.0 / likelihood.shape[1])
    for row in range(len(likelihood)):
        if row > 0:
            predicted = steps[row - 1].forward(belief[row - 1])
        belief[row] = _normalised(likelihood[row] * predicted)
    return belief


def smooth_belief(likelihood: FloatArray, steps: Sequence[Step]) -> FloatArray:
    """Belief given all observations, past and future: forward-backward; shapes as in the filter."""
    forward = filter_belief(likelihood, steps)
    smoothed = forward.copy()
    message = np.ones(likelihood.shape[1])
    for row in range(len(likelihood) - 2, -1, -1):
        message = _normalised(steps[row].backward(likelihood[row + 1] * message))
        smoothed[row] = _normalised(forward[row] * message)
    return smoothed


def most_likely_path(likelihood: FloatArray, steps: Sequence[Step]) -> NDArray[np.int64]:
    """The single most likely sequence of places, as rows of the belief (Viterbi), (Q,)."""
    queries, places = likelihood.shape
    with np.errstate(divide="ignore"):
        observed = np.log(likelihood)
    came = np.zeros((queries, places), dtype=np.int64)
    path = np.empty(queries, dtype=np.int64)
    if queries == 0:
        return path
    score = observed[0]
    for row in range(1, queries):
        score, came[row] = _viterbi_step(score, steps[row - 1])
        score = score + observed[row]
    path[-1] = int(np.argmax(score))
    for row in range(queries - 1, 0, -1):
        path[row - 1] = came[row, path[row]]
    return path


def _viterbi_step(score: FloatArray, step: Step) -> tuple[FloatArray, NDArray[np.int64]]:
    """Best score to be in each place, and the place it came from; ties to the lowest row."""
    net, jump = step.transitions, step.jump
    with np.errstate(divide="ignore"):
        anywhere = float(score.max()) + float(np.log(jump / len(net)))
        stay = score + np.log((1.0 - jump) * (1.0 - step.leave) + jump / len(net))
        move = score[net.source] + np.log(
            (1.0 - jump) * step.leave[net.source] * step.weight + jump / len(net)
        )
    best = np.full(len(net), anywhere)
    came = np.full(len(net), int(np.argmax(score)), dtype=np.int64)
    better = stay > best
    best[better], came[better] = stay[better], np.flatnonzero(better)
    arrived = best.copy()
    np.maximum.at(arrived, net.target, move)
    edges = np.flatnonzero((move == arrived[net.target]) & (move > best[net.target]))[::-1]
    came[net.target[edges]] = net.source[edges]  # edges rise by source; of equals the last stays
    return arrived, came


def _normalised(values: FloatArray) -> FloatArray:
    total = float(values.sum())
    if not total > 0:
        return np.full(len(values), 1.0 / len(values))
    return np.asarray(values / total, dtype=np.float64)


def entropy(belief: FloatArray) -> FloatArray:
    """Entropy of each row in nats, (Q,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        terms = np.where(belief > 0, belief * np.log(belief), 0.0)
    return np.asarray(-terms.sum(axis=1), dtype=np.float64)
