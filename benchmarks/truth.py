"""Truth for recordings that came without: poses beside the raw odometry, in new CARMEN logs.

``python -m benchmarks.truth -o DIR`` writes, from FPNAV_DATA, ``wean1.log`` and ``wean3.log``
(scans laid on the building's occupancy map: found by correlation over the whole map, then followed
scan by scan) and ``intel_raw.log`` (scans that are the very ones of the corrected log are anchors;
between two of them raw odometry is bent to fit). Lines are those of the recordings, TRUEPOS added.
"""

from __future__ import annotations

import argparse
import gzip
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap, wrap_array
from fpnav.logs.carmen_lines import parse
from fpnav.values import FloatArray

CELL_M = 0.1
OCCUPIED = 0.4
BLUR_M = 0.25
NO_RETURN_M = 80.0
FIRST_SCANS, HYPOTHESES, TURNS = 120, 12, 180
GATE_M, STEPS = 0.6, 12
TRUSTED_M, TRUSTED = 0.25, 0.6
"""A hit explained by the map is so near a wall; a pose is truth where such a share of hits is."""

SAME_M = 0.006
"""Two scans that differ by no more in any beam are one scan."""


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """Scans of a CARMEN log: raw ``lines``, the ``line_of`` each scan, its ``ranges`` (S, B), its
    robot's ``poses`` (S, 3) as logged, and ``mount_m`` of the laser ahead of the robot."""

    lines: list[str]
    line_of: list[int]
    ranges: FloatArray
    poses: FloatArray
    mount_m: float

    @staticmethod
    def read(path: Path) -> Log:
        """All FLASER lines of a file, plain or gzip."""
        opened = gzip.open if path.suffix == ".gz" else open
        with opened(path, "rt", encoding="ascii") as file:
            lines = file.read().splitlines()
        numbers = [k for k, text in enumerate(lines) if text.startswith("FLASER")]
        found = [parse(lines[k]) for k in numbers]
        poses = np.array([(p.x_m, p.y_m, p.heading_rad) for p in (one.robot for one in found)])
        ranges = [one.scan.ranges_m.astype(float) for one in found if one.scan is not None]
        first = found[0]
        ahead = np.hypot(first.laser.x_m - first.robot.x_m, first.laser.y_m - first.robot.y_m)
        return Log(lines, numbers, np.array(ranges), poses, float(ahead))

    def hits(self, scan: int) -> FloatArray:
        """Hits about the robot, (n, 2), metres."""
        ranges = self.ranges[scan]
        bearings = -np.pi / 2 + np.pi / len(ranges) * np.arange(len(ranges))
        kept = np.isfinite(ranges) & (ranges < NO_RETURN_M)
        x = self.mount_m + ranges[kept] * np.cos(bearings[kept])
        return np.column_stack([x, ranges[kept] * np.sin(bearings[kept])])

    def write(self, path: Path, truth: FloatArray) -> None:
        """The log with a TRUEPOS line before each scan whose pose is known."""
        added = dict(zip(self.line_of, truth, strict=True))
        with path.open("w", encoding="ascii") as file:
            for number, text in enumerate(self.lines):
                pose = added.get(number)
                if pose is not None and np.isfinite(pose).all():
                    stamps = " ".join(text.split()[-3:])
                    file.write("TRUEPOS {:.4f} {:.4f} {:.6f} 0 0 0 {}\n".format(*pose, stamps))
                file.write(text + "\n")


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """Distance to the nearest wall of an occupancy map and its slopes, x along the first axis."""

    distance: FloatArray
    slope_x: FloatArray
    slope_y: FloatArray
    free: NDArray[np.bool_]

    @staticmethod
    def read(path: Path) -> Walls:
        """A map of the Beesoft form; cells hold how surely they are free, -1 = not seen."""
        with gzip.open(path, "rt", encoding="ascii") as file:
            text = file.read().split("global_map[0]:")[1].split()
        rows, columns = int(text[0]), int(text[1])
        cells = np.array(text[2:], dtype=float).reshape(rows, columns)
        wall = (cells >= 0.0) & (cells < OCCUPIED)
        distance = cv2.distanceTransform(
            np.where(wall, 0, 255).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
        ).astype(float)
        slopes = np.gradient(cv2.GaussianBlur(distance, (3, 3), 0))
        return Walls(distance * CELL_M, slopes[0], slopes[1], cells > 1.0 - OCCUPIED)

    def at(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Distance and slopes at points (n, 2); far away outside the map."""
        cells = np.floor(points / CELL_M).astype(int)
        inside = ((cells >= 0) & (cells < self.distance.shape)).all(axis=1)
        i, j = np.where(inside[:, None], cells, 0).T
        far = np.where(inside, self.distance[i, j], 10.0)
        return far, self.slope_x[i, j], self.slope_y[i, j]


def moved(points: FloatArray, pose: FloatArray) -> FloatArray:
    """Points of a robot's frame in that of its pose."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + pose[:2])


def composed(first: FloatArray, second: FloatArray) -> FloatArray:
    """A pose given in another's frame, in that other's world."""
    x, y = moved(second[None, :2], first)[0]
    return np.array([x, y, wrap(float(first[2] + second[2]))])


def between(first: FloatArray, second: FloatArray) -> FloatArray:
    """The second pose as seen from the first."""
    c, s = np.cos(first[2]), np.sin(first[2])
    x, y = second[:2] - first[:2]
    return np.array([c * x + s * y, -s * x + c * y, wrap(float(second[2] - first[2]))])


def fitted(walls: Walls, hits: FloatArray, guess: FloatArray) -> FloatArray:
    """The pose near a guess whose hits lie on walls: Gauss-Newton on the distance, held to the
    guess where the walls say nothing, as along a corridor."""
    pose = guess.copy()
    for _ in range(STEPS):
        points = moved(hits, pose)
        off, gx, gy = walls.at(points)
        near = off < GATE_M
        if near.sum() < 20:
            return pose
        arm = points[near] - pose[:2]
        j = np.column_stack([gx, gy, np.zeros(len(gx))])[near]
        j[:, 2] = arm[:, 0] * j[:, 1] - arm[:, 1] * j[:, 0]
        w = 1.0 / (1.0 + (off[near] / 0.1) ** 2)
        hold = np.diag([0.5, 0.5, 20.0])
        back = pose - guess
        back[2] = wrap(float(back[2]))
        gradient = (j * w[:, None]).T @ off[near] + hold @ back
        step = np.linalg.solve((j * w[:, None]).T @ j + hold, gradient)
        pose = pose - np.clip(step, -0.3, 0.3)
    return pose


def explained(walls: Walls, hits: FloatArray, pose: FloatArray) -> float:
    """Share of hits that lie on walls, where the robot itself stands in the free."""
    cell = np.floor(pose[:2] / CELL_M).astype(int)
    if (cell < 0).any() or (cell >= walls.free.shape).any() or not walls.free[tuple(cell)]:
        return 0.0
    return float((walls.at(moved(hits, pose))[0] < TRUSTED_M).mean())


def starts(walls: Walls, log: Log) -> list[FloatArray]:
    """Poses of the first scan at which the first stretch of the run lies on the map's walls."""
    rows = range(0, min(FIRST_SCANS, len(log.ranges)), 4)
    joined = [moved(log.hits(k), between(log.poses[0], log.poses[k])) for k in rows]
    points = np.concatenate(joined)
    field = np.exp(-0.5 * (walls.distance / BLUR_M) ** 2).astype(np.float32)
    spectrum = np.fft.rfft2(field)
    found = []
    for turn in np.arange(TURNS) * (2 * np.pi / TURNS):
        cells = np.floor(moved(points, np.array([0, 0, turn])) / CELL_M).astype(int)
        image = np.zeros(field.shape, np.float32)
        image[cells[:, 0] % field.shape[0], cells[:, 1] % field.shape[1]] = 1.0
        likeness = np.fft.irfft2(spectrum * np.conj(np.fft.rfft2(image)), field.shape)
        likeness = np.where(walls.free, likeness, -1.0)
        best = np.unravel_index(np.argmax(likeness), likeness.shape)
        found.append((float(likeness[best] / image.sum()), *best, turn))
    found.sort(reverse=True)
    best_few = found[:HYPOTHESES]
    return [np.array([(i + 0.5) * CELL_M, (j + 0.5) * CELL_M, psi]) for _, i, j, psi in best_few]


def followed(
    walls: Walls, log: Log, start: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Poses of the first scans from a start, and which share of their hits the map explains."""
    poses, shares = np.empty((count, 3)), np.empty(count)
    pose = start
    for scan in range(count):
        if scan:
            pose = composed(pose, between(log.poses[scan - 1], log.poses[scan]))
        hits = log.hits(scan)
        pose = fitted(walls, hits, pose)
        poses[scan], shares[scan] = pose, explained(walls, hits, pose)
    return poses, shares


def on_map(walls: Walls, log: Log, name: str) -> FloatArray:
    """Truth from the start that explains most; NaN where the map explains too little."""
    begun = [followed(walls, log, start, FIRST_SCANS) for start in starts(walls, log)]
    begun.sort(key=lambda one: -float(one[1].mean()))
    other = next((one for one in begun if np.hypot(*(one[0][0] - begun[0][0][0])[:2]) > 2.0), None)
    tried = [one[0][0] for one in (begun[0], other) if one is not None]
    whole = [followed(walls, log, start, len(log.ranges)) for start in tried]
    whole.sort(key=lambda one: -float(one[1].mean()))
    poses, shares = whole[0]
    others = [one[1].mean() for one in whole[1:]]
    print(
        f"{name}: {len(shares)} scans, {(shares >= TRUSTED).sum()} with truth; of the hits "
        f"{shares.mean():.2f} on walls (median {np.median(shares):.2f}); the best start elsewhere "
        f"explains {max(others, default=float('nan')):.2f}"
    )
    return np.where(shares[:, None] >= TRUSTED, poses, np.nan)


def anchored(raw: Log, corrected: Log, name: str) -> FloatArray:
    """Truth of a raw log: poses of the scans both logs hold, between them the odometry bent."""
    anchors = list(_anchors(raw, corrected))
    out = np.full((len(raw.ranges), 3), np.nan)
    bent = []
    for (k, first), (m, last) in pairwise(anchors):
        end = composed(first, between(raw.poses[k], raw.poses[m]))
        off = last - end
        off[2] = wrap(float(off[2]))
        bent.append(np.hypot(*off[:2]))
        path = np.cumsum(np.hypot(*np.diff(raw.poses[k : m + 1, :2], axis=0).T))
        share = np.concatenate([[0.0], path / max(path[-1], 1e-9)])
        for row in range(k, m + 1):
            here = composed(first, between(raw.poses[k], raw.poses[row]))
            out[row] = here + share[row - k] * off
    out[:, 2] = wrap_array(out[:, 2])
    print(
        f"{name}: {len(anchors)} anchors; between two of them odometry was bent by "
        f"{np.median(bent):.2f} m in the median, {np.max(bent):.2f} m at most"
    )
    return out


def _anchors(raw: Log, corrected: Log) -> Iterator[tuple[int, FloatArray]]:
    """Scans of the raw log that the corrected one holds too, in the order of both."""
    at = 0
    near = np.minimum(raw.ranges, NO_RETURN_M)
    for ranges, pose in zip(corrected.ranges, corrected.poses, strict=True):
        off = np.abs(near[at:] - np.minimum(ranges, NO_RETURN_M)).max(axis=1)
        same = np.flatnonzero(off < SAME_M)
        if len(same):
            yield at + int(same[0]), pose
            at += int(same[0]) + 1


def main(given: Sequence[str] | None = None) -> None:
    """Write what can be written; say what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    out = parser.parse_args(given).output
    laser = Path(os.environ.get("FPNAV_DATA", "../shared/data")) / "laser"
    out.mkdir(parents=True, exist_ok=True)
    if (laser / "wean_hall").exists():
        walls = Walls.read(laser / "wean_hall" / "wean.dat.gz")
        for number in (1, 3):
            log = Log.read(laser / "wean_hall" / f"robotdata{number}.log.gz")
            log.write(out / f"wean{number}.log", on_map(walls, log, f"wean{number}"))
    if (laser / "intel_raw").exists():
        raw = Log.read(laser / "intel_raw" / "intel_raw.log.gz")
        corrected = Log.read(laser / "carmen" / "intel-corrected.log.gz")
        raw.write(out / "intel_raw.log", anchored(raw, corrected, "intel_raw"))


if __name__ == "__main__":
    main()
