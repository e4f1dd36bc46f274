"""Lines of CARMEN logs, which g2o files of laser graphs carry too.

FLASER n r1 .. rn  laser x y theta  robot x y theta  ipc_time host logger_time
    One degree (180, 181 beams), half (360, 361) or a quarter (400, 401), the first beam at -90
    degrees, as CARMEN itself reads it; other counts span 180 degrees.
ROBOTLASER1 type start fov increment max accuracy remission  n r1 .. rn  m s1 .. sm
    laser x y theta  robot x y theta  tv rv forward side axis  ipc_time host logger_time
ODOM x y theta tv rv accel  ipc_time host logger_time
TRUEPOS true x y theta  odometry x y theta  ipc_time host logger_time
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.values import LaserScan, Pose2

WORDS = ("FLASER", "ROBOTLASER1", "ODOM", "TRUEPOS")
FARTHEST_M = 80.0
_NEAREST_M = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """One line that was understood."""

    word: str
    stamp_ns: int
    robot: Pose2
    laser: Pose2
    scan: LaserScan | None = None
    speeds: tuple[float, float] = (0.0, 0.0)


def parse(text: str, no_return_m: float = FARTHEST_M) -> Line:
    """A line of one of the four kinds; raises ValueError where it is not whole."""
    words = text.split()
    if words[0] == "FLASER":
        return _flaser(words, no_return_m)
    if words[0] == "ROBOTLASER1":
        return _robotlaser(words)
    if len(words) < 10:
        raise ValueError(f"{words[0]} with {len(words)} fields, expected 10")
    pose = _pose(words[1:4])
    speeds = (float(words[4]), float(words[5])) if words[0] == "ODOM" else (0.0, 0.0)
    return Line(words[0], _stamp(words[7], words[-1]), pose, pose, None, speeds)


def _flaser(words: list[str], no_return_m: float) -> Line:
    count = int(words[1])
    if count < 1 or len(words) < 2 + count + 9:
        raise ValueError(f"FLASER of {count} beams with {len(words)} fields")
    ranges = _ranges(words[2 : 2 + count], no_return_m)
    rest = words[2 + count :]
    step = _increment(count)
    scan = LaserScan(ranges, -math.pi / 2, step, _NEAREST_M, no_return_m)
    return Line("FLASER", _stamp(rest[6], words[-1]), _pose(rest[3:6]), _pose(rest[0:3]), scan)


def _robotlaser(words: list[str]) -> Line:
    start, _, step, farthest = (float(word) for word in words[2:6])
    count = int(words[8])
    remissions = int(words[9 + count])
    rest = words[10 + count + remissions :]
    if count < 1 or len(rest) < 14:
        raise ValueError(f"ROBOTLASER1 of {count} beams with {len(words)} fields")
    farthest = min(farthest, FARTHEST_M) if farthest > 0 else FARTHEST_M
    ranges = _ranges(words[9 : 9 + count], farthest)
    scan = LaserScan(ranges, start, step, _NEAREST_M, farthest)
    speeds = (float(rest[6]), float(rest[7]))
    stamp_ns = _stamp(rest[11], words[-1])
    return Line("ROBOTLASER1", stamp_ns, _pose(rest[3:6]), _pose(rest[0:3]), scan, speeds)


def _ranges(words: list[str], no_return_m: float) -> NDArray[np.float32]:
    """Ranges with +inf where nothing was hit (REP 117)."""
    ranges = np.array(words, dtype=np.float32)
    ranges[ranges >= no_return_m] = np.inf
    return ranges


def _increment(count: int) -> float:
    for per_degree in (1, 2, 4):
        span = 100 if per_degree == 4 else 180
        if count in (span * per_degree, span * per_degree + 1):
            return math.pi / 180 / per_degree
    return math.pi / max(count - 1, 1)


def _pose(words: Sequence[str]) -> Pose2:
    x, y, heading = (float(word) for word in words)
    if not math.isfinite(x + y + heading):
        raise ValueError(f"pose {x} {y} {heading}")
    return Pose2(x, y, heading)


def _stamp(ipc_time: str, logger_time: str) -> int:
    """Time of a line; the logger's where the sender left its own at zero."""
    ipc, logger = float(ipc_time), float(logger_time)
    seconds = ipc if ipc > 0 else logger
    if not 0 <= seconds < 2**31:
        raise ValueError(f"time {seconds}")
    return round(seconds * 1e9)
