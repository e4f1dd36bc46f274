"""What the gateway system learned: scenes, types and successions of the places of a map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.geometry import angular_distance, compose, distance, wrap_array
from fpnav.matching.ranking import ranked
from fpnav.sensing.scene import FACINGS
from fpnav.systems.base import Recall, State, Trace
from fpnav.systems.gateway import asr
from fpnav.systems.gateway.asr import LINK, Asr
from fpnav.systems.gateway.bayes import log_evidence, normalised
from fpnav.systems.gateway.evidence import evidence_of, likeness
from fpnav.systems.gateway.model import SHOWN, PlaceModel, observed
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.types import KINDS, NONE
from fpnav.values import FloatArray, Pose2, Signature

STATE = (
    "places", "types", "axis", "visits", "shown", "offsets", "links", "arcs", "counts", "current",
)  # fmt: skip
SAME_RAD = np.pi / 4.0
NOWHERE = (-1, -1)


@dataclass(frozen=True, slots=True, eq=False)
class _Belief:
    """Where the robot was thought to be at the last query of a session."""

    session: int
    places: NDArray[np.int64]
    belief: FloatArray


class GatewayMemory:
    """Places by id, and how often one followed another in travel order."""

    def __init__(self, params: GatewayParams) -> None:
        self._params = params
        self._models: dict[int, PlaceModel] = {}
        self._arcs: dict[tuple[int, int], int] = {}
        self._current = NOWHERE

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, increasing."""
        return np.array(sorted(self._models), dtype=np.int64)

    def model(self, place: int) -> PlaceModel:
        """What was learned at a place."""
        return self._models[place]

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Nothing: what is learned is learned place by place."""

    def learn(self, place: int, signature: Signature) -> None:
        """One more visit of a place, which is made where it is new; and the arc that led there."""
        last, session = self._current
        if last not in (-1, place) and session == signature.reference.session:
            self._arcs[last, place] = self._arcs.get((last, place), 0) + 1
        self._current = place, signature.reference.session
        self._models[place] = observed(self._models.get(place), signature, self._params)

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """A gateway is new unless it is the last one met again: 0 where it stands where that
        stood by dead reckoning, else 1; for mere scenes, how unlike the last one it is."""
        if previous is None:
            return 1.0, trace
        if NONE not in (signature.record["type"], previous.record["type"]):
            return float(not _same_spot(signature, previous, self._params.same_m)), trace
        return 1.0 - likeness(signature, previous, self._params), trace

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places whose scene and type fit each signature best; scores are log evidence."""
        places = self.places
        models = [self._models[int(place)] for place in places]
        scores = evidence_of(signatures, models, self._params)
        if self._params.prior == "topo":
            scores, trace = self._with_prior(signatures, scores, trace)
        columns, values = ranked(scores, k, allowed)
        found = np.where(columns >= 0, np.append(places, -1)[columns], -1)
        axes = np.array([model.axis_rad for model in models] + [np.nan])
        own = np.array([float(one.record["axis_rad"]) for one in signatures])
        headings = np.where(columns >= 0, wrap_array(axes[columns] - own[:, None]), np.nan)
        return Recall(found, values, headings), trace

    def merge(self, keep: int, drop: int) -> None:
        """Both were visits of one place."""
        first, second = self._models[keep], self._models.pop(drop)
        self._models[keep] = PlaceModel(
            asr.united(first.scene, second.scene, self._params),
            first.types + second.types,
            first.shown + second.shown,
            first.axis_rad,
        )
        arcs, self._arcs = self._arcs, {}
        for (a, b), count in sorted(arcs.items()):
            arc = keep if a == drop else a, keep if b == drop else b
            if arc[0] != arc[1]:
                self._arcs[arc] = self._arcs.get(arc, 0) + count
        if self._current[0] == drop:
            self._current = keep, self._current[1]

    def shrink(self, budget: int) -> None:
        """Keep the ``budget`` strongest links of every scene; 0 = no bound."""
        if budget > 0:
            for place, model in self._models.items():
                scene = asr.strongest(model.scene, budget)
                self._models[place] = PlaceModel(scene, model.types, model.shown, model.axis_rad)

    def save(self) -> State:
        """Models as flat arrays by place."""
        models = [self._models[int(place)] for place in self.places]
        arcs = sorted(self._arcs)
        lengths = [len(model.scene.links) for model in models]
        return {
            "places": self.places,
            "types": np.array([m.types for m in models], np.int64).reshape(-1, len(KINDS) + 1),
            "axis": np.array([m.axis_rad for m in models], np.float64),
            "visits": np.array([m.scene.visits for m in models], np.int64).reshape(-1, FACINGS),
            "shown": np.array([m.shown for m in models], np.int64).reshape(-1, *SHOWN),
            "offsets": np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
            "links": np.concatenate([np.zeros(0, LINK), *(m.scene.links for m in models)]),
            "arcs": np.array(arcs, np.int64).reshape(-1, 2),
            "counts": np.array([self._arcs[arc] for arc in arcs], np.int64),
            "current": np.array(self._current, np.int64),
        }

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved.

        Raises
        ------
        StoreError
            An array is missing.
        """
        missing = [name for name in STATE if name not in state]
        if missing:
            raise StoreError(
                f"the gateway memory lacks {', '.join(missing)}; found {', '.join(state)}; "
                "build the map again"
            )
        offsets = state["offsets"]
        self._models = {
            int(place): PlaceModel(
                Asr(
                    np.array(state["links"][offsets[row] : offsets[row + 1]]),
                    np.array(state["visits"][row]),
                ),
                np.array(state["types"][row]),
                np.array(state["shown"][row]),
                float(state["axis"][row]),
            )
            for row, place in enumerate(state["places"])
        }
        self._arcs = {
            (int(a), int(b)): int(count)
            for (a, b), count in zip(state["arcs"], state["counts"], strict=True)
        }
        self._current = int(state["current"][0]), int(state["current"][1])

    def _with_prior(
        self, signatures: Sequence[Signature], scores: FloatArray, trace: Trace
    ) -> tuple[FloatArray, Trace]:
        """Scores with the logarithm of what the previous place and the arcs say of the next."""
        out, belief = scores.copy(), trace
        follows = self._followers()
        for row, signature in enumerate(signatures):
            session = signature.reference.session
            known = isinstance(belief, _Belief) and belief.session == session
            known = known and np.array_equal(belief.places, self.places)
            prior = belief.belief @ follows if known else np.ones(scores.shape[1])
            out[row] += log_evidence(normalised(prior))
            reached = normalised(np.exp(out[row] - out[row].max(initial=-np.inf)))
            belief = _Belief(session, self.places, reached)
        return out, belief

    def _followers(self) -> FloatArray:
        """Probability of each place (column) to be the next after each (row), (P, P)."""
        places = self.places
        table = np.zeros((len(places), len(places)))
        row = {int(place): number for number, place in enumerate(places)}
        for (a, b), count in self._arcs.items():
            table[row[a], row[b]] = count
        even = np.full(table.shape, 1.0 / max(len(places), 1))
        return self._params.stray * even + (1.0 - self._params.stray) * normalised(table)


def _same_spot(first: Signature, second: Signature, within_m: float) -> bool:
    """Whether two gateways met in one session are known to be one by dead reckoning."""
    centres = [_centre(one) for one in (first, second)]
    if centres[0] is None or centres[1] is None:
        return False
    turned = angular_distance(centres[0].heading_rad, centres[1].heading_rad)
    return distance(centres[0], centres[1]) < within_m and bool(turned < SAME_RAD)


def _centre(signature: Signature) -> Pose2 | None:
    """Centre of the gateway in the frame of the odometry, else of the truth."""
    pose = signature.reference.odometry or signature.reference.truth
    if pose is None:
        return None
    record = signature.record
    return compose(pose, Pose2(record["x_m"], record["y_m"], record["axis_rad"]))
