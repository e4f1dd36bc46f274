"""Several systems on one log: ``-s a+b``, a system like any other.

The first owns the places: its signatures are the steps of the walk and its novelties cut them.
Every system's scores become log-likelihood ratios, learned on the mapping run, and these add; a
system that is silent, or knows nothing of a place, adds nothing.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError, UsageError
from fpnav.matching.ranking import ranked
from fpnav.params import Params
from fpnav.systems.base import (
    BY_PLACES,
    Features,
    MapRule,
    Memory,
    Needs,
    Picture,
    Recall,
    State,
    System,
    Thinning,
    Trace,
    no_verification,
)
from fpnav.systems.calibration import Evidence, evidence_of
from fpnav.values import PRIMARY_ROLES, FloatArray, Frame, Reference, Signature

PLUS, DOT, EVIDENCE = "+", ".", "evidence"


class Joined:
    """A system made of others; its class attributes are made by ``joined_class``."""

    NAME: ClassVar[str]
    SUMMARY: ClassVar[str]
    NEEDS: ClassVar[Needs]
    POLICY: ClassVar[str] = BY_PLACES
    PARAMS: ClassVar[type[Params]]
    LATE: ClassVar[frozenset[str]]
    PRESETS: ClassVar[Mapping[str, Params]]
    RECORD: ClassVar[np.dtype[Any]]
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]]
    MEMBERS: ClassVar[tuple[type[System], ...]]

    verify = no_verification

    def __init__(self, params: Any) -> None:
        self._params = params
        self.members = tuple(kind(getattr(params, kind.NAME)) for kind in self.MEMBERS)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.MEMBERS, self._params_by_name())

    def _params_by_name(self) -> dict[str, Params]:
        return {one.NAME: one.params for one in self.members}

    @property
    def params(self) -> Any:
        """A block of blocks, one a member."""
        return self._params

    @property
    def rule(self) -> MapRule:
        """The first member's."""
        return self.members[0].rule

    @property
    def thinning(self) -> Thinning:
        """The first member's."""
        return self.members[0].thinning

    def describe(self, frame: Frame) -> Features:
        """Features of every member, under its name."""
        return {
            f"{one.NAME}{DOT}{name}": array
            for one in self.members
            for name, array in one.describe(frame).items()
        }

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """The first member's signatures, each with those the others made at the same stamp."""
        streams = itertools.tee(stream, len(self.members))
        lead, *rest = (
            one.assemble(_of_member(part, one.NAME))
            for one, part in zip(self.members, streams, strict=True)
        )
        others = [_Follower(signatures) for signatures in rest]
        for signature in lead:
            stamp = signature.reference.session, signature.reference.stamp_ns
            yield self._together([signature, *(other.at(stamp) for other in others)])

    def memory(self) -> Memory:
        """A new, empty memory."""
        return JoinedMemory(self)

    def similarity(self, first: Signature, second: Signature) -> float:
        """Mean over the members that made something of both; 1 where none did."""
        pairs = ((one, self.of(one, first), self.of(one, second)) for one in self.members)
        found = [one.similarity(a, b) for one, a, b in pairs if a is not None and b is not None]
        return float(np.mean(found)) if found else 1.0

    def likelihood(self, scores: FloatArray) -> FloatArray:
        """Scores are log-likelihood ratios already: exp(s - max s)."""
        known = np.where(np.isfinite(scores), scores, np.nan)
        known[~np.isfinite(scores).any(axis=-1)] = 0.0
        values = np.exp(known - np.nanmax(known, axis=-1, keepdims=True))
        least = np.nanmin(values, axis=-1, keepdims=True)
        return np.asarray(np.where(np.isnan(values), least, values), np.float64)

    def picture(self, signature: Signature) -> Picture:
        """The first member's."""
        own = self.of(self.members[0], signature)
        return self.members[0].picture(signature if own is None else own)

    def of(self, member: System, signature: Signature) -> Signature | None:
        """A member's own signature; None where it made none."""
        if not signature.record[_seen(member.NAME)]:
            return None
        parts = {name: signature.parts[f"{member.NAME}{DOT}{name}"] for name in member.PARTS}
        return Signature(signature.reference, signature.record[member.NAME], parts)

    def _together(self, signatures: Sequence[Signature | None]) -> Signature:
        record = np.zeros(1, self.RECORD)
        parts: dict[str, NDArray[Any]] = {}
        for member, one in zip(self.members, signatures, strict=True):
            record[_seen(member.NAME)] = one is not None
            if one is not None:
                record[member.NAME] = one.record
            for name, dtype in member.PARTS.items():
                rows = np.zeros(0, dtype) if one is None else one.parts[name]
                parts[f"{member.NAME}{DOT}{name}"] = rows
        lead = signatures[0]
        if lead is None:
            raise StoreError("the first of joined systems made no signature; this is a bug")
        value: np.void = record[0]
        return Signature(lead.reference, value, parts)


