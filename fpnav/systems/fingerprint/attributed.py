"""The metric of fingerprints that carry attributes: one channel per sensor, their evidence summed.

A channel counts where both fingerprints have it; where they share none they are not alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import Features, State
from fpnav.systems.fingerprint.camera import CameraChannel
from fpnav.systems.fingerprint.laser import LaserChannel
from fpnav.systems.fingerprint.letters import LetterChannel
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.values import FloatArray, Signature


class Channel(Protocol):
    """What one sensor says; scores of all channels are in units of their spread."""

    def descriptor(self, signature: Signature) -> Features:
        """What is kept of a signature; arrays of its own names."""
        ...

    def has(self, descriptor: Features) -> bool:
        """Whether the sensor said anything."""
        ...

    def stack(self, descriptors: Sequence[Features]) -> Any:
        """One batch of descriptors that all have something."""
        ...

    def compare(
        self, query: Features, members: Any, rows: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        """Scores and turns of the named rows of a batch, (n,) both."""
        ...

    def likeness(self, first: Features, second: Features) -> float:
        """In [0, 1], 1 for equal ones; symmetric."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Members by channel: its batch, and the row of each member in it, -1 where it has none."""

    parts: tuple[Any, ...]
    rows: tuple[NDArray[np.int64], ...]


class Attributed:
    """Metric over the channels of laser and camera."""

    def __init__(self, params: FingerprintParams) -> None:
        strips = params.camera == "strips" and params.use_camera
        self._learned = CameraChannel() if strips else LetterChannel(params)
        self._channels: tuple[Channel, ...] = (LaserChannel(), self._learned)

    def fit(self, signatures: Sequence[Signature]) -> State:
        """What the camera's symbols are worth."""
        return self._learned.fit(signatures)

    def descriptor(self, signature: Signature, model: State) -> Features:
        """The arrays of all channels."""
        return {k: v for one in self._channels for k, v in one.descriptor(signature).items()}

    def stack(self, descriptors: Sequence[Features]) -> Batch:
        """Every channel's batch."""
        parts, rows = [], []
        for channel in self._channels:
            there = np.array([channel.has(one) for one in descriptors])
            kept = [one for one, has in zip(descriptors, there, strict=True) if has]
            parts.append(channel.stack(kept) if kept else None)
            rows.append(np.where(there, np.cumsum(there) - 1, -1).astype(np.int64))
        return Batch(tuple(parts), tuple(rows))

    def compare(
        self, query: Features, members: Batch, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        """Mean score of the channels both have; the turn of the first that tells one."""
        self._use(model)
        total, count = np.zeros(len(rows)), np.zeros(len(rows))
        turns = np.full(len(rows), np.nan)
        for channel, batch, place in zip(self._channels, members.parts, members.rows, strict=True):
            both = np.flatnonzero(place[rows] >= 0)
            if not channel.has(query) or not len(both):
                continue
            scores, found = channel.compare(query, batch, place[rows[both]])
            total[both] += scores
            count[both] += 1
            turns[both] = np.where(np.isnan(turns[both]), found, turns[both])
        return np.where(count > 0, total / np.maximum(count, 1), 0.0), turns

    def likeness(self, first: Features, second: Features, model: State) -> float:
        """Mean likeness of the channels both have; 1 where neither has any."""
        self._use(model)
        both = [one for one in self._channels if one.has(first) and one.has(second)]
        if not both:
            return float(not any(one.has(first) or one.has(second) for one in self._channels))
        return float(np.mean([channel.likeness(first, second) for channel in both]))

    def _use(self, model: State) -> None:
        if model:
            self._learned.use(model)


def exponential_likelihood(scores: FloatArray) -> FloatArray:
    """exp(s - max s) of each row (..., P); what is not ranked gets the row's least."""
    scores = np.asarray(scores, dtype=np.float64)
    if scores.size == 0:
        return np.ones_like(scores)
    known = np.where(np.isfinite(scores), scores, np.inf).min(axis=-1, keepdims=True)
    filled = np.where(np.isfinite(scores), scores, known)
    filled = np.where(np.isfinite(filled), filled, 0.0)
    return np.asarray(np.exp(filled - filled.max(axis=-1, keepdims=True)))
