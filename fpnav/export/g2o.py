"""g2o pose graph, as pose-graph optimisers read it.

Vertices are the signatures of the mapping or reference run (ids 0 .. R - 1) and, of a result, its
queries (ids from R on). Edges between consecutive signatures are their odometry, else their truth;
edges from a member to a query are the relative poses that were verified, with their covariance.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.export.subject import Subject, poses_of
from fpnav.geometry import relative
from fpnav.store.tables import Result
from fpnav.values import FloatArray, Pose2

SIGMA_M, SIGMA_PER_M = 0.02, 0.05
SIGMA_RAD, SIGMA_PER_RAD = 0.01, 0.05
"""Odometry is taken to be this good, and to grow worse with the way and the turn between two
signatures. Logs state no covariance that could be trusted (faults.md E14)."""


def write(subject: Subject) -> bytes:
    """The pose graph; vertex 0 is fixed.

    Raises
    ------
    StoreError
        A signature of the mapping run has no pose.
    """
    poses = poses_of(subject.references)
    if not len(poses) or not np.isfinite(poses).all():
        raise StoreError(f"{subject.name}: signatures have no pose: neither truth nor odometry")
    lines = [_vertex(row, pose) for row, pose in enumerate(poses)]
    lines += _run_edges(subject.references, 0)
    if subject.result is not None:
        lines += _query_lines(subject.result)
    return "\n".join([*lines, "FIX 0", ""]).encode()


def _query_lines(result: Result) -> Iterator[str]:
    """Vertices of queries that were placed by a verified relative pose, and the edges to them."""
    first = len(result.references)
    poses = poses_of(result.queries)
    for query in np.flatnonzero(result.decision >= 0).tolist():
        member, pose = int(result.members[query, 0]), result.relative[query]
        if member < 0 or not np.isfinite(pose).all() or not np.isfinite(poses[query]).all():
            continue
        yield _vertex(first + query, poses[query])
        yield _edge(member, first + query, pose, _information(result.covariance[query]))


def _run_edges(rows: NDArray[Any], first: int) -> Iterator[str]:
    """Odometry between consecutive signatures of one session; truth where there is none."""
    odometry = rows["odometry"]
    poses = np.where(np.isfinite(odometry).all(axis=1, keepdims=True), odometry, rows["truth"])
    for row in range(len(rows) - 1):
        pair = poses[row : row + 2]
        if rows["session"][row] != rows["session"][row + 1] or not np.isfinite(pair).all():
            continue
        step = relative(Pose2(*pair[0].tolist()), Pose2(*pair[1].tolist()))
        moved = np.array([step.x_m, step.y_m, step.heading_rad])
        along = SIGMA_M + SIGMA_PER_M * float(np.hypot(step.x_m, step.y_m))
        turned = SIGMA_RAD + SIGMA_PER_RAD * abs(step.heading_rad)
        yield _edge(
            first + row, first + row + 1, moved, np.diag(np.array([along, along, turned]) ** -2.0)
        )


def _information(covariance: FloatArray) -> FloatArray:
    """Inverse of a covariance; that of the odometry of a metre where it is none."""
    if np.isfinite(covariance).all() and np.linalg.eigvalsh(covariance).min() > 1e-12:
        return np.asarray(np.linalg.inv(covariance))
    sigma = np.array([SIGMA_M + SIGMA_PER_M, SIGMA_M + SIGMA_PER_M, SIGMA_RAD + SIGMA_PER_RAD])
    return np.asarray(np.diag(sigma**-2.0))


def _vertex(number: int, pose: FloatArray) -> str:
    return f"VERTEX_SE2 {number} {_numbers(pose)}"


def _edge(source: int, target: int, pose: FloatArray, information: FloatArray) -> str:
    upper = information[np.triu_indices(3)]
    return f"EDGE_SE2 {source} {target} {_numbers(pose)} {_numbers(upper)}"


def _numbers(values: FloatArray) -> str:
    return " ".join(f"{value:.9g}" for value in values.tolist())
