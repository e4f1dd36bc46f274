"""What the string says of a camera when its symbols carry attributes: one per strip of angle.

Strips are aligned as the paper aligns symbols, under all turns of a panorama, from edge to edge of
a forward view; how alike two are is measured by how alike strips of the mapping run are. Keypoints
of a forward view vote beside them, each by how rare it is in the mapping run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching.banded import banded_scores, shifted_means, strip_distances, turned_sums
from fpnav.matching.cohort import cohort_rows, standard_scores
from fpnav.matching.neighbours import Bundle, background, nearest, votes
from fpnav.sensing import panorama
from fpnav.sensing.keypoints import POINT, keypoints, unit
from fpnav.sensing.strips import KINDS, WIDTH, strips_of
from fpnav.systems.base import Features, State
from fpnav.values import FloatArray, Frame, Image, Signature

AROUND, AHEAD = 90, 32
"""Strips of a full circle and of a forward view."""

BAND = 8
"""Strips by which a strip of a forward view may have moved."""

WEIGHTS_AROUND, WEIGHTS_AHEAD = (1.0, 0.5, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)
"""Of the KINDS of attributes in a panorama and in a forward view; colour was worth less outdoors
(panoramas of bob_route) than indoors (rtabmap_samples)."""

POINTS_WEIGHT, POINTS_SPREAD = 0.5, 1e-3
SHORTLIST = 100
"""Candidates, the best by strips, whose keypoints are looked at."""

SCALE, LARGEST = 31.0, 4.0
FRAMES_BEFORE = 10.0
"""Weight, in frames, of the statistics over all strips in those of one strip."""

BLOCK = 256

STRIP = np.dtype([("bearing_rad", "<f4"), ("values", "i1", (WIDTH,))])
"""A strip: its middle, and its attributes standardised over the run, in steps of 1 / SCALE."""

NO_STRIPS = np.zeros(0, STRIP)
NO_CAMERA: Features = {
    "strips": np.zeros((0, WIDTH), np.float16),
    "strip_bearings": np.zeros(0, np.float32),
    "points": np.zeros(0, POINT),
}

SingleArray = NDArray[np.float32]


def camera_features(frame: Frame) -> Features:
    """Raw strips, their bearings and keypoints of a frame, all empty without a camera."""
    view = _pixels(frame)
    if view is None:
        return NO_CAMERA
    pixels, bearings, circular = view
    return {
        "strips": strips_of(pixels, len(bearings), circular=circular).astype(np.float16),
        "strip_bearings": bearings.astype(np.float32),
        "points": np.zeros(0, POINT) if circular else keypoints(pixels),
    }


def standardised(run: Sequence[Features]) -> list[NDArray[Any]]:
    """Strips of every frame of a run, each attribute in units of its spread over the run.

    What a camera always sees at one place of its image (its mount, a vignette, the tint of the
    light) tells no places apart. A circle has the same statistics all round. Uses the whole run:
    this is batch processing, not what a robot could know on the way.
    """
    filled = [one["strips"] for one in run if len(one["strips"])]
    models = {count: _statistics([row for row in filled if len(row) == count])
              for count in sorted({len(row) for row in filled})}  # fmt: skip
    out = []
    for one in run:
        rows = np.zeros(len(one["strips"]), STRIP)
        if len(rows):
            mean, spread = models[len(rows)]
            values = (one["strips"].astype(np.float32) - mean) / spread
            rows["values"] = np.rint(np.clip(values, -LARGEST, LARGEST) * SCALE)
            rows["bearing_rad"] = one["strip_bearings"]
        out.append(rows)
    return out


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Strips (M, S, WIDTH) int8 of M images; those of another number of strips are ``other``."""

    strips: NDArray[np.int8]
    other: NDArray[np.bool_]
    points: Bundle