class JoinedMemory:
    """The members' memories; places are the first's."""

    def __init__(self, system: Joined) -> None:
        self._system = system
        self._memories = [one.memory() for one in system.members]
        self._evidence = [Evidence() for _ in system.members]

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places the first member learned."""
        return self._memories[0].places

    def fit(self, signatures: Sequence[Signature]) -> None:
        """What every member learns of the run, and what its scores there are worth."""
        for at, member in enumerate(self._system.members):
            own = [found for one in signatures if (found := self._system.of(member, one))]
            if own:
                self._memories[at].fit(own)
            self._evidence[at] = evidence_of(member, own)

    def learn(self, place: int, signature: Signature) -> None:
        """Every member that made something of it learns it at the place."""
        for member, memory in zip(self._system.members, self._memories, strict=True):
            own = self._system.of(member, signature)
            if own is not None:
                memory.learn(place, own)

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """The first member's."""
        lead = self._system.members[0]
        own = self._system.of(lead, signature)
        before = None if previous is None else self._system.of(lead, previous)
        return self._memories[0].novelty(signature if own is None else own, before, trace)

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """Places by the sum of log-likelihood ratios; headings of the first that tells one."""
        places = self.places
        shape = (len(signatures), len(places))
        total, headings = np.zeros(shape), np.full(shape, np.nan)
        traces = list(trace) if trace is not None else [None] * len(self._memories)
        for at, member in enumerate(self._system.members):
            rows = [r for r, one in enumerate(signatures) if self._system.of(member, one)]
            if not rows or not len(places):
                continue
            some = None if allowed is None else self._masked(at, allowed[rows], places)
            own = [self._system.of(member, signatures[row]) for row in rows]
            asked = [one for one in own if one is not None]
            known = max(1, len(self._memories[at].places))
            found, traces[at] = self._memories[at].recall(asked, known, some, traces[at])
            scores, turns = _by_place(found, places)
            total[rows] += self._evidence[at].ratios(scores)
            headings[rows] = np.where(np.isnan(headings[rows]), turns, headings[rows])
        columns, scores = ranked(total, k, allowed)
        there = columns >= 0
        ids, out = np.full(columns.shape, -1, np.int64), np.full(columns.shape, np.nan)
        ids[there] = places[columns[there]]
        out[there] = headings[np.nonzero(there)[0], columns[there]]
        return Recall(ids, scores, out), tuple(traces)

    def merge(self, keep: int, drop: int) -> None:
        """Fuse in every member that knows both; one that knows only the dropped forgets it."""
        for memory in self._memories:
            known = set(memory.places.tolist())
            if {keep, drop} <= known:
                memory.merge(keep, drop)

    def shrink(self, budget: int) -> None:
        """Every member keeps so much."""
        for memory in self._memories:
            memory.shrink(budget)

    def save(self) -> State:
        """Every member's arrays under its name, and what its scores are worth."""
        state: State = {EVIDENCE: np.array([one.saved() for one in self._evidence])}
        for member, memory in zip(self._system.members, self._memories, strict=True):
            mark = f"{member.NAME}{DOT}"
            state |= {mark + key: array for key, array in memory.save().items()}
        return state

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved; raises StoreError where an array is missing."""
        if EVIDENCE not in state:
            raise StoreError(f"the joined memory lacks {EVIDENCE}; build the map again")
        self._evidence = [Evidence.of(row) for row in state[EVIDENCE]]
        for member, memory in zip(self._system.members, self._memories, strict=True):
            mark = f"{member.NAME}{DOT}"
            memory.load({k.removeprefix(mark): a for k, a in state.items() if k.startswith(mark)})

    def _masked(
        self, at: int, allowed: NDArray[np.bool_], places: NDArray[np.int64]
    ) -> NDArray[np.bool_]:
        """The mask over the places a member knows."""
        known = self._memories[at].places
        columns = np.searchsorted(places, known)
        inside = (columns < len(places)) & (places[np.minimum(columns, len(places) - 1)] == known)
        return np.where(inside, allowed[:, np.minimum(columns, len(places) - 1)], False)


class _Follower:
    """Signatures of a member that does not lead, asked for by stamp in rising order."""

    def __init__(self, signatures: Iterator[Signature]) -> None:
        self._signatures = signatures
        self._next: Signature | None = next(signatures, None)

    def at(self, stamp: tuple[int, int]) -> Signature | None:
        while self._next is not None and self._key(self._next) < stamp:
            self._next = next(self._signatures, None)
        found = self._next
        return found if found is not None and self._key(found) == stamp else None

    @staticmethod
    def _key(signature: Signature) -> tuple[int, int]:
        return signature.reference.session, signature.reference.stamp_ns


def joined_class(kinds: Sequence[type[System]]) -> type[Joined]:
    """The class that joins systems, the first of them in the lead.

    Raises
    ------
    UsageError
        Fewer than two systems, or one of them twice.
    """
    names = [kind.NAME for kind in kinds]
    name = PLUS.join(names)
    if len(names) < 2 or len(set(names)) < len(names):
        raise UsageError(f"no system {name!r}: join different systems, as a+b")
    block = msgspec.defstruct(
        "JoinedParams",
        [(kind.NAME, kind.PARAMS) for kind in kinds],
        bases=(Params,),
        frozen=True,
        forbid_unknown_fields=True,
        kw_only=True,
    )
    presets = [preset for preset in kinds[0].PRESETS if all(preset in k.PRESETS for k in kinds)]
    fields = [(kind.NAME, kind.RECORD) for kind in kinds]
    return type(
        "Joined",
        (Joined,),
        {
            "NAME": name,
            "SUMMARY": " and ".join(names) + ", their evidence added",
            "NEEDS": _needs(kinds),
            "PARAMS": block,
            "LATE": frozenset(f"{k.NAME}{DOT}{late}" for k in kinds for late in k.LATE),
            "PRESETS": {
                preset: block(**{kind.NAME: kind.PRESETS[preset] for kind in kinds})
                for preset in presets
            },
            "RECORD": np.dtype(fields + [(_seen(kind.NAME), "?") for kind in kinds]),
            "PARTS": {
                f"{k.NAME}{DOT}{part}": dtype for k in kinds for part, dtype in k.PARTS.items()
            },
            "MEMBERS": tuple(kinds),
            "POLICY": kinds[0].POLICY,
        },
    )


def _again(kinds: tuple[type[System], ...], blocks: Mapping[str, Params]) -> Joined:
    """The joined system of a pickle."""
    kind = joined_class(kinds)
    return kind(kind.PARAMS(**blocks))


def _needs(kinds: Sequence[type[System]]) -> Needs:
    """All roles any can use; what each must have."""
    uses = tuple(dict.fromkeys(role for kind in kinds for role in kind.NEEDS.uses))
    must = tuple(dict.fromkeys(group for kind in kinds for group in kind.NEEDS.must))
    orders = [kind.NEEDS.frames_on for kind in kinds if kind.NEEDS.frames_on != PRIMARY_ROLES]
    return Needs(uses, must, orders[0] if orders else PRIMARY_ROLES)


def _seen(name: str) -> str:
    return f"{name}_seen"


def _of_member(
    stream: Iterable[tuple[Reference, Features]], name: str
) -> Iterator[tuple[Reference, Features]]:
    mark = f"{name}{DOT}"
    for reference, features in stream:
        own = {k.removeprefix(mark): v for k, v in features.items() if k.startswith(mark)}
        yield reference, own


def _by_place(found: Recall, places: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Scores and headings over the given places, (Q, P); -inf and NaN where not ranked."""
    shape = (len(found.places), len(places))
    scores, headings = np.full(shape, -np.inf), np.full(shape, np.nan)
    rows, ranks = np.nonzero(np.isin(found.places, places))
    columns = np.searchsorted(places, found.places[rows, ranks])
    scores[rows, columns] = found.scores[rows, ranks]
    headings[rows, columns] = found.headings_rad[rows, ranks]
    return scores, headings
