"""What the string says of a laser scan when its symbols carry attributes.

Corners with the logarithm of their range and empty space with its depth every few degrees, aligned
by angle over a grid of turns; beside the string, what it is made of in other words: hits by bearing
and range, and pairs of corners by direction and distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching import grids
from fpnav.matching.attributed import SYMBOL, Strings, Tolerance, ratios
from fpnav.matching.sweeps import Sweep
from fpnav.sensing.polar import covered, pair_histogram, polar_grid
from fpnav.systems.base import Features
from fpnav.systems.fingerprint.record import LASER_ARC, arcs_of
from fpnav.values import FloatArray, Signature

CORNER, EMPTY = 0, 1
STEP_RAD = np.deg2rad(10.0)
DEEPEST_M, NEAREST_M = 30.0, 0.1
EMPTY_WEIGHT = 0.6
TOLERANCE = Tolerance(np.deg2rad(15.0), (0.35, 0.5), 0.5)

POLAR_BINS, POLAR_RINGS = 90, 16
PAIR_BINS, PAIR_STEPS, PAIR_M = 30, 30, 10.0
TURN_MOST_RAD, TURN_STEP_RAD = np.deg2rad(60.0), np.deg2rad(6.0)

SCALES = (0.16, 0.13, 0.12)
"""Spread of string ratio, polar cosine and pair cosine over the candidates of a query, median of
intel and freiburg-079; the score is their sum in these units."""


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Laser descriptors of R signatures."""

    strings: Strings
    polar: NDArray[np.int32]
    covers: NDArray[np.bool_]
    pairs: NDArray[np.int32]


def sweep_of(rays: NDArray[Any]) -> Sweep:
    """The rays kept of a scan, in the sensor's frame, the robot's heading ahead."""
    bearings = rays["bearing_rad"].astype(np.float64)
    step = (bearings[-1] - bearings[0]) / (len(rays) - 1) if len(rays) > 1 else 1.0
    return Sweep(rays["range_m"].astype(np.float64), float(bearings[0]) if len(rays) else 0.0, step)


def mount_of(signature: Signature) -> FloatArray:
    """Where the laser stands on the robot, metres, (2,)."""
    return np.array([float(signature.record[name]) for name in ("laser_x_m", "laser_y_m")])


class LaserChannel:
    """Descriptors of laser scans and their comparison; a signature without rays has none."""

    def descriptor(self, signature: Signature) -> Features:
        """Symbols, arc, polar grid and pair histogram, each empty without rays."""
        if not len(signature.parts["rays"]):
            return _nothing()
        corners = corners_of(signature.parts["features"], mount_of(signature))
        sweep = sweep_of(signature.parts["rays"])
        points = np.column_stack([axis[sweep.hits] for axis in sweep.points])
        arc = arcs_of(signature)[LASER_ARC]
        polar = polar_grid(points, POLAR_BINS, POLAR_RINGS)
        pairs = pair_histogram(corners[:, :2], PAIR_BINS, PAIR_STEPS, PAIR_M)
        return {
            "laser_symbols": signature.parts["attributes"],
            "laser_arc": arc[None, :],
            "laser_polar": grids.quantised(polar).astype(np.uint8)[None],
            "laser_pairs": grids.quantised(pairs).astype(np.uint8)[None],
        }

    def has(self, descriptor: Features) -> bool:
        """Whether there is something to compare."""
        return len(descriptor["laser_arc"]) > 0

    def stack(self, descriptors: Sequence[Features]) -> Batch:
        """One batch of those that have rays."""
        arcs = np.concatenate([one["laser_arc"] for one in descriptors])
        polar = np.concatenate([one["laser_polar"] for one in descriptors]).astype(np.int32)
        pairs = np.concatenate([one["laser_pairs"] for one in descriptors]).astype(np.int32)
        return Batch(
            Strings.of([one["laser_symbols"] for one in descriptors], list(arcs)),
            polar,
            np.array([covered(arc[0], arc[1], POLAR_BINS) for arc in arcs.tolist()]),
            pairs,
        )

    def compare(
        self, query: Features, members: Batch, rows: NDArray[np.int64]
    ) -> tuple[FloatArray, FloatArray]:
        """Sum of three likenesses in units of their spread; the turn is the string's."""
        one = self.stack([query])
        closed = _closed(one.strings.arcs[0]) and len(rows) > 0
        closed = closed and all(_closed(members.strings.arcs[row]) for row in rows.tolist())
        string, turns = ratios(one.strings, members.strings, rows, turn_grid(closed), TOLERANCE)
        polar, _ = grids.cosines(
            one.polar[0], one.covers[0], members.polar, members.covers, rows,
            _shifts(closed, POLAR_BINS),
        )  # fmt: skip
        everywhere = np.ones((len(members.pairs), PAIR_BINS), bool)
        pairs, _ = grids.cosines(
            one.pairs[0], np.ones(PAIR_BINS, bool), members.pairs, everywhere, rows,
            _shifts(closed, PAIR_BINS),
        )  # fmt: skip
        parts = zip((string, polar, pairs), SCALES, strict=True)
        return sum((part / scale for part, scale in parts), np.zeros(len(rows))), turns

    def likeness(self, first: Features, second: Features) -> float:
        """Ratio of the two strings, in [0, 1]; the mean of both ways, as each way cuts full circles
        behind another robot."""
        one, other = (self.stack([side]).strings for side in (first, second))
        grid = turn_grid(_closed(one.arcs[0]) and _closed(other.arcs[0]))
        row = np.zeros(1, np.int64)
        there, back = (
            ratios(*way, row, grid, TOLERANCE)[0][0] for way in ((one, other), (other, one))
        )
        return float(np.clip(0.5 * (there + back), 0.0, 1.0))


