"""Standard parts of systems that know a place by one vector made of one camera image.

What differs between them is the vector and how two are compared; such a system states both and
cites where they were published.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Count, NotNegative, Params, Share
from fpnav.sensing import panorama
from fpnav.systems.base import Features, Needs, Picture, State
from fpnav.systems.descriptors import DescriptorSystem
from fpnav.values import FloatArray, Frame, Reference, Signature

CAMERA_ROLES = ("panorama", "omni", "camera")
VECTOR = np.dtype("<f4")
RECORD = np.dtype([("images", "<i4")])
"""Whether there was an image."""

Vector = NDArray[np.float32]


class ImageParams(Params, frozen=True):
    """Parameters common to systems of one vector an image.

    ``theta`` largest unlikeness within a place; ``min_node_obs``; ``step_m`` and
    ``step_heading_deg`` least travel between two images that are used, 0 = every one.
    """

    theta: Share = 0.4
    min_node_obs: Count = 2
    step_m: NotNegative = 0.0
    step_heading_deg: NotNegative = 0.0


IMAGE_LATE = frozenset({"theta", "min_node_obs", "step_m", "step_heading_deg"})
"""Those of them that act on signatures, not in making them."""


class Stack(NamedTuple):
    """Vectors of M members, zeros where there was no image: (M, D), and where there was, (M,)."""

    values: Vector
    seen: NDArray[np.bool_]


class ImageSystem(DescriptorSystem):
    """A system of one vector an image, but for what the vector is and how two are compared.

    It is its own metric for the memory of descriptors.
    """

    NAME: ClassVar[str]
    SUMMARY: ClassVar[str]
    NEEDS: ClassVar[Needs] = Needs(CAMERA_ROLES, (CAMERA_ROLES,))
    PARAMS: ClassVar[type[Params]] = ImageParams
    LATE: ClassVar[frozenset[str]] = IMAGE_LATE
    PRESETS: ClassVar[Mapping[str, Params]]
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"vector": VECTOR}

    def vector(self, pixels: NDArray[np.uint8], *, circular: bool) -> Vector:
        """The vector of an image (H, W, 3) uint8 BGR, (D,); ``circular`` for panoramas."""
        raise NotImplementedError

    def scores(self, query: Vector, members: Vector) -> tuple[FloatArray, FloatArray]:
        """Scores of members (n, D), growing with likeness, and turns, NaN where none; (n,) both."""
        raise NotImplementedError

    def alike(self, first: Vector, second: Vector) -> float:
        """How alike two vectors are: 1 for equal ones, symmetric; values below 0 count as 0."""
        raise NotImplementedError

    def drawn(self, vector: Vector) -> FloatArray:
        """What to draw of a vector, (rows, columns)."""
        return np.asarray(vector[None, :], np.float64)

    def describe(self, frame: Frame) -> Features:
        """The vector of a frame; empty without an image."""
        found = image_of(frame)
        if found is None:
            return {"vector": np.zeros(0, VECTOR)}
        pixels, circular = found
        return {"vector": np.asarray(self.vector(pixels, circular=circular), VECTOR)}

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """One signature a frame."""
        for reference, found in stream:
            record: np.void = np.array([(int(len(found["vector"]) > 0),)], RECORD)[0]
            yield Signature(reference, record, {"vector": found["vector"]})

    def picture(self, signature: Signature) -> Picture:
        """The vector as a grid."""
        vector = signature.parts["vector"]
        values = self.drawn(vector) if len(vector) else np.zeros((1, 1))
        return Picture("grid", np.zeros(0), np.zeros(0), values=values)

    def descriptor(self, signature: Signature, model: State) -> Features:
        """The vector as one row, none without an image."""
        vector = signature.parts["vector"]
        return {"vector": vector[None, :] if len(vector) else np.zeros((0, 1), VECTOR)}

    def stack(self, descriptors: Sequence[Features]) -> Stack:
        """Vectors as rows; those of another length than the first cannot be compared."""
        rows = [one["vector"] for one in descriptors]
        size = next((row.shape[1] for row in rows if len(row)), 1)
        seen = np.array([row.shape == (1, size) for row in rows])
        values = np.zeros((len(rows), size), VECTOR)
        for at in np.flatnonzero(seen).tolist():
            values[at] = rows[at][0]
        return Stack(values, seen)

    def compare(
        self, query: Features, members: Stack, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        """Scores and turns of the named rows; the least score where there is no image."""
        scores, turns = np.zeros(len(rows)), np.full(len(rows), np.nan)
        both = np.flatnonzero(members.seen[rows])
        if not len(both) or query["vector"].shape != (1, members.values.shape[1]):
            return scores, turns
        scores[both], turns[both] = self.scores(query["vector"][0], members.values[rows[both]])
        scores[~members.seen[rows]] = scores[both].min()
        return scores, turns

    def likeness(self, first: Features, second: Features, model: State) -> float:
        """In [0, 1]; two frames without an image are alike."""
        one, other = first["vector"], second["vector"]
        if one.shape != other.shape:
            return 0.0
        return float(np.clip(self.alike(one[0], other[0]), 0.0, 1.0)) if len(one) else 1.0


def image_of(frame: Frame) -> tuple[NDArray[np.uint8], bool] | None:
    """Pixels of a frame's image as they were recorded (a catadioptric one unwrapped), and whether
    they go all round."""
    if frame.panorama is not None:
        return frame.panorama.pixels, True
    if frame.omni is not None:
        return panorama.unwrap(frame.omni.pixels, panorama.omni_calibration(frame.omni)), True
    return None if frame.camera is None else (frame.camera.pixels, False)


def no_turns(scores: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scores without turns."""
    return np.asarray(scores, np.float64), np.full(len(scores), np.nan)


def overlap(first: Vector, second: Vector) -> float:
    """1 - sum |a - b| / sum (|a| + |b|) (Bray, Curtis 1957); 1 where both are nothing."""
    total = float(np.abs(first).sum() + np.abs(second).sum())
    return 1.0 - float(np.abs(first - second).sum()) / total if total > 0.0 else 1.0


def cosine(first: Vector, second: Vector) -> float:
    """Cosine of two vectors; 1 where they are equal, 0 with nothing."""
    one, other = first.astype(np.float64), second.astype(np.float64)
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if np.array_equal(one, other):
        return 1.0
    return float(one @ other) / size if size > 0.0 else 0.0
