"""A tiny system, one histogram a signature: other rooms are tested without the real ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.geometry import wrap_array
from fpnav.params import Params
from fpnav.systems.base import (
    BY_PLACES,
    Features,
    MapRule,
    Needs,
    Picture,
    Recall,
    State,
    Thinning,
    Trace,
    Verification,
    spread_likelihood,
)
from fpnav.values import FloatArray, Frame, Pose2, Reference, RelativePose, Signature

RECORD = np.dtype([("heading_rad", "<f8"), ("detail", "<f8")])
BIN = np.dtype([("height", "<f8")])


class ToyParams(Params, frozen=True):
    theta: float | Literal["auto", "otsu"] = 0.5
    nodes: int = 0
    min_observations: int = 1
    verifies: bool = False
    whole: bool = True


class ToyMemory:
    """Sum of the histograms of each place; the heading of its first signature."""

    def __init__(self) -> None:
        self._sums: dict[int, FloatArray] = {}
        self._heading: dict[int, float] = {}
        self._counts: dict[int, int] = {}

    @property
    def places(self) -> NDArray[np.int64]:
        return np.array(sorted(self._sums), dtype=np.int64)

    def fit(self, signatures: Sequence[Signature]) -> None:
        pass

    def learn(self, place: int, signature: Signature) -> None:
        bins = heights(signature)
        self._heading.setdefault(place, float(signature.record["heading_rad"]))
        self._sums[place] = self._sums.get(place, np.zeros(len(bins))) + bins
        self._counts[place] = self._counts.get(place, 0) + 1

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        likeness = 0.0 if previous is None else intersection(heights(signature), heights(previous))
        return 1.0 - likeness, (trace or 0) + 1

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        scores = self._scores(signatures)
        if allowed is not None:
            scores[~allowed] = -np.inf
        padded = np.hstack([scores, np.full((len(signatures), k), -np.inf)])
        order = np.argsort(-padded, axis=1, kind="stable")[:, :k]
        found = np.take_along_axis(padded, order, axis=1)
        places = np.append(self.places, np.full(k, -1))[order]
        places[~np.isfinite(found)] = -1
        return Recall(places, found, self._headings(signatures, places)), (trace or 0) + 1

    def _scores(self, signatures: Sequence[Signature]) -> FloatArray:
        scores = np.zeros((len(signatures), len(self._sums)))
        if scores.size:
            means = np.array([self._sums[p] / self._counts[p] for p in self.places])
            queries = np.array([heights(signature) for signature in signatures])
            for column in range(means.shape[1]):
                scores += np.minimum.outer(queries[:, column], means[:, column])
        return scores

    def _headings(self, signatures: Sequence[Signature], places: NDArray[np.int64]) -> FloatArray:
        own = np.array([float(signature.record["heading_rad"]) for signature in signatures])
        known = np.array([[self._heading.get(p, math.nan) for p in row] for row in places.tolist()])
        return wrap_array(own.reshape(-1, 1) - known.reshape(places.shape))

    def merge(self, keep: int, drop: int) -> None:
        self._sums[keep] = self._sums[keep] + self._sums.pop(drop)
        self._counts[keep] += self._counts.pop(drop)
        self._heading.pop(drop)

    def shrink(self, budget: int) -> None:
        pass

    def save(self) -> State:
        return {
            "places": self.places,
            "sums": np.array([self._sums[p] for p in self.places]),
            "counts": np.array([self._counts[p] for p in self.places]),
            "headings": np.array([self._heading[p] for p in self.places]),
            "scalar": np.array(0.5),
        }

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        if "places" not in state:
            raise StoreError("the toy memory lacks places")
        places = [int(place) for place in state["places"]]
        self._sums = dict(zip(places, state["sums"], strict=True))
        self._counts = dict(zip(places, state["counts"].tolist(), strict=True))
        self._heading = dict(zip(places, state["headings"].tolist(), strict=True))


class Toy:
    """Places recognised by histogram intersection; ``detail`` decides in verification."""

    NAME: ClassVar[str] = "toy"
    SUMMARY: ClassVar[str] = "one histogram a place"
    NEEDS: ClassVar[Needs] = Needs(("scan",), (("scan",),))
    PARAMS: ClassVar[type[Params]] = ToyParams
    LATE: ClassVar[frozenset[str]] = frozenset({"theta", "nodes"})
    PRESETS: ClassVar[Mapping[str, Params]] = {"default": ToyParams()}
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"bins": BIN}
    POLICY: ClassVar[str] = BY_PLACES

    likelihood = spread_likelihood

    def __init__(self, params: ToyParams | None = None) -> None:
        self._params = params or ToyParams()

    @property
    def params(self) -> ToyParams:
        return self._params

    @property
    def rule(self) -> MapRule:
        p = self._params
        return MapRule(p.theta, p.nodes, p.min_observations)

    @property
    def thinning(self) -> Thinning:
        return Thinning()

    def describe(self, frame: Frame) -> Features:
        ranges = np.zeros(0) if frame.scan is None else frame.scan.ranges_m[frame.scan.valid]
        counts, _ = np.histogram(ranges, bins=8, range=(0.0, 8.0))
        return {"bins": counts / max(1, counts.sum())}

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        for reference, features in stream:
            yield signature_of(reference, features["bins"])

    def memory(self) -> ToyMemory:
        return ToyMemory()

    def similarity(self, first: Signature, second: Signature) -> float:
        return intersection(heights(first), heights(second))

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification | None:
        if not self._params.verifies:
            return None
        apart = [
            float(query.record["detail"]) - float(other.record["detail"]) for other in candidates
        ]
        poses = tuple(
            RelativePose(Pose2(gap, 0.0, 0.0), tuple(np.eye(3).ravel().tolist())) for gap in apart
        )
        return Verification(100.0 - np.abs(np.array(apart)), poses, whole=self._params.whole)

    def picture(self, signature: Signature) -> Picture:
        bins = heights(signature)
        text = "".join(str(min(9, round(10 * height))) for height in bins)
        return Picture("curve", np.linspace(0, 1, len(bins)), bins, text=text)


def heights(signature: Signature) -> FloatArray:
    """Histogram of a signature."""
    return np.asarray(signature.parts["bins"]["height"], dtype=np.float64)


def intersection(first: FloatArray, second: FloatArray) -> float:
    """Histogram intersection of two normalised histograms, in [0, 1]."""
    return float(np.minimum(first, second).sum())


def signature_of(
    reference: Reference, bins: Sequence[float] | FloatArray, *, detail: float = 0.0
) -> Signature:
    """Toy signature of a histogram; its heading is that of the odometry, else 0."""
    heading = 0.0 if reference.odometry is None else reference.odometry.heading_rad
    rows = np.zeros(len(bins), dtype=BIN)
    rows["height"] = bins
    return Signature(reference, np.array([(heading, detail)], dtype=RECORD)[0], {"bins": rows})


def mixed(first: int, second: int, share: float, bins: int = 8) -> FloatArray:
    """Histogram that is ``1 - share`` in one bin and ``share`` in another."""
    out = np.zeros(bins)
    out[first % bins] += 1.0 - share
    out[second % bins] += share
    return out


def one_hot(place: int, bins: int = 8) -> FloatArray:
    """Histogram with everything in one bin."""
    return mixed(place, place, 0.0, bins)


def drive(
    places: Sequence[int],
    *,
    step_m: float = 1.0,
    session: int = 0,
    labels: Sequence[str] = (),
    bins: int = 8,
) -> list[Signature]:
    """A straight drive along x; each signature looks like the place of that number."""
    return [
        signature_of(
            Reference(
                index=row,
                stamp_ns=row * 10**9,
                session=session,
                travelled_m=row * step_m,
                odometry=Pose2(row * step_m, 0.0, 0.0),
                label=labels[row] if labels else "",
            ),
            one_hot(place, bins),
        )
        for row, place in enumerate(places)
    ]
