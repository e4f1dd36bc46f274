"""Vectors of locally aggregated SIFT descriptors, the best candidates checked by epipolar geometry.

H. Jegou, M. Douze, C. Schmid, P. Perez: Aggregating local descriptors into a compact image
representation, CVPR 2010; R. Arandjelovic, A. Zisserman: All about VLAD, CVPR 2013. The vocabulary
is learned on the mapping run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, Params, Pixels
from fpnav.sensing.keypoints import POINT, keypoints, unit
from fpnav.systems.base import Features, State, Verification
from fpnav.systems.images import IMAGE_LATE, ImageParams, ImageSystem, Vector, cosine, image_of
from fpnav.values import FloatArray, Frame, Signature

SAMPLE = 20_000
"""Descriptors of the mapping run that the vocabulary is learned from."""

ROUNDS, SEED = 20, 1
MINIMAL = 8
"""Correspondences a fundamental matrix asks for."""

RANSAC_PX, SURE = 2.0 / 320.0, 0.99
"""Tolerance in widths of the image."""


class VladParams(ImageParams, frozen=True):
    """``words`` of the vocabulary, ``keypoints`` and ``longest_px`` of an image; ``epipolar``
    ranks the candidates that are verified by their inliers."""

    words: Count = 64
    keypoints: Count = 500
    longest_px: Pixels = 512
    epipolar: bool = True
    theta: float = 0.8


class Vlad(ImageSystem):
    """SIFT-VLAD."""

    NAME: ClassVar[str] = "vlad"
    SUMMARY: ClassVar[str] = "SIFT-VLAD with epipolar check (Jegou et al.)"
    PARAMS: ClassVar[type[Params]] = VladParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE | {"words", "epipolar"}
    PRESETS: ClassVar[Mapping[str, Params]] = {"paper": VladParams(), "default": VladParams()}
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"vector": POINT}

    def describe(self, frame: Frame) -> Features:
        """Keypoints of a frame."""
        found = image_of(frame)
        p = self._params
        points = np.zeros(0, POINT) if found is None else keypoints(
            found[0], p.keypoints, p.longest_px
        )  # fmt: skip
        return {"vector": points}

    def fit(self, signatures: Sequence[Signature]) -> State:
        """The vocabulary: k-means of descriptors of the mapping run."""
        rows = [unit(signature.parts["vector"]) for signature in signatures]
        flat = np.concatenate([np.zeros((0, 128), np.float32), *rows])
        flat = flat[:: max(1, -(-len(flat) // SAMPLE))]
        return {"words": k_means(flat, self._params.words)} if len(flat) else {}

    def descriptor(self, signature: Signature, model: State) -> Features:
        """The aggregated vector; none without keypoints."""
        points = signature.parts["vector"]
        if not len(points):
            return {"vector": np.zeros((0, 1), np.float32)}
        words = model.get("words", np.zeros((1, 128), np.float32))
        return {"vector": aggregated(unit(points), words)[None]}

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Cosines."""
        return np.asarray(members @ query, np.float64), np.full(len(members), np.nan)

    def alike(self, first: Vector, second: Vector) -> float:
        """Cosine."""
        return cosine(first, second)

    def drawn(self, vector: NDArray[Any]) -> FloatArray:
        """How many keypoints there are where in the image."""
        limits = ((0.0, 0.75), (0.0, 1.0))
        counts, _, _ = np.histogram2d(vector["y"], vector["x"], bins=(24, 32), range=limits)
        return np.asarray(counts, np.float64)

    def verify(self, query: Signature, candidates: Sequence[Signature]) -> Verification | None:
        """Inliers of the fundamental matrix between the query and each candidate."""
        if not self._params.epipolar:
            return None
        mine = query.parts["vector"]
        counts = [float(inliers(mine, other.parts["vector"])) for other in candidates]
        return Verification(np.array(counts), (None,) * len(candidates))


def k_means(rows: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """At most ``count`` centres (count, D) of rows (N, D), from evenly spaced rows, ties by order.

    Lloyd's iterations; a centre that loses all its rows stays.
    """
    starts = np.unique(np.linspace(0, len(rows) - 1, min(count, len(rows))).astype(np.int64))
    centres = rows[np.random.default_rng(SEED).permutation(len(rows))[: len(starts)]].copy()
    for _ in range(ROUNDS):
        nearest = _nearest(rows, centres)
        sums = np.zeros_like(centres)
        np.add.at(sums, nearest, rows)
        sizes = np.bincount(nearest, minlength=len(centres))[:, None]
        moved = np.where(sizes > 0, sums / np.maximum(sizes, 1), centres).astype(np.float32)
        if np.array_equal(moved, centres):
            break
        centres = moved
    return centres


def aggregated(rows: NDArray[np.float32], words: NDArray[np.float32]) -> Vector:
    """Residuals of descriptors (N, D) to their nearest words, summed, each word's of length 1."""
    nearest = _nearest(rows, words)
    sums = np.zeros_like(words)
    np.add.at(sums, nearest, rows - words[nearest])
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-9)
    flat = sums.ravel()
    return np.asarray(flat / max(float(np.linalg.norm(flat)), 1e-9), np.float32)


def inliers(first: NDArray[Any], second: NDArray[Any]) -> int:
    """Mutually nearest keypoints that one epipolar geometry explains."""
    if min(len(first), len(second)) < MINIMAL:
        return 0
    alike = unit(first) @ unit(second).T
    there, back = alike.argmax(axis=1), alike.argmax(axis=0)
    mine = np.flatnonzero(back[there] == np.arange(len(first)))
    if len(mine) < MINIMAL:
        return 0
    one, other = (
        np.column_stack([side["x"], side["y"]]).astype(np.float64)
        for side in (first[mine], second[there[mine]])
    )
    cv2.setRNGSeed(SEED)
    _, mask = cv2.findFundamentalMat(
        one, other, method=cv2.FM_RANSAC, ransacReprojThreshold=RANSAC_PX, confidence=SURE
    )
    return 0 if mask is None else int(np.count_nonzero(mask))


def _nearest(rows: NDArray[np.float32], centres: NDArray[np.float32]) -> NDArray[np.int64]:
    squares = np.square(centres).sum(axis=1)[None, :] - 2.0 * (rows @ centres.T)
    return np.asarray(squares.argmin(axis=1), np.int64)
