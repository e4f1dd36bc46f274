"""TUM trajectory, as evo reads it: ``t x y z qx qy qz qw``, single blanks, nine decimals.

Of a map: the mapping run. Of a result: where each localized query is thought to be; a query that
was not localized has no line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fpnav.errors import StoreError
from fpnav.export.subject import Subject, estimates, poses_of
from fpnav.values import Pose2


def write(subject: Subject) -> bytes:
    """The trajectory.

    Raises
    ------
    StoreError
        No pose is known.
    """
    lines = [_line(stamp, pose) for stamp, pose in _poses(subject)]
    if not lines:
        raise StoreError(f"{subject.name}: no pose is known: neither truth nor odometry")
    return ("\n".join(lines) + "\n").encode()


def _poses(subject: Subject) -> Iterator[tuple[int, Pose2]]:
    if subject.result is not None:
        stamps = subject.result.queries["stamp_ns"].tolist()
        for query, pose in estimates(subject.result):
            yield stamps[query], pose
        return
    for stamp, pose in zip(
        subject.references["stamp_ns"].tolist(), poses_of(subject.references), strict=True
    ):
        if np.isfinite(pose).all():
            yield stamp, Pose2(*pose.tolist())


def _line(stamp_ns: int, pose: Pose2) -> str:
    seconds, rest = divmod(stamp_ns, 10**9)
    half = 0.5 * pose.heading_rad
    return (
        f"{seconds}.{rest:09d} {pose.x_m:.9f} {pose.y_m:.9f} 0 "
        f"0 0 {math.sin(half):.9f} {math.cos(half):.9f}"
    )
