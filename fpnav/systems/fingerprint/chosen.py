"""The memory that suits a mapping run: members with attributes for one sensor, else means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.systems.base import Memory, Recall, State, Trace
from fpnav.systems.descriptors import DescriptorMemory
from fpnav.systems.fingerprint.attributed import Attributed
from fpnav.systems.fingerprint.memory import FingerprintMemory
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.record import CAMERA_ARC, arcs_of
from fpnav.values import Signature

KIND = "members"


def one_sensor(signatures: Sequence[Signature]) -> bool:
    """Whether there are rays and no camera saw anything, or strips of a camera and no rays."""
    lasers = any(len(one.parts["rays"]) > 0 for one in signatures)
    if any(len(one.parts["strips"]) > 0 for one in signatures):
        return not lasers
    return lasers and not any(arcs_of(one)[CAMERA_ARC, 1] > 0.0 for one in signatures)


class ChosenMemory:
    """One of two memories, chosen when it is fitted to the mapping run."""

    def __init__(self, params: FingerprintParams) -> None:
        self._params = params
        self._inner: Memory = FingerprintMemory(params)

    @property
    def places(self) -> NDArray[np.int64]:
        """Ids of the places learned, increasing."""
        return self._inner.places

    def fit(self, signatures: Sequence[Signature]) -> None:
        """Choose, and learn what concerns the whole run."""
        self._choose(members=one_sensor(signatures))
        self._inner.fit(signatures)

    def learn(self, place: int, signature: Signature) -> None:
        """Add one fingerprint to a place."""
        self._inner.learn(place, signature)

    def novelty(
        self, signature: Signature, previous: Signature | None, trace: Trace
    ) -> tuple[float, Trace]:
        """How unlike the present place a fingerprint is."""
        return self._inner.novelty(signature, previous, trace)

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places most like each fingerprint."""
        return self._inner.recall(signatures, k, allowed, trace)

    def merge(self, keep: int, drop: int) -> None:
        """Fuse two places."""
        self._inner.merge(keep, drop)

    def shrink(self, budget: int) -> None:
        """Forget the least useful."""
        self._inner.shrink(budget)

    def save(self) -> State:
        """Which memory it is, and all that one learned."""
        members = isinstance(self._inner, DescriptorMemory)
        return {KIND: np.array([members]), **self._inner.save()}

    def load(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Become the memory that was saved; raises StoreError where an array is missing."""
        if KIND not in state:
            raise StoreError(
                f"the memory lacks {KIND}; found {', '.join(state)}; build the map again"
            )
        self._choose(members=bool(state[KIND][0]))
        self._inner.load({name: array for name, array in state.items() if name != KIND})

    def _choose(self, *, members: bool) -> None:
        self._inner = (
            DescriptorMemory(Attributed(self._params))
            if members
            else FingerprintMemory(self._params)
        )
