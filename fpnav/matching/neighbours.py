"""Votes of local descriptors for images, each worth what sets it apart from a background."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.values import FloatArray

SingleArray = NDArray[np.float32]
FAR = 4.0
"""Squared distance of opposite unit vectors, the largest there is."""

BACKGROUND = 0.12
"""Share of background images that may hold something as near as the background distance."""

FEWEST = 30
"""Descriptors an image is treated as having at least, so that two of them prove little."""


@dataclass(frozen=True, slots=True, eq=False)
class Bundle:
    """Unit descriptors of M images laid end to end: ``flat`` (N, D), ``offsets`` (M + 1,)."""

    flat: SingleArray
    offsets: NDArray[np.int64]

    @staticmethod
    def of(rows: Sequence[SingleArray]) -> Bundle:
        """Bundle of the descriptors of some images, at least one."""
        lengths = [len(row) for row in rows]
        return Bundle(np.concatenate(rows), np.concatenate([[0], np.cumsum(lengths)]))

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def of_rows(self, rows: NDArray[np.int64]) -> Bundle:
        """Bundle of some of the images."""
        return Bundle.of([self.flat[self.offsets[r] : self.offsets[r + 1]] for r in rows.tolist()])


def nearest(query: SingleArray, images: Bundle) -> SingleArray:
    """Squared distance of each query descriptor to its nearest in each image, (Q, M)."""
    out = np.full((len(query), len(images)), FAR, np.float32)
    filled = np.flatnonzero(np.diff(images.offsets) > 0)
    if len(query) and len(filled):
        distances = 2.0 - 2.0 * (query @ images.flat.T)
        out[:, filled] = np.minimum.reduceat(distances, images.offsets[filled], axis=1)
    return out


def background(distances: SingleArray) -> SingleArray:
    """How near a descriptor finds something in images of other places, (Q, 1).

    ``distances`` : (Q, M) to the images of the background.
    """
    count = distances.shape[1]
    rank = min(max(1, round(BACKGROUND * count)), count - 1)
    return np.asarray(np.partition(distances, rank, axis=1)[:, rank : rank + 1])


def votes(distances: SingleArray, limit: SingleArray) -> FloatArray:
    """Mean gain of the query's descriptors over the background, for each image, (M,).

    Local naive Bayes nearest neighbour (McCann, Lowe 2012), the background being images of the
    mapping run and not the next neighbour, so that no image's votes depend on another's.
    """
    gains = np.maximum(limit - distances, 0.0).sum(axis=0)
    return np.asarray(gains / max(len(distances), FEWEST), np.float64)
