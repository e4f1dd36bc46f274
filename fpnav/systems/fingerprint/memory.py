"""What the fingerprint system learned: a mean fingerprint per place, and exemplars beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.angled import angled_ratios
from fpnav.matching.bounds import bags
from fpnav.matching.cyclic import align, best_ratios
from fpnav.matching.ranking import ranked
from fpnav.matching.strings import Strings, concatenated
from fpnav.systems.base import Recall, State, Trace
from fpnav.systems.fingerprint import exemplars, scoring, state
from fpnav.systems.fingerprint.aligner import Aligner, turned
from fpnav.systems.fingerprint.fitting import fitted
from fpnav.systems.fingerprint.mean import Mean, strongest
from fpnav.systems.fingerprint.model import Model, hand_made
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.values import FloatArray, Signature


class FingerprintMemory:
    """Fingerprints by place, the mean first, in the frame of each place's first observation."""

    def __init__(self, params: FingerprintParams) -> None:
        self._params = params
        self._aligner = Aligner(params, hand_made(params))
        self._views: dict[int, list[Mean]] = {}
        self._strings: dict[int, Strings] = {}
        self._current = -1
        self._kept_at: dict[int, tuple[int, float]] = {}

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, increasing."""
        return np.array(sorted(self._views), dtype=np.int64)

    @property
    def model(self) -> Model:
        """What symbols are worth here."""
        return self._aligner.model

    def mean(self, place: int) -> Mean:
        """Mean fingerprint of a place."""
        return self._views[place][0]

    def exemplars(self, place: int) -> list[Mean]:
        """What is kept of a place beside its mean."""
        return self._views[place][1:]

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Learn scores and certainties from a mapping run, as far as the parameters ask for."""
        self._use(fitted(signatures, self._params))

    def learn(self, place: int, signature: Signature) -> None:
        """Fuse one fingerprint into the mean of a place, which is made where it is new."""
        self._current = place
        one = self._aligner.observation(signature)
        if place not in self._views:
            self._is_due(place, signature)
            self._put(place, [one])
            return
        mean, *rest = self._views[place]
        if mean.observations == 1:  # so far the mean is itself what was seen first
            rest = [mean] if self._params.exemplar_m > 0.0 or self._params.exemplars > 0 else []
        rest = self._with_exemplar(place, signature, one, mean, rest)
        self._put(place, [self._aligner.fused(mean, one), *rest])

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """Dissimilarity to the previous fingerprint, to the present place's mean, or the larger."""
        x = self._aligner.strings([signature])
        others: list[Strings | None] = []
        if self._params.compare != "mean":
            others.append(None if previous is None else self._aligner.strings([previous]))
        if self._params.compare != "previous":
            known = self._current in self._views
            others.append(self._aligner.pack([self.mean(self._current)]) if known else None)
        found = [1.0 if one is None else 1.0 - self._aligner.probability(x, one) for one in others]
        return max(found), trace

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places with the fingerprint that aligns best with each one under some rotation."""
        places, queries = self.places, self._aligner.strings(signatures)
        packed, owner = self._packed(places)
        rows, values = self._best_rows(queries, packed, owner, len(places), k, allowed)
        columns, scores = ranked(values, k, allowed)
        found = np.where(columns >= 0, np.append(places, -1)[columns], -1)
        return Recall(found, scores, self._headings(queries, packed, rows, columns)), trace

    def merge(self, keep: int, drop: int) -> None:
        """Fuse what is known of ``drop`` into ``keep``, weighted by observations."""
        mean, *rest = self._views[keep]
        other, *others = self._views.pop(drop)
        turn = self._aligner.turn(mean, other)
        moved = [turned(one, turn) for one in others]
        if self._params.exemplar_m > 0.0:
            rest = [*(rest or [mean]), *(moved or [turned(other, turn)])]
        else:
            for one in moved:
                rest = exemplars.added(rest, one, self._params.exemplars, self._aligner)
        self._strings.pop(drop, None)
        self._put(keep, [self._aligner.fused(mean, other), *rest])
        self._current = keep if self._current == drop else self._current

    def shrink(self, budget: int) -> None:
        """Keep the ``budget`` most certain features of every mean, and no exemplars beyond as
        many; 0 = no bound."""
        if budget > 0:
            for place, views in self._views.items():
                kept = views[: 1 + budget]
                self._put(place, [strongest(view, budget) for view in kept])

    def save(self) -> State:
        """Views as flat arrays by place, and the model they are compared under."""
        return state.saved_views(self._views, self._current, self.model)

    def load(self, saved: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved; raises StoreError where an array is missing."""
        self._views, self._current, model = state.loaded_views(saved)
        self._use(model)

    def probability(self, first: Signature, second: Signature) -> float:
        """prob_matching of two fingerprints, in [0, 1]."""
        return self._aligner.probability(*(self._aligner.strings([one]) for one in (first, second)))

    def _with_exemplar(
        self, place: int, signature: Signature, one: Mean, mean: Mean, rest: list[Mean]
    ) -> list[Mean]:
        """Exemplars of a place after one more fingerprint, in the place's frame."""
        whole = self._params.exemplar_m > 0.0
        wanted = self._is_due(place, signature) if whole else self._params.exemplars > 0
        if not wanted:
            return rest
        seen = turned(one, self._aligner.turn(mean, one))
        if whole:
            return [*rest, seen]
        return exemplars.added(rest, seen, self._params.exemplars, self._aligner)

    def _is_due(self, place: int, signature: Signature) -> bool:
        """Whether the robot came far enough in a place since an exemplar was kept there."""
        reference = signature.reference
        session, kept_m = self._kept_at.get(place, (-1, 0.0))
        if session == reference.session and (
            abs(reference.travelled_m - kept_m) < self._params.exemplar_m
        ):
            return False
        self._kept_at[place] = reference.session, reference.travelled_m
        return True

    def _use(self, model: Model) -> None:
        self._aligner = Aligner(self._params, model)
        self._strings = {}

    def _put(self, place: int, views: list[Mean]) -> None:
        self._views[place] = views
        self._strings.pop(place, None)

    def _packed(self, places: NDArray[np.int64]) -> tuple[Strings, NDArray[np.int64]]:
        """All views of the places as strings, and the column of the place each belongs to."""
        for place in places.tolist():
            if place not in self._strings:
                self._strings[place] = self._aligner.pack(self._views[place])
        parts = [self._strings[place] for place in places.tolist()]
        owner = np.repeat(np.arange(len(places)), [len(part) for part in parts])
        return concatenated(parts), owner.astype(np.int64)

    def _best_rows(
        self,
        queries: Strings,
        packed: Strings,
        owner: NDArray[np.int64],
        count: int,
        k: int,
        allowed: NDArray[np.bool_] | None,
    ) -> tuple[NDArray[np.int64], FloatArray]:
        """Best view of each place and its score, (Q, P); -inf where it cannot be among the k."""
        rows = np.full((len(queries), count), -1, np.int64)
        values = np.full((len(queries), count), -np.inf)
        scores = self.model.scores
        both = bags(queries, scores), bags(packed, scores)
        # the best view of the k-th place is among as many rows as k places can have
        keep = k * int(np.bincount(owner).max(initial=1))
        for q in range(len(queries)):
            wanted = np.arange(len(owner))
            if allowed is not None:
                wanted = wanted[allowed[q][owner]]
            if self._params.angle_deg > 0.0:
                found = self._angled(queries, q, packed, wanted)
            else:
                found = best_ratios(queries, q, packed, wanted, scores, keep, both)
            order = np.lexsort((wanted, -found))[::-1]  # the best view of a place is written last
            rows[q, owner[wanted[order]]] = wanted[order]
            values[q, owner[wanted[order]]] = found[order]
        return rows, values

    def _angled(
        self, queries: Strings, q: int, packed: Strings, rows: NDArray[np.int64]
    ) -> FloatArray:
        width = float(np.deg2rad(self._params.angle_deg))
        return angled_ratios(queries, q, packed, rows, self.model.scores, scoring.EMPTY, width)

    def _headings(
        self,
        queries: Strings,
        packed: Strings,
        rows: NDArray[np.int64],
        columns: NDArray[np.int64],
    ) -> FloatArray:
        """Turn from place to query of the first few of each ranking, (Q, k), else NaN."""
        out = np.full(columns.shape, np.nan)
        for q, ranking in enumerate(columns[:, : self._params.headings]):
            best = rows[q, ranking[ranking >= 0]]
            found = align(queries, q, packed, best, self.model.scores, scoring.EMPTY)
            out[q, : len(best)] = found.psi_rad
        return out
