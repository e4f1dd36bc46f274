"""Sequence matching of tiny images.

M. Milford, G. Wyeth: SeqSLAM: visual route-based navigation for sunny summer days and stormy
winter nights, ICRA 2012; parameters of OpenSeqSLAM (N. Suenderhauf et al., 2013). Unlike a filter
it knows no odometry: both runs are taken to go at speeds of a constant ratio near 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from fpnav.matching.ranking import ranked
from fpnav.params import Count, Params, Pixels, Positive, Share
from fpnav.sensing.thumbnails import patch_normalised
from fpnav.systems.base import Recall, Trace
from fpnav.systems.descriptors import DescriptorMemory
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, no_turns, overlap
from fpnav.values import FloatArray, Signature


class SeqParams(ImageParams, frozen=True):
    """``length`` of a sequence, in images; ``window`` of references over which a difference is
    normalised; ``slowest``, ``fastest`` ratio of speeds, tried by ``speed_step``; ``width_px``,
    ``height_px``, ``patch_px`` of the thumbnails."""

    length: Count = 10
    window: Count = 10
    slowest: Positive = 0.8
    fastest: Positive = 1.2
    speed_step: Positive = 0.1
    width_px: Pixels = 64
    height_px: Pixels = 32
    patch_px: Pixels = 8
    theta: Share = 0.5


class SeqSlam(ImageSystem):
    """Differences of tiny images summed along straight lines through the last few queries."""

    NAME: ClassVar[str] = "seqslam"
    SUMMARY: ClassVar[str] = "sequences of patch-normalised thumbnails (Milford, Wyeth)"
    PARAMS: ClassVar[type[Params]] = SeqParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE | {
        "length", "window", "slowest", "fastest", "speed_step",
    }  # fmt: skip
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": SeqParams(), "default": SeqParams()}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """The thumbnail, row by row."""
        p = self._params
        return patch_normalised(pixels, p.width_px, p.height_px, p.patch_px).ravel()

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Mean absolute difference of single images, negative."""
        return no_turns(-np.abs(members - query).mean(axis=1, dtype=np.float64))

    def alike(self, first: Vector, second: Vector) -> float:
        """Difference by what is there to differ."""
        return overlap(first, second)

    def drawn(self, vector: Vector) -> FloatArray:
        """The thumbnail."""
        return np.asarray(vector, np.float64).reshape(self._params.height_px, -1)

    def memory(self) -> SequenceMemory:
        """A new, empty memory."""
        return SequenceMemory(self, self._params)


class SequenceMemory(DescriptorMemory):
    """Descriptors in the order of their places; the trace holds the differences of the last
    queries."""

    def __init__(self, metric: Any, params: SeqParams) -> None:
        super().__init__(metric)
        self._params = params

    def recall(
        self,
        signatures: Sequence[Signature],
        k: int,
        allowed: NDArray[np.bool_] | None,
        trace: Trace,
    ) -> tuple[Recall, Trace]:
        """The k places with the member at which the best sequence ends."""
        places = self.places
        values = np.full((len(signatures), len(places)), -np.inf)
        recent: list[FloatArray] = list(trace or [])
        for q, signature in enumerate(signatures):
            if not len(places):
                continue
            batch, owner = self._packed(places)
            found = self._metric.descriptor(signature, self._model)
            scores, _ = self._metric.compare(found, batch, np.arange(len(owner)), self._model)
            if recent and len(recent[-1]) != len(scores):
                recent = []
            row = locally_normalised(-scores, self._params.window)
            recent = [*recent, row][-self._params.length :]
            np.maximum.at(values[q], owner, -line_means(np.array(recent), self._speeds()))
        columns, scores = ranked(values, k, allowed)
        ids = np.where(columns >= 0, np.append(places, -1)[columns], -1)
        return Recall(ids, scores, np.full(columns.shape, np.nan)), recent

    def _speeds(self) -> FloatArray:
        p = self._params
        count = max(1, round((p.fastest - p.slowest) / p.speed_step) + 1)
        return np.linspace(p.slowest, p.fastest, count)


def locally_normalised(differences: FloatArray, window: int) -> FloatArray:
    """Differences (M,) less the mean of the ``window`` references around each, by their spread."""
    half = window // 2
    rows = np.arange(len(differences))
    first, stop = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(differences))
    sums = np.concatenate([[0.0], np.cumsum(differences)])
    squares = np.concatenate([[0.0], np.cumsum(np.square(differences))])
    count = stop - first
    mean = (sums[stop] - sums[first]) / count
    variance = (squares[stop] - squares[first]) / count - np.square(mean)
    return np.asarray((differences - mean) / np.sqrt(np.maximum(variance, 1e-12)))


def line_means(differences: FloatArray, speeds: FloatArray) -> FloatArray:
    """Least mean difference along a line that ends at each reference, (M,).

    Parameters
    ----------
    differences : (L, M) of the last L queries, the newest last
    speeds : references passed for each query; a line that leaves the run stays at its first
    """
    length, count = differences.shape
    best = np.full(count, np.inf)
    for speed in speeds:
        back = np.rint(speed * np.arange(length - 1, -1, -1)).astype(np.int64)
        columns = np.maximum(np.arange(count)[None, :] - back[:, None], 0)
        best = np.minimum(best, np.take_along_axis(differences, columns, axis=1).mean(axis=0))
    return best
