"""Standard part: a memory of frame-level descriptors, for systems that keep what they saw.

Places keep the descriptors of their members; a place is as like a query as its best member. What
a descriptor is and how two are compared is the business of a metric, which the system gives:
this is all that a global image descriptor, a polar scan signature or an attributed string differ
in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.matching.ranking import ranked
from fpnav.systems.base import (
    BY_PLACES,
    Features,
    MapRule,
    Memory,
    Recall,
    State,
    Thinning,
    Trace,
    no_verification,
    spread_likelihood,
)
from fpnav.values import FloatArray, Signature


class Metric(Protocol):
    """What is kept of a signature, and how one is compared with many.

    Descriptors are named arrays; in one memory the same names, dtypes and, but for the first axis,
    shapes. A model is what ``fit`` learned from the mapping run, as named arrays.
    """

    def fit(self, signatures: Sequence[Signature]) -> State:
        """What concerns the whole mapping run: statistics, vocabularies; nothing = empty."""
        ...

    def descriptor(self, signature: Signature, model: State) -> Features:
        """What is kept of a signature."""
        ...

    def stack(self, descriptors: Sequence[Features]) -> Any:
        """Descriptors as one batch for ``compare``; never an empty one."""
        ...

    def compare(
        self, query: Features, members: Any, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        """Scores of the named rows of a batch, growing with likeness, and the turns from each to
        the query, NaN where there is none; (n,) both."""
        ...

    def likeness(self, first: Features, second: Features, model: State) -> float:
        """How alike two descriptors are, in [0, 1], 1 for equal ones; symmetric."""
        ...


def stacked(self: object, descriptors: Sequence[Features]) -> dict[str, NDArray[Any]]:
    """Standard part ``stack``: every named array with a new first axis; equal shapes only."""
    return {name: np.stack([one[name] for one in descriptors]) for name in descriptors[0]}


class DescriptorMemory:
    """Member descriptors by place, in the order learned."""

    def __init__(self, metric: Metric) -> None:
        self._metric = metric
        self._model: State = {}
        self._members: dict[int, list[Features]] = {}
        self._current = -1
        self._batch: Any = None

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, increasing."""
        return np.array(sorted(self._members), dtype=np.int64)

    @property
    def model(self) -> State:
        """What was learned of the whole mapping run."""
        return self._model

    def members(self, place: int) -> tuple[Features, ...]:
        """Descriptors kept of a place."""
        return tuple(self._members[place])

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Learn what concerns the whole mapping run; before anything is learned of its places."""
        self._model = self._metric.fit(signatures)

    def learn(self, place: int, signature: Signature) -> None:
        """Keep the descriptor of one more observation of a place."""
        found = self._metric.descriptor(signature, self._model)
        self._members.setdefault(place, []).append(found)
        self._current, self._batch = place, None

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """Unlikeness to where the present place began, so that no place creeps along."""
        if self._current not in self._members:
            return 1.0, trace
        found = self._metric.descriptor(signature, self._model)
        like = self._metric.likeness(found, self._members[self._current][0], self._model)
        return 1.0 - like, trace

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places with the member most like each signature."""
        places = self.places
        values = np.full((len(signatures), len(places)), -np.inf)
        turns = np.full((len(signatures), len(places)), np.nan)
        for q, signature in enumerate(signatures):
            found = self._metric.descriptor(signature, self._model)
            self._compare(found, None if allowed is None else allowed[q], values[q], turns[q])
        columns, scores = ranked(values, k, allowed)
        there = columns >= 0
        ids, headings = np.full(columns.shape, -1, np.int64), np.full(columns.shape, np.nan)
        ids[there] = places[columns[there]]
        headings[there] = turns[np.nonzero(there)[0], columns[there]]
        return Recall(ids, scores, headings), trace

    def _compare(
        self,
        query: Features,
        allowed: NDArray[np.bool_] | None,
        values: FloatArray,
        turns: FloatArray,
    ) -> None:
        """Fill in score and turn of the best member of every place that is allowed, (P,)."""
        if len(values) == 0:
            return
        batch, owner = self._packed(self.places)
        rows = np.arange(len(owner)) if allowed is None else np.flatnonzero(allowed[owner])
        scores, headings = self._metric.compare(query, batch, rows, self._model)
        order = np.argsort(scores, kind="stable")  # the best of a place is written last
        columns = owner[rows[order]]
        values[columns], turns[columns] = scores[order], headings[order]

    def merge(self, keep: int, drop: int) -> None:
        """Give the members of ``drop`` to ``keep``."""
        self._members[keep] += self._members.pop(drop)
        self._current = keep if self._current == drop else self._current
        self._batch = None

    def shrink(self, budget: int) -> None:
        """Keep at most ``budget`` members a place, those least like one another; 0 = no bound."""
        if budget <= 0:
            return
        for place, members in self._members.items():
            if len(members) > budget:
                self._members[place] = [members[row] for row in self._spread(members, budget)]
        self._batch = None

    def save(self) -> State:
        """Places, how many members each has, and their arrays end to end."""
        places = self.places
        rows = [row for place in places.tolist() for row in self._members[place]]
        state: State = {
            "places": places,
            "counts": np.array([len(self._members[place]) for place in places.tolist()], np.int64),
            "current": np.array([self._current], np.int64),
        }
        for name in rows[0] if rows else ():
            arrays = [np.asarray(row[name]) for row in rows]
            state[f"lengths_{name}"] = np.array([len(one) for one in arrays], np.int64)
            state[f"flat_{name}"] = np.concatenate(arrays)
        return {**state, **{f"model_{name}": array for name, array in self._model.items()}}

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved; raises StoreError where an array is missing."""
        missing = [name for name in _expected(state) if name not in state]
        if missing:
            raise StoreError(
                f"the memory lacks {', '.join(missing)}; found {', '.join(state)}; "
                "build the map again"
            )
        self._model = _with(state, "model_")
        self._current = int(state["current"][0])
        self._members, self._batch = _members(state), None

    def _packed(self, places: NDArray[np.int64]) -> tuple[Any, NDArray[np.int64]]:
        """All members as one batch, and the column of the place each belongs to."""
        if self._batch is None:
            rows = [row for place in places.tolist() for row in self._members[place]]
            counts = [len(self._members[place]) for place in places.tolist()]
            owner = np.repeat(np.arange(len(places), dtype=np.int64), counts)
            self._batch = self._metric.stack(rows), owner
        batch, owner = self._batch
        return batch, owner

    def _spread(self, members: list[Features], budget: int) -> list[int]:
        """The first row and then always the one least like all those kept, in their order."""
        kept = [0]
        nearest = np.full(len(members), -np.inf)
        while len(kept) < budget:
            last = members[kept[-1]]
            like = [self._metric.likeness(one, last, self._model) for one in members]
            nearest = np.maximum(nearest, like)
            nearest[kept] = np.inf
            kept.append(int(np.argmin(nearest)))
        return sorted(kept)


def _with(state: Mapping[str, NDArray[Any]], prefix: str) -> State:
    return {
        name.removeprefix(prefix): np.array(array)
        for name, array in state.items()
        if name.startswith(prefix)
    }


def _expected(state: Mapping[str, NDArray[Any]]) -> list[str]:
    """Names a state must hold, going by those it does hold."""
    names = {name.partition("_")[2] for name in state if name.startswith(("flat_", "lengths_"))}
    pairs = [f"{kind}_{name}" for kind in ("lengths", "flat") for name in sorted(names)]
    return ["places", "counts", "current", *pairs]


def _members(state: Mapping[str, NDArray[Any]]) -> dict[int, list[Features]]:
    """Descriptors by place from their arrays laid end to end."""
    total = int(np.sum(state["counts"]))
    rows: list[dict[str, NDArray[Any]]] = [{} for _ in range(total)]
    for name, lengths in _with(state, "lengths_").items():
        flat = np.array(state[f"flat_{name}"])
        for row, part in zip(rows, np.split(flat, np.cumsum(lengths)[:-1]), strict=True):
            row[name] = part
    stops = np.cumsum(state["counts"])
    return {
        int(place): list(rows[stop - count : stop])
        for place, count, stop in zip(state["places"], state["counts"], stops, strict=True)
    }


class DescriptorSystem:
    """A system that is its own metric for the memory of descriptors, but for that metric.

    A place is new where a frame is too unlike the one the place began with.
    """

    POLICY: ClassVar[str] = BY_PLACES

    verify: Any = no_verification
    likelihood = spread_likelihood

    def __init__(self, params: Any) -> None:
        self._params = params

    @property
    def params(self) -> Any:
        """The parameter block."""
        return self._params

    @property
    def rule(self) -> MapRule:
        """New place where a frame is too unlike the one the place began with."""
        return MapRule(self._params.theta, 0, self._params.min_node_obs)

    @property
    def thinning(self) -> Thinning:
        """As the parameters ask."""
        return Thinning(self._params.step_m, float(np.deg2rad(self._params.step_heading_deg)))

    def memory(self) -> Memory:
        """A new, empty memory."""
        return DescriptorMemory(cast("Metric", self))

    def fit(self, signatures: Sequence[Signature]) -> State:
        """Nothing is learned of the mapping run."""
        return {}

    def similarity(self, first: Signature, second: Signature) -> float:
        """Likeness of two descriptors, in [0, 1], without what a mapping run taught."""
        metric = cast("Metric", self)
        one, other = (metric.descriptor(side, {}) for side in (first, second))
        return metric.likeness(one, other, {})
