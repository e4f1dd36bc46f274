"""Checks of odometry and truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fpnav.geometry import path_length, wrap_array
from fpnav.logs.checks.finding import Finding, fail, note, ok, warn
from fpnav.logs.frames import Log, Track
from fpnav.logs.ledger import Budget
from fpnav.values import FloatArray

_MOST_MPS = 5.0
_PLAUSIBLE_MPS = (0.001, 20.0)
_COVERED = 0.99
_ABSENT = {
    "odometry": "path lengths go by truth where there is one",
    "truth": "figures of accuracy need --truth",
}


def covered(log: Log, budget: Budget) -> Iterator[Finding]:
    """Odometry and truth, where there are any, cover the run."""
    if not log.primary:
        return
    references = log.references()
    for role in ("odometry", "truth"):
        if role not in log.streams:
            absent = _ABSENT[role]
            yield note("coverage", "", f"no {role}: {absent}")
            continue
        known = sum(getattr(reference, role) is not None for reference in references)
        share = known / len(references)
        if known == 0:
            message = f"{role} covers none of the frames: another clock, or another time"
            yield fail("coverage", "E205", message, "check the clocks; --truth FILE.tum")
        elif share < _COVERED:
            message = f"{role} covers {share:.0%} of the frames"
            yield warn("coverage", "E205", message, "frames without it count in no figure")
        else:
            yield ok("coverage", f"{role} covers the run")


def motion(log: Log, budget: Budget) -> Iterator[Finding]:
    """Odometry and truth move as a robot can, in metres and radians."""
    for role in ("odometry", "truth"):
        track = log.track(role)
        if track is None or len(track.stamps_ns) < 3:
            continue
        speeds = _speeds(track)
        jumps = int(np.count_nonzero(speeds > _MOST_MPS))
        moving = speeds[speeds > 0.01]
        typical = float(np.median(moving)) if len(moving) else 0.0
        if jumps:
            message = f"{role}: {jumps} steps faster than {_MOST_MPS:g} m/s"
            yield warn("motion", "E505", message, "encoder reset or teleport: cut the log there")
        if len(moving) and not _PLAUSIBLE_MPS[0] <= typical <= _PLAUSIBLE_MPS[1]:
            guess = "millimetres" if typical > _PLAUSIBLE_MPS[1] else "other units"
            message = f"{role}: typical speed {typical:.3g} m/s, perhaps {guess}"
            yield warn("motion", "E13", message, "odometry is in metres and radians (REP 103)")
        elif not len(moving):
            yield warn("motion", "E13", f"{role} does not move", "places need a robot that moves")
        elif not jumps:
            yield ok("motion", f"{role}: typical speed {typical:.2f} m/s")


def _speeds(track: Track) -> FloatArray:
    """Speed of each step (m/s)."""
    seconds = np.diff(track.stamps_ns) / 1e9
    steps = np.hypot(*np.diff(track.poses[:, :2], axis=0).T)
    return np.asarray(steps / np.maximum(seconds, 1e-6), dtype=np.float64)


def odometry_against_truth(log: Log, budget: Budget) -> Iterator[Finding]:
    """Odometry is plausible against truth, and is not truth itself."""
    both = [r for r in log.references() if r.odometry and r.truth] if log.primary else []
    if len(both) < 10:
        return
    odometry = _array([r.odometry for r in both])
    truth = _array([r.truth for r in both])
    length, true_length = (float(path_length(poses)[-1]) for poses in (odometry, truth))
    turned = wrap_array(np.diff(odometry[:, 2]) - np.diff(truth[:, 2]))
    drift = float(np.degrees(abs(turned.sum()))) / max(true_length, 1.0)
    ratio = length / true_length if true_length > 0 else 0.0
    if np.allclose(odometry, truth, atol=1e-3):
        fix = "corrected poses are no odometry: ingest --poses truth"
        yield warn("drift", "E505", "odometry equals truth: it would leak the answer", fix)
    elif not 0.7 <= ratio <= 1.4:
        message = f"odometry travels {length:.1f} m where truth travels {true_length:.1f} m"
        yield warn("drift", "E13", message, "check units, wheel sizes and the clocks of both")
    else:
        yield ok("drift", f"path {ratio:.2f} of the true one, heading {drift:.2f} degrees a metre")


def _array(poses: list[object]) -> FloatArray:
    rows = [(p.x_m, p.y_m, p.heading_rad) for p in poses]  # type: ignore[attr-defined]
    return np.array(rows, dtype=np.float64)
