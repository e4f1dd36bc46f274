"""The contract of a system, and the standard parts a system takes by assignment.

A system is a class built with its parameter block. Everything outside ``fpnav.systems`` sees only
the protocols below; no other room names a system, its sizes or its symbols.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Params
from fpnav.values import PRIMARY_ROLES, FloatArray, Frame, Reference, RelativePose, Signature

Features = Mapping[str, NDArray[Any]]
"""What ``describe`` makes of one frame: named arrays, cheap to send between processes."""

State = dict[str, NDArray[Any]]
"""What a memory learned, as named arrays that the store writes as they are."""

Trace = Any
"""Short-term state of a stream, made by the system, passed explicitly, opaque to others."""


@dataclass(frozen=True, slots=True)
class Needs:
    """Roles a system can use, and the groups it must have: one role of every group.

    ``frames_on`` : whose stamps its frames stand on, the first present; another order than the
    usual one is for a system that drives by one sensor and looks up with another now and then.
    """

    uses: tuple[str, ...]
    must: tuple[tuple[str, ...], ...]
    frames_on: tuple[str, ...] = PRIMARY_ROLES

    def missing(self, roles: Iterable[str]) -> tuple[tuple[str, ...], ...]:
        """The groups of which no role is present."""
        present = set(roles)
        return tuple(group for group in self.must if not present.intersection(group))


@dataclass(frozen=True, slots=True)
class MapRule:
    """How a stream of novelties becomes places.

    ``threshold`` is a number, ``auto`` (the quantile of consecutive novelties that gives
    ``nodes`` places) or ``otsu`` (the valley of their histogram, limited to 0.3 .. 0.8).
    With a ``window`` > 0 places are cut offline instead, where the ``window`` signatures before and
    after are less alike than usual by ``penalty``; the threshold then only says what is unlike.
    ``budget`` : units kept of each place once all are learned; 0 = all.
    ``sequences`` : a place has few signatures, so that loops show as a sequence that comes again.
    """

    threshold: float | Literal["auto", "otsu"]
    nodes: int = 0
    min_observations: int = 2
    window: int = 0
    penalty: float = 0.0
    budget: int = 0
    sequences: bool = False


@dataclass(frozen=True, slots=True)
class Thinning:
    """Least travel between two frames that are used; 0 = every frame."""

    step_m: float = 0.0
    step_heading_rad: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Recall:
    """Answer to a batch of Q queries, best first, padded with place -1 and score -inf.

    ``places``, ``scores``, ``headings_rad`` : (Q, k). Scores grow with likeness and are only
    comparable within one system and parameter block; ``headings_rad`` is the rotation from the
    place's frame to the query's (query heading minus place heading), NaN where the system has
    none. Ties are ordered by place id.
    """

    places: NDArray[np.int64]
    scores: FloatArray
    headings_rad: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """Outcome of the geometric check of one query against n candidates, in their order.

    ``scores`` : (n,) float64, replaces the recall scores for ranking; ``relative`` : n poses of
    the query as seen from each candidate, None where the check gives none; ``stated`` : (n,)
    probability that each is the same place, None where the system leaves that to its scores;
    ``whole`` : whether the check looked at every sensor that the ranking went by.
    """

    scores: FloatArray
    relative: tuple[RelativePose | None, ...]
    stated: FloatArray | None = None
    whole: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Something to draw of a signature; ``kind`` says how: strip, curve, grid or scan.

    strip: ``bearings_rad`` (n,), ``weights`` (n,), ``symbols`` n short strings.
    curve: ``bearings_rad`` (n,), ``weights`` (n,). grid: ``values`` (rows, columns).
    scan: ``values`` (n, 2) points in metres.
    """

    kind: Literal["strip", "curve", "grid", "scan"]
    bearings_rad: FloatArray
    weights: FloatArray
    symbols: tuple[str, ...] = ()
    values: FloatArray | None = None
    text: str = ""


