"""Time order of a topic, and joins by time.

Policy (faults.md B1-B8). Frames stand at header stamps, unless some used topic's stamps are
mostly zero or jump back by more than a second: then the whole log goes by log time (note E202 or
B6). Within a topic messages are taken in log-time order; one whose stamp is earlier than its
predecessor's is skipped (E201).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import interpolate_poses
from fpnav.values import FloatArray

JUMP_NS = 1_000_000_000
BRIDGE_NS = 30_000_000_000
BRIDGE_M = 2.0
YEAR_2200_NS = 7_258_118_400 * 10**9


def by_log_time(rows: NDArray[Any]) -> NDArray[np.int64]:
    """Order of rows by log time, then place in the file."""
    return np.lexsort((rows["offset"], rows["block"], rows["log_ns"])).astype(np.int64)


def clock_trouble(rows: NDArray[Any]) -> str:
    """Code of what makes a topic's header stamps unusable, empty where they are fine.

    ``rows`` in log-time order. B6: mostly zero; E204: outside 1970 .. 2200; E202: jump back.
    """
    stamps = rows["stamp_ns"]
    if len(stamps) == 0:
        return ""
    if np.count_nonzero(stamps == 0) > len(stamps) // 2 and len(stamps) > 1:
        return "B6"
    sane = (stamps >= 0) & (stamps < YEAR_2200_NS)
    if np.count_nonzero(~sane) > len(stamps) // 2:
        return "E204"
    steps = np.diff(stamps[sane & (stamps > 0)])
    jumps = np.flatnonzero(steps < -JUMP_NS)
    return "E202" if _stays(stamps[sane & (stamps > 0)], jumps) else ""


def _stays(stamps: NDArray[np.int64], jumps: NDArray[np.int64]) -> bool:
    """Whether the clock stays back after a jump, instead of one message being late."""
    for before in jumps.tolist():
        after = stamps[before + 1 : before + 4]
        if len(after) > 1 and bool(np.all(after < stamps[before] - JUMP_NS)):
            return True
    return False


def in_order(stamps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which stamps are not earlier than any before them, (n,)."""
    if len(stamps) == 0:
        return np.zeros(0, dtype=np.bool_)
    return stamps >= np.maximum.accumulate(stamps)


def median_period(stamps: NDArray[np.int64]) -> float:
    """Median step of increasing stamps in ns, NaN below two."""
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else float("nan")


def nearest(
    stamps: NDArray[np.int64], query: NDArray[np.int64], tolerance_ns: float
) -> NDArray[np.int64]:
    """Index of the stamp nearest each query, the earlier one of two, -1 beyond the tolerance.

    ``stamps`` (n,) and ``query`` (q,) do not decrease.
    """
    if len(stamps) == 0:
        return np.full(len(query), -1, dtype=np.int64)
    after = np.clip(np.searchsorted(stamps, query), 0, len(stamps) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.abs(stamps[before] - query) <= np.abs(stamps[after] - query)
    chosen = np.where(closer, before, after).astype(np.int64)
    chosen[np.abs(stamps[chosen] - query) > tolerance_ns] = -1
    return chosen


def holding(stamps: NDArray[np.int64], query: NDArray[np.int64]) -> NDArray[np.int64]:
    """Index of the last stamp at or before each query, -1 before the first."""
    return (np.searchsorted(stamps, query, side="right") - 1).astype(np.int64)


def gaps(stamps: NDArray[np.int64], factor: float = 5.0) -> tuple[int, float]:
    """Number of pauses longer than ``factor`` median periods (and 0.5 s), and the longest (s)."""
    steps = np.diff(stamps)
    period = median_period(stamps)
    if len(steps) == 0 or np.isnan(period):
        return 0, 0.0
    long = steps[steps > max(factor * period, 5e8)]
    return len(long), float(long.max()) / 1e9 if len(long) else 0.0


def interpolated(
    stamps: NDArray[np.int64],
    poses: FloatArray,
    query: NDArray[np.int64],
    reach_ns: float,
    *,
    bridge: bool = True,
) -> FloatArray:
    """Poses (q, 3) at the query stamps; NaN where nothing says where the robot was.

    Between samples linear (heading along the shorter arc), before the first and after the last
    the nearest sample. That holds where a sample is within ``reach_ns``, and with
    ``bridge`` within a gap of at most 30 s over which the robot moved at most 2 m: it was not
    far from the line.
    """
    if len(stamps) == 0:
        return np.full((len(query), 3), np.nan)
    out = interpolate_poses(stamps, poses, np.clip(query, stamps[0], stamps[-1]))
    far = nearest(stamps, query, reach_ns) < 0
    if bridge:
        far &= ~_bridged(stamps, poses, query)
    out[far] = np.nan
    return out


def _bridged(
    stamps: NDArray[np.int64], poses: FloatArray, query: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which queries lie in a gap that is short in time and in space, (q,)."""
    after = np.searchsorted(stamps, query)
    inside = (after > 0) & (after < len(stamps))
    after = np.clip(after, 1, max(len(stamps) - 1, 1))
    before = after - 1
    if len(stamps) < 2:
        return np.zeros(len(query), dtype=np.bool_)
    moved = np.hypot(*(poses[after, :2] - poses[before, :2]).T)
    brief = stamps[after] - stamps[before] <= BRIDGE_NS
    return np.asarray(inside & brief & (moved <= BRIDGE_M), dtype=np.bool_)
