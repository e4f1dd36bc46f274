"""Short-term memory of the merging neurons (systems.md 2.1): what was seen lasts a while."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Merging activity ``m`` (M,) and the explorations ``q`` (M,) each is still protected for."""

    m: FloatArray
    q: NDArray[np.int64]

    def grown(self, neurons: int, qmax: int) -> Held:
        """With neurons recruited since: fully active and protected."""
        new = neurons - len(self.m)
        return Held(
            np.concatenate([self.m, np.ones(new)]),
            np.concatenate([self.q, np.full(new, max(qmax, 1), np.int64)]),
        )


def nothing(neurons: int) -> Held:
    """The memory before anything was seen."""
    return Held(np.zeros(neurons), np.zeros(neurons, np.int64))


def explore(held: Held, seen: FloatArray, *, fires: bool, qmax: int, literal: bool = False) -> Held:
    """One exploration.

    A neuron whose value rises is protected for ``qmax`` signals T, then forgotten. ``qmax`` 0 is
    the plain reset, the same as 1.

    Parameters
    ----------
    seen : (M,) product of landmark, azimuth and elevation activity
    fires : T, the first exploration of a new panorama (of a new image where images stream)
    literal : the rise is judged against the value before the reset, as the paper writes it; a
        weaker value that arrives in the very step of a reset is then lost one step later
    """
    left = np.maximum(held.q - int(fires), 0)
    kept = np.where(left < 1, 0.0, held.m)
    m = np.maximum(seen, kept)
    rises = m > (held.m if literal else kept)
    return Held(m, np.maximum(left, max(qmax, 1) * rises))


def largest(panoramas: Sequence[FloatArray], neurons: int) -> FloatArray:
    """The clean variant: the largest value of the given panoramas, (M,); older ones are shorter."""
    m = np.zeros(neurons)
    for seen in panoramas:
        m[: len(seen)] = np.maximum(m[: len(seen)], seen)
    return m
