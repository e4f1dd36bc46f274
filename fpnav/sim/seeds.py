"""Random numbers of the simulator: every stream is named, none depends on who draws first."""

from __future__ import annotations

import zlib

import numpy as np


def generator(*keys: int | str) -> np.random.Generator:
    """Generator of the stream named by ``keys``: equal keys, equal numbers, on any process."""
    words = [zlib.crc32(key.encode()) if isinstance(key, str) else key for key in keys]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words)))
