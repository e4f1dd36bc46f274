"""Standard parts of systems that know a place by one descriptor made of one laser scan.

What differs between them is the descriptor, how two are compared and whether scans are laid over
each other afterwards; such a system states these and cites where they were published.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching.grids import cosines, quantised
from fpnav.matching.sweeps import Sweep
from fpnav.params import Count, NotNegative, Params, Positive, Share
from fpnav.sensing.corners import corners, sensed_arc
from fpnav.sensing.polar import covered
from fpnav.sensing.rays import RAY, rays_of
from fpnav.systems.base import Features, Needs, Picture, State
from fpnav.systems.descriptors import DescriptorSystem
from fpnav.values import FloatArray, Frame, Reference, Signature

CLOSED_RAD = 0.05
"""A scan that leaves out no more goes all round."""

CORNER = np.dtype([("x_m", "<f4"), ("y_m", "<f4")])
"""A corner about the laser, the robot's heading ahead."""

RECORD = np.dtype(
    [
        ("laser_centre_rad", "<f8"),
        ("laser_width_rad", "<f8"),
        ("laser_x_m", "<f8"),
        ("laser_y_m", "<f8"),
    ]
)
"""What the laser covered around the robot (width 0 = missing) and where it stands on it."""


class LaserParams(Params, frozen=True):
    """Parameters common to systems of one descriptor a scan.

    ``ray_deg`` between the rays kept of a scan; ``turn_deg`` farthest turn between two open views
    that is tried, full circles are turned all round. ``theta`` largest unlikeness within a place;
    ``min_node_obs``; ``step_m`` and ``step_heading_deg`` least travel between two scans that are
    used, 0 = every one.
    """

    ray_deg: Positive = 1.0
    turn_deg: NotNegative = 60.0
    theta: Share = 0.4
    min_node_obs: Count = 2
    step_m: NotNegative = 0.0
    step_heading_deg: NotNegative = 0.0


LASER_LATE = frozenset({"turn_deg", "theta", "min_node_obs", "step_m", "step_heading_deg"})
"""Those of them that act on signatures, not in making them."""


class Grids(NamedTuple):
    """Grids of M members as whole numbers (M, bins, depth), the bearing bins they cover
    (M, bins), whether the scan went all round and whether there was one, (M,) both."""

    values: NDArray[np.int32]
    covers: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    seen: NDArray[np.bool_]