def turn_grid(closed: bool) -> FloatArray:
    """Turns to try: all round for full circles, else as far as views overlap well."""
    if closed:
        around = np.arange(round(TAU / TURN_STEP_RAD)) * TURN_STEP_RAD
        return np.asarray((around + np.pi) % TAU - np.pi, np.float64)
    most = round(TURN_MOST_RAD / TURN_STEP_RAD)
    return np.asarray(np.arange(-most, most + 1) * TURN_STEP_RAD, np.float64)


def _closed(arc: FloatArray) -> bool:
    return bool(arc[1] > TAU - 0.05)


def _shifts(closed: bool, bins: int) -> NDArray[np.int64]:
    most = int(TURN_MOST_RAD / TAU * bins)
    return np.arange(bins) if closed else np.arange(-most, most + 1)


def corners_of(features: NDArray[Any], mount_m: FloatArray) -> FloatArray:
    """Corners about the laser and their certainty, rows x, y, certainty."""
    rows = features[(features["type"] == b"c") & np.isfinite(features["range_m"])]
    angles, ranges = rows["angle_rad"], rows["range_m"].astype(np.float64)
    x, y = ranges * np.cos(angles) - mount_m[0], ranges * np.sin(angles) - mount_m[1]
    return np.column_stack([x, y, rows["certainty"].astype(np.float64)])


def attributes_of(
    features: NDArray[Any], rays: NDArray[Any], mount_m: FloatArray, arc: FloatArray
) -> NDArray[np.void]:
    """Corners and empty space about the laser as symbols with range, by bearing."""
    if not len(rays):
        return np.zeros(0, SYMBOL)
    corners = corners_of(features, mount_m)
    rows = np.zeros(len(corners), SYMBOL)
    rows["angle_rad"] = np.arctan2(corners[:, 1], corners[:, 0])
    ranges = np.hypot(corners[:, 0], corners[:, 1])
    rows["log_range"] = np.log(np.maximum(ranges, NEAREST_M))
    rows["weight"], rows["kind"] = corners[:, 2], CORNER
    both = np.concatenate([rows, _depths(sweep_of(rays), arc)])
    return np.asarray(both[np.lexsort((both["kind"], both["angle_rad"]))])


def _depths(sweep: Sweep, arc: FloatArray) -> NDArray[np.void]:
    """One symbol every STEP_RAD of the arc: the median range there."""
    count = max(1, round(float(arc[1]) / STEP_RAD))
    first = float(arc[0]) - float(arc[1]) / 2.0
    bearings = sweep.start_rad + sweep.step_rad * np.arange(len(sweep.ranges_m))
    share = (bearings - first + 1e-6) % TAU / float(arc[1])
    where = np.minimum((share * count).astype(int), count - 1)
    known = sweep.ranges_m > 0.0
    rows = np.zeros(count, SYMBOL)
    middle = first + (np.arange(count) + 0.5) * float(arc[1]) / count
    rows["angle_rad"] = (middle + np.pi) % TAU - np.pi
    rows["kind"], rows["weight"] = EMPTY, EMPTY_WEIGHT
    depth = np.clip(sweep.ranges_m, NEAREST_M, DEEPEST_M)
    for k in range(count):
        inside = depth[(where == k) & known]
        rows["log_range"][k] = np.log(np.median(inside)) if len(inside) else 0.0
        rows["weight"][k] *= len(inside) > 0
    return rows


def _nothing() -> Features:
    return {
        "laser_symbols": np.zeros(0, SYMBOL),
        "laser_arc": np.zeros((0, 2)),
        "laser_polar": np.zeros((0, POLAR_BINS, POLAR_RINGS), np.uint8),
        "laser_pairs": np.zeros((0, PAIR_BINS, PAIR_STEPS), np.uint8),
    }