class Memory(Protocol):
    """What a system learned about the places of one map."""

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, (P,), increasing."""
        ...

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Learn what concerns the whole mapping run: rarity, scores, statistics."""
        ...

    def learn(self, place: int, signature: Signature) -> None:
        """Add one observation to a place, which is made where it is new."""
        ...

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """How unlike the present place a signature is, in [0, 1]; the trace starts as None."""
        ...

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places most like each signature.

        ``allowed`` : (Q, P) bool over ``places``, None = all; a place that is not allowed never
        appears. The trace starts as None.
        """
        ...

    def merge(self, keep: int, drop: int) -> None:
        """Fuse what was learned at two places under the id ``keep``."""
        ...

    def shrink(self, budget: int) -> None:
        """Forget the least useful until at most ``budget`` units a place are kept; 0 = no bound."""
        ...

    def save(self) -> State:
        """Everything learned, as named arrays."""
        ...

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved; raises StoreError where arrays are missing."""
        ...


class System(Protocol):
    """One way to recognise places. Built with its parameter block; holds no other state.

    LATE names the parameters that act on signatures only, not in making them: files that differ
    in no other parameter may be joined. POLICY names how a robot goes by its maps (see
    fpnav.navigation.registry).
    """

    NAME: ClassVar[str]
    SUMMARY: ClassVar[str]
    NEEDS: ClassVar[Needs]
    PARAMS: ClassVar[type[Params]]
    LATE: ClassVar[frozenset[str]]
    PRESETS: ClassVar[Mapping[str, Params]]
    RECORD: ClassVar[np.dtype[Any]]
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]]
    POLICY: ClassVar[str]

    def __init__(self, params: Any) -> None: ...

    @property
    def params(self) -> Params:
        """The parameter block the system was built with."""
        ...

    @property
    def rule(self) -> MapRule:
        """How its novelties become places."""
        ...

    @property
    def thinning(self) -> Thinning:
        """Frames it wants: the preset's step, which ``--step`` overrides."""
        ...

    def describe(self, frame: Frame) -> Features:
        """Features of one frame: pure and heavy, this is what is spread over cores."""
        ...

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """Signatures from features in travel order: cheap; short-term state lives here."""
        ...

    def memory(self) -> Memory:
        """A new, empty memory."""
        ...

    def similarity(self, first: Signature, second: Signature) -> float:
        """How alike two signatures are, in [0, 1], 1 for equal ones; symmetric."""
        ...

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification | None:
        """Geometric check of the best candidates; None where the system has no such check."""
        ...

    def likelihood(self, scores: FloatArray) -> FloatArray:
        """Likelihood of an observation at each place, from recall scores (..., P); -inf gives the
        least; the largest of each row is 1."""
        ...

    def picture(self, signature: Signature) -> Picture:
        """What to draw for a person who asks what this place looks like to the system."""
        ...


BY_PLACES = "place-action"
"""Standard part ``POLICY``: go in the direction attached to the place recognised."""

BY_WALLS = "wall-following"
"""Standard part ``POLICY``: follow walls and stop in the openings between them."""


def no_verification(
    self: object, query: Signature, candidates: Sequence[Signature]
) -> Verification | None:
    """Standard part ``verify``: the system has no geometric check."""
    return None


def spread_likelihood(self: object, scores: FloatArray) -> FloatArray:
    """Standard part ``likelihood``: exp(lambda (s - max s)), lambda = ln 5 / (q97.5 - q2.5).

    The quantiles are those of each row (systems.md 1.9.2, after ProbFiltersVPR); rows without
    spread are flat.
    """
    scores = np.asarray(scores, dtype=np.float64)
    if scores.size == 0:
        return np.ones_like(scores)
    finite = np.isfinite(scores)
    known = np.where(finite, scores, np.nan)
    known[~finite.any(axis=-1)] = 0.0
    low, high = np.nanquantile(known, [0.025, 0.975], axis=-1, keepdims=True)
    spread = high - low
    lam = np.where(spread > 1e-12, np.log(5.0) / np.maximum(spread, 1e-12), 0.0)
    values = np.exp(lam * (known - np.nanmax(known, axis=-1, keepdims=True)))
    least = np.nanmin(values, axis=-1, keepdims=True)
    return np.asarray(np.where(np.isnan(values), least, values), dtype=np.float64)