class LaserSystem(DescriptorSystem):
    """A system of one grid over bearing a scan, but for what the grid is.

    It is its own metric for the memory of descriptors.
    """

    NAME: ClassVar[str]
    SUMMARY: ClassVar[str]
    NEEDS: ClassVar[Needs] = Needs(("scan",), (("scan",),))
    PARAMS: ClassVar[type[Params]] = LaserParams
    LATE: ClassVar[frozenset[str]] = LASER_LATE
    PRESETS: ClassVar[Mapping[str, Params]]
    RECORD: ClassVar[np.dtype[Any]] = RECORD
    PARTS: ClassVar[Mapping[str, np.dtype[Any]]] = {"rays": RAY, "corners": CORNER}

    def grid(self, signature: Signature) -> FloatArray:
        """The descriptor of a scan, (bins, depth), not negative."""
        raise NotImplementedError

    def cover(self, signature: Signature, bins: int) -> NDArray[np.bool_]:
        """Bins that the scan could fill, (bins,)."""
        centre, width = (float(signature.record[name]) for name in (RECORD.names or ())[:2])
        return covered(centre, width, bins)

    def describe(self, frame: Frame) -> Features:
        """Rays, corners and what the scan covered; all empty without one."""
        scan = frame.scan
        if scan is None:
            return {
                "rays": np.zeros(0, RAY), "corners": np.zeros(0, CORNER), "record": np.zeros(4),
            }  # fmt: skip
        found = corners(scan)
        rows = np.zeros(len(found.ranges_m), CORNER)
        rows["x_m"] = found.ranges_m * np.cos(found.bearings_rad) - scan.mount.x_m
        rows["y_m"] = found.ranges_m * np.sin(found.bearings_rad) - scan.mount.y_m
        record = np.array([*sensed_arc(scan), scan.mount.x_m, scan.mount.y_m])
        rays = rays_of(scan, float(np.deg2rad(self._params.ray_deg)))
        return {"rays": rays, "corners": rows, "record": record}

    def assemble(self, stream: Iterable[tuple[Reference, Features]]) -> Iterator[Signature]:
        """One signature a frame."""
        for reference, found in stream:
            record: np.void = np.array([tuple(found["record"])], RECORD)[0]
            parts = {"rays": found["rays"], "corners": found["corners"]}
            yield Signature(reference, record, parts)

    def picture(self, signature: Signature) -> Picture:
        """The scan's points about the laser."""
        sweep = sweep_of(signature.parts["rays"])
        points = np.column_stack([axis[sweep.hits] for axis in sweep.points])
        return Picture("scan", np.zeros(0), np.zeros(0), values=points)

    def descriptor(self, signature: Signature, model: State) -> Features:
        """The grid and its cover; no rows without a scan."""
        grid = quantised(self.grid(signature)).astype(np.uint8)
        cover = self.cover(signature, len(grid))
        there = int(len(signature.parts["rays"]) > 0)
        closed = np.array([signature.record["laser_width_rad"] > TAU - CLOSED_RAD])
        return {"grid": grid[None][:there], "cover": cover[None][:there], "closed": closed}

    def stack(self, descriptors: Sequence[Features]) -> Grids:
        """Grids as rows, zeros where there was no scan."""
        shape = descriptors[0]["grid"].shape[1:]
        seen = np.array([len(one["grid"]) > 0 for one in descriptors])
        values = np.zeros((len(seen), *shape), np.int32)
        covers = np.zeros((len(seen), shape[0]), bool)
        for at in np.flatnonzero(seen).tolist():
            values[at], covers[at] = descriptors[at]["grid"][0], descriptors[at]["cover"][0]
        closed = np.concatenate([one["closed"] for one in descriptors])
        return Grids(values, covers, closed, seen)

    def compare(
        self, query: Features, members: Grids, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        """Cosine under the best turn, and that turn; 0 where there is no scan."""
        if not len(query["grid"]):
            return np.zeros(len(rows)), np.full(len(rows), np.nan)
        grid, cover = query["grid"][0].astype(np.int32), query["cover"][0]
        closed = bool(query["closed"][0] and members.closed[rows].all())
        shifts = self._shifts(len(cover), closed=closed)
        scores, found = cosines(grid, cover, members.values, members.covers, rows, shifts)
        turns = found * (TAU / len(cover))
        turns = (turns + np.pi) % TAU - np.pi
        return scores, np.where(members.seen[rows], turns, np.nan)

    def _shifts(self, bins: int, *, closed: bool) -> NDArray[np.int64]:
        """Turns that are tried, in bins."""
        most = int(np.deg2rad(self._params.turn_deg) / TAU * bins)
        return np.arange(bins) if closed else np.arange(-most, most + 1)

    def likeness(self, first: Features, second: Features, model: State) -> float:
        """Cosine under the best turn; two frames without a scan are alike."""
        if len(first["grid"]) != len(second["grid"]):
            return 0.0
        if not len(first["grid"]) or np.array_equal(first["grid"], second["grid"]):
            return 1.0
        members, row = self.stack([second]), np.zeros(1, np.int64)
        return float(np.clip(self.compare(first, members, row, model)[0][0], 0.0, 1.0))


def sweep_of(rays: NDArray[Any]) -> Sweep:
    """Rays as a sweep about the laser, the robot's heading ahead."""
    bearings = rays["bearing_rad"].astype(np.float64)
    step = (bearings[-1] - bearings[0]) / (len(rays) - 1) if len(rays) > 1 else 1.0
    return Sweep(rays["range_m"].astype(np.float64), float(bearings[0]) if len(rays) else 0.0, step)


def mount_of(signature: Signature) -> FloatArray:
    """Where the laser stands on the robot, metres, (2,)."""
    return np.array([float(signature.record[name]) for name in ("laser_x_m", "laser_y_m")])


def corner_points(signature: Signature) -> FloatArray:
    """Corners about the laser, (C, 2)."""
    rows = signature.parts["corners"]
    return np.column_stack([rows["x_m"], rows["y_m"]]).astype(np.float64)
