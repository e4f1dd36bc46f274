"""Fingerprints of places (Tapus, Battaglia, Siegwart): the system as the pipeline sees it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.attributed import SYMBOL as ATTRIBUTED
from fpnav.params import Params
from fpnav.sensing.keypoints import POINT
from fpnav.sensing.rays import RAY
from fpnav.systems.base import (
    BY_PLACES,
    Features,
    MapRule,
    Memory,
    Needs,
    Picture,
    Thinning,
    Verification,
    spread_likelihood,
)
from fpnav.systems.fingerprint.attributed import Attributed, exponential_likelihood
from fpnav.systems.fingerprint.camera import (
    NO_CAMERA,
    NO_STRIPS,
    STRIP,
    camera_features,
    standardised,
)
from fpnav.systems.fingerprint.chosen import ChosenMemory, one_sensor
from fpnav.systems.fingerprint.extract import CAMERA_ROLES, features_of_frame, rays_of_frame
from fpnav.systems.fingerprint.following import counted
from fpnav.systems.fingerprint.laser import attributes_of
from fpnav.systems.fingerprint.memory import FingerprintMemory
from fpnav.systems.fingerprint.params import LATE, PRESETS, FingerprintParams
from fpnav.systems.fingerprint.record import LASER_ARC, RECORD, insertion, record_of
from fpnav.systems.fingerprint.symbols import FEATURE, SYMBOL, symbols_of, text
from fpnav.systems.fingerprint.verification import verified
from fpnav.systems.fingerprint.windows import windowed
from fpnav.values import FloatArray, Frame, Reference, Signature


class Fingerprint:
    """Circular strings of corners, vertical edges and colours, aligned with uncertainty."""

    NAME: ClassVar[str] = "fingerprint"
    SUMMARY: ClassVar[str] = (
        "circular strings of corners c, vertical edges v, both at once f, hues A to P and empty "
        "space n (Tapus et al.)"
    )
    NEEDS: ClassVar[Needs] = Needs(("scan", *CAMERA_ROLES), (("scan", *CAMERA_ROLES),))
    PARAMS: ClassVar[type[Params]] = FingerprintParams
    LATE: ClassVar[frozenset[str]] = LATE
    PRESETS: ClassVar[Mapping[str, Params]] = PRESETS
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {
        "features": FEATURE,
        "symbols": SYMBOL,
        "rays": RAY,
        "attributes": ATTRIBUTED,
        "strips": STRIP,
        "points": POINT,
    }
    POLICY: ClassVar[str] = BY_PLACES

    def __init__(self, params: FingerprintParams) -> None:
        self._params = params

    @property
    def params(self) -> FingerprintParams:
        """The parameter block."""
        return self._params

    @property
    def rule(self) -> MapRule:
        """New place where the dissimilarity passes theta, or where the run changes."""
        p = self._params
        if p.segment == "changepoint":
            return MapRule(p.theta, p.nodes, p.min_node_obs, p.window, p.penalty)
        return MapRule(p.theta, p.nodes, p.min_node_obs)

    @property
    def thinning(self) -> Thinning:
        """One fingerprint every step of travel."""
        return Thinning(self._params.step_m, float(np.deg2rad(self._params.step_heading_deg)))

    def describe(self, frame: Frame) -> Features:
        """Features of one frame and the arcs its sensors covered."""
        features, arcs = features_of_frame(frame, self._params)
        rays, mount = rays_of_frame(frame, self._params)
        alone = frame.scan is None or not self._params.use_laser
        looks = alone and self._params.camera == "strips" and self._params.use_camera
        return {
            **(camera_features(frame) if looks else NO_CAMERA),
            "features": features,
            "arcs": arcs,
            "rays": rays,
            "attributes": attributes_of(features, rays, mount, arcs[LASER_ARC]),
            "mount_m": mount,
        }

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """One fingerprint per frame: f and n inserted, in angular order; features know how many of
        the last ones had them.

        Strips are standardised over the run, which must be seen whole before the first one.
        """
        if self._params.window_m > 0.0 and self._params.ray_deg > 0.0:
            stream = windowed(stream, self._params)
        stream = counted(stream)
        if self._params.camera == "letters":
            yield from (self._signature(one, found, NO_STRIPS) for one, found in stream)
            return
        run = list(stream)
        for (reference, found), strips in zip(
            run, standardised([found for _, found in run]), strict=True
        ):
            yield self._signature(reference, found, strips)

    def _signature(
        self, reference: Reference, found: Features, strips: NDArray[np.void]
    ) -> Signature:
        features, arcs = found["features"], found["arcs"]
        symbols = symbols_of(features, arcs, **insertion(self._params))
        parts = {name: found[name] for name in ("features", "rays", "attributes", "points")}
        return Signature(
            reference,
            record_of(arcs, symbols["type"].tobytes(), found["mount_m"]),
            {**parts, "symbols": symbols, "strips": strips},
        )

    def memory(self) -> Memory:
        """A new, empty memory."""
        if self._params.memory == "chosen":
            return ChosenMemory(self._params)
        return FingerprintMemory(self._params)

    def similarity(self, first: Signature, second: Signature) -> float:
        """prob_matching of two fingerprints; of one sensor, how alike their attributes are."""
        if self._params.memory == "chosen" and one_sensor([first, second]):
            metric = Attributed(self._params)
            one, other = (metric.descriptor(side, {}) for side in (first, second))
            return metric.likeness(one, other, {})
        return FingerprintMemory(self._params).probability(first, second)

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification | None:
        """Scans laid over each other; None without rays to do so."""
        return verified(query, candidates, self._params) if self._params.ray_deg > 0.0 else None

    def likelihood(self, scores: FloatArray) -> FloatArray:
        """Ratios of letters, none above 1, are spread as they come; scores of attributes are in
        units of their spread, and so log-likelihoods but for their dependence."""
        known = np.where(np.isfinite(scores), scores, 0.0)
        attributes = known.max(axis=-1, keepdims=True, initial=0.0) > 1.0 + 1e-9
        spread, steep = spread_likelihood(self, scores), exponential_likelihood(scores)
        return np.where(attributes, steep, spread)

    def picture(self, signature: Signature) -> Picture:
        """A strip: every symbol at its bearing with its certainty, and the string."""
        symbols = signature.parts["symbols"]
        line = text(symbols)
        return Picture(
            "strip",
            symbols["angle_rad"].astype(np.float64),
            symbols["certainty"].astype(np.float64),
            symbols=tuple(line),
            text=line,
        )