class CameraChannel:
    """Strips and keypoints of camera images and their comparison."""

    def __init__(self) -> None:
        self._model: State = {}
        self._cohort: Batch | None = None

    def fit(self, signatures: Sequence[Signature]) -> State:
        """The cohort: a sample of what the mapping run looks like."""
        found = [self.descriptor(signature) for signature in signatures]
        filled = [one for one in found if self.has(one)]
        some = [filled[row] for row in cohort_rows(len(filled))] if filled else []
        if not some:
            return {}
        batch = self.stack(some)
        return {
            "camera_strips": batch.strips,
            "camera_points": np.concatenate([one["points"] for one in some]),
            "camera_offsets": batch.points.offsets,
        }

    def use(self, model: State) -> None:
        """Compare by the cohort of a fitted model."""
        if model is self._model:
            return
        self._model, self._cohort = model, None
        if "camera_strips" in model:
            strips = model["camera_strips"]
            points = Bundle(unit(model["camera_points"]), model["camera_offsets"])
            self._cohort = Batch(strips, np.zeros(len(strips), bool), points)

    def descriptor(self, signature: Signature) -> Features:
        """Strips and keypoints as they are."""
        rows = signature.parts["strips"]
        return {
            "strips": np.ascontiguousarray(rows["values"])[None][: min(len(rows), 1)],
            "strip_rad": _step(rows),
            "points": signature.parts["points"],
        }

    def has(self, descriptor: Features) -> bool:
        """Whether there is an image."""
        return len(descriptor["strips"]) > 0

    def stack(self, descriptors: Sequence[Features]) -> Batch:
        """One batch of those that have an image, in the shape of the first."""
        shape = descriptors[0]["strips"].shape[1:]
        other = np.array([one["strips"].shape[1:] != shape for one in descriptors])
        strips = np.zeros((len(descriptors), *shape), np.int8)
        for row in np.flatnonzero(~other).tolist():
            strips[row] = descriptors[row]["strips"][0]
        return Batch(strips, other, Bundle.of([unit(one["points"]) for one in descriptors]))

    def compare(
        self, query: Features, members: Batch, rows: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        """Scores in units of their spread over the cohort, and turns."""
        scores, turns = np.zeros(len(rows)), np.full(len(rows), np.nan)
        alike = np.flatnonzero(~members.other[rows])
        if query["strips"].shape[1:] != members.strips.shape[1:] or not len(alike):
            return scores, turns
        wanted = rows[alike]
        strips, turns[alike] = self._by_strips(query, members, wanted)
        best = np.argsort(-strips, kind="stable")[:SHORTLIST]
        strips[best] += POINTS_WEIGHT * self._by_points(query, members, wanted[best])
        scores[alike] = strips
        return scores, turns

    def likeness(self, first: Features, second: Features) -> float:
        """Twice the common part over the sum of squares, under the best turn or shift."""
        one, other = (_weighted(side["strips"][0]).astype(np.float64) for side in (first, second))
        if one.shape != other.shape:
            return 0.0
        squares = np.square(one).sum(axis=1)[:, None] + np.square(other).sum(axis=1)[None, :]
        pair = (2.0 * (one @ other.T))[None], squares[None]
        if _circular(one):
            common, whole = (turned_sums(values) for values in pair)
        else:
            common, whole = (shifted_means(values, BAND) for values in pair)
        if not whole.max() > 0.0:
            return 1.0
        return float(np.clip((common / np.maximum(whole, 1e-9)).max(), 0.0, 1.0))

    def _by_strips(
        self, query: Features, members: Batch, rows: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        step = float(query["strip_rad"][0])
        one = _weighted(query["strips"][0])
        cohort = self._cohort
        known = cohort is not None and cohort.strips.shape[1:] == one.shape
        scale = _strip_scale(one, cohort.strips) if known and cohort else None
        scores, shifts = _aligned(one, members.strips, rows, scale)
        if known and cohort:
            others, _ = _aligned(one, cohort.strips, np.arange(len(cohort.strips)), scale)
            scores = standard_scores(scores, others)
        return scores, -shifts * step

    def _by_points(self, query: Features, members: Batch, rows: NDArray[np.int64]) -> FloatArray:
        cohort, one = self._cohort, unit(query["points"])
        if cohort is None or len(cohort.points) < 2 or not len(one):
            return np.zeros(len(rows))
        known = nearest(one, cohort.points)
        limit = background(known)
        found = votes(nearest(one, members.points.of_rows(rows)), limit)
        return standard_scores(found, votes(known, limit), POINTS_SPREAD)


def _aligned(
    query: SingleArray,
    strips: NDArray[np.int8],
    rows: NDArray[np.int64],
    scale: tuple[SingleArray, SingleArray] | None,
) -> tuple[FloatArray, FloatArray]:
    """Score and shift, in strips, of the named rows."""
    scores, shifts = np.zeros(len(rows)), np.zeros(len(rows))
    for start in range(0, len(rows), BLOCK):
        block = slice(start, min(start + BLOCK, len(rows)))
        distances = strip_distances(query, _weighted(strips[rows[block]]))
        if _circular(query):
            sums = -turned_sums(distances)
            scores[block], shifts[block] = sums.max(axis=1), _peak(sums)
            continue
        mean, spread = scale if scale is not None else _own_scale(distances)
        alike = np.asarray((mean - distances) / spread, np.float32)
        scores[block] = banded_scores(alike, BAND)
        shifts[block] = shifted_means(alike, BAND).argmax(axis=1) - BAND
    return scores, shifts


def _strip_scale(
    query: SingleArray, cohort: NDArray[np.int8]
) -> tuple[SingleArray, SingleArray] | None:
    """Mean and spread of each query strip's distance to all strips of the cohort, (S, 1) both."""
    if _circular(query):
        return None
    found = strip_distances(query, _weighted(cohort)).transpose(1, 0, 2).reshape(len(query), -1)
    spread = np.maximum(found.std(axis=1), 1e-3)
    return found.mean(axis=1)[:, None], spread[:, None].astype(np.float32)


def _own_scale(distances: SingleArray) -> tuple[Any, Any]:
    """Without a cohort: a fixed scale, that of standardised attributes that have nothing in common.

    Squared distances of such strips are twice the sum of the weights.
    """
    return np.sqrt(2.0 * len(KINDS)), 0.5


def _peak(sums: FloatArray) -> FloatArray:
    """Turn of the largest of every row, between strips, in strips; (M,) in (-S / 2, S / 2]."""
    count = sums.shape[1]
    rows, best = np.arange(len(sums)), sums.argmax(axis=1)
    before, after = sums[rows, (best - 1) % count], sums[rows, (best + 1) % count]
    bend = before - 2.0 * sums[rows, best] + after
    part = np.where(bend < 0.0, 0.5 * (before - after) / np.where(bend < 0.0, bend, 1.0), 0.0)
    return np.asarray((best + part + count / 2.0) % count - count / 2.0)


def _weighted(values: NDArray[np.int8]) -> SingleArray:
    """Attributes such that a squared distance weighs the kinds of attributes as it should."""
    weights = WEIGHTS_AROUND if _circular(values) else WEIGHTS_AHEAD
    scale = np.empty(WIDTH, np.float32)
    for kind, weight in zip(KINDS, weights, strict=True):
        scale[kind] = np.sqrt(weight / (kind.stop - kind.start)) / SCALE
    return np.asarray(values * scale, np.float32)


def _circular(values: NDArray[Any]) -> bool:
    return bool(values.shape[-2] == AROUND)


def _statistics(rows: Sequence[NDArray[Any]]) -> tuple[SingleArray, SingleArray]:
    """Mean and spread of every attribute, of each strip or (a circle) of all, (S or 1, WIDTH)."""
    stack = np.stack(rows).astype(np.float32)
    pooled, variance = stack.mean(axis=(0, 1))[None], stack.var(axis=(0, 1))[None]
    floor = 1e-4 * float(variance.mean()) + 1e-9
    if stack.shape[1] == AROUND:
        return pooled, np.sqrt(variance + floor)
    share = len(rows) / (len(rows) + FRAMES_BEFORE)
    mean = share * stack.mean(axis=0) + (1.0 - share) * pooled
    spread = share * stack.var(axis=0) + (1.0 - share) * variance
    return mean, np.sqrt(spread + floor)


def _step(strips: NDArray[Any]) -> FloatArray:
    """Angle of one strip, (1,), or nothing."""
    if len(strips) < 2:
        return np.zeros(0)
    first, second = strips["bearing_rad"][:2].astype(np.float64)
    return np.array([(first - second) % TAU])


def _pixels(frame: Frame) -> tuple[NDArray[np.uint8], FloatArray, bool] | None:
    """Pixels, bearings of the strips' middles and whether they go all round."""
    if frame.panorama is not None:
        return _around(panorama.from_panorama(frame.panorama))
    if frame.omni is not None:
        return _around(panorama.from_omni(frame.omni))
    return None if frame.camera is None else _ahead(frame.camera)


def _around(view: panorama.View) -> tuple[NDArray[np.uint8], FloatArray, bool]:
    middles = (np.arange(AROUND) + 0.5) * len(view.bearings_rad) / AROUND - 0.5
    return view.pixels, view.bearing_at(middles), True


def _ahead(image: Image) -> tuple[NDArray[np.uint8], FloatArray, bool]:
    fov = panorama.horizontal_fov(image)
    middles = (0.5 - (np.arange(AHEAD) + 0.5) / AHEAD) * fov
    return image.pixels, middles + panorama.mount_heading(image), False
