"""Small results built by hand, and two of the size of a real run, for tests of what reads them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav import __version__
from fpnav.geometry import path_length, wrap_array
from fpnav.store.tables import EDGE, REFERENCE, Accepted, MapView, Ragged, Result

NO_VIEW = MapView(
    place_ids=np.zeros(0, np.int64),
    place_pose=np.zeros((0, 3)),
    extent_m=np.zeros(0),
    edges=np.zeros(0, EDGE),
    novelty=np.zeros(0),
    threshold=np.nan,
)


def header(method: str = "match", **facts: Any) -> dict[str, Any]:
    """Header as ``localize`` and ``recognize`` write it."""
    log = {
        "format": "fpnav/signatures",
        "format_version": 1,
        "fpnav": __version__,
        "system": "strings",
        "preset": "paper",
        "params": {"theta": 0.5},
        "sources": [{"name": "drive.mcap", "sha256": "ab" * 32, "bytes": 1_234_567}],
        "chain": [],
    }
    return {
        **log,
        "format": "fpnav/result",
        "method": method,
        "protocol": {"radius_m": 1.5, "heading_deg": 45, "travelled_from": "odometry"},
        "sources": [{"name": "drive.sigs.h5", "sha256": "cd" * 32, "bytes": 45_678}],
        "chain": [log],
        **facts,
    }


def rows(poses: Any, *, labels: Sequence[str] = ()) -> NDArray[Any]:
    """REFERENCE rows at the given truth poses (N, 3), a second apart; NaN = unknown."""
    truth = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
    table = np.zeros(len(truth), REFERENCE)
    table["index"] = np.arange(len(truth)) * 2
    table["stamp_ns"] = np.arange(len(truth)) * 10**9
    table["travelled_m"] = path_length(truth)
    table["odometry"] = np.nan
    table["truth"] = truth
    table["heading_rad"] = np.nan
    for row, label in enumerate(labels):
        table["label"][row] = label.encode()
    return table


def nowhere(count: int) -> NDArray[Any]:
    """REFERENCE rows without truth."""
    return rows(np.full((count, 3), np.nan))


def recognition(
    scores: Any,
    *,
    pairs: Mapping[int, Sequence[int]] | None = None,
    queries: NDArray[Any] | None = None,
    references: NDArray[Any] | None = None,
    depth: int | None = None,
    candidates: Any = None,
    **fields: Any,
) -> Result:
    """Result of ``recognize`` with the ranking of a score matrix (Q, R), higher = more alike."""
    scores = np.asarray(scores, dtype=np.float64)
    count, size = scores.shape
    last = np.full(count, size) if candidates is None else np.asarray(candidates)
    scores = np.where(np.arange(size) < last[:, None], scores, -np.inf)
    order = np.argsort(-scores, axis=1, kind="stable")[:, : depth or size]
    ranked = np.take_along_axis(scores, order, axis=1)
    order = np.where(np.isfinite(ranked), order, -1)
    truth = Accepted("poses", "the log's own truth topic")
    if pairs is not None:
        accepted = [np.array(pairs.get(row, []), np.int64) for row in range(count)]
        truth = Accepted("pairs", "truth.json", Ragged.of(accepted, np.dtype(np.int64)))
    result = Result(
        header=header("recognize"),
        queries=nowhere(count) if queries is None else queries,
        references=nowhere(size) if references is None else references,
        owner=np.arange(size),
        candidates=last,
        places=order,
        members=order,
        scores=ranked,
        headings_rad=np.full(order.shape, np.nan),
        decision=order[:, 0].copy(),
        stated=np.full(count, np.nan),
        entropy=np.full(count, np.nan),
        belief=np.zeros((count, 0), np.float32),
        relative=np.full((count, 3), np.nan),
        covariance=np.full((count, 3, 3), np.nan),
        truth=truth,
        view=NO_VIEW,
    )
    return replace(result, **fields)


def chain_edges(pairs: Sequence[tuple[int, int]]) -> NDArray[Any]:
    """EDGE rows between the given places, a metre long."""
    table = np.zeros(len(pairs), EDGE)
    for row, (source, target) in enumerate(pairs):
        table[row] = (source, target, 1.0, 0.0, 0.0, 1)
    return table


def on_map(
    mapping: Any,
    owner: Sequence[int],
    queries: Any,
    answers: Any,
    *,
    scores: Any = None,
    edges: Sequence[tuple[int, int]] = (),
    labels: tuple[Sequence[str], Sequence[str]] = ((), ()),
    **fields: Any,
) -> Result:
    """Result of ``localize``: answers (Q, k) are place ids, members the first row of each place."""
    references = rows(mapping, labels=labels[1])
    asked = rows(queries, labels=labels[0])
    answers = np.asarray(answers, dtype=np.int64).reshape(len(asked), -1)
    owned = np.asarray(owner, dtype=np.int64)
    ids, first = np.unique(owned, return_index=True)
    members = np.full(answers.shape, -1)
    for place, row in zip(ids, first, strict=True):
        members[answers == place] = row
    if scores is None:
        scores = np.tile(-np.arange(answers.shape[1], dtype=float), (len(asked), 1))
    poses = np.array([references["truth"][owned == place].mean(axis=0) for place in ids])
    count = len(asked)
    result = Result(
        header=header("match"),
        queries=asked,
        references=references,
        owner=owned,
        candidates=np.full(count, len(references)),
        places=answers,
        members=members,
        scores=np.where(answers >= 0, scores, -np.inf),
        headings_rad=np.full(answers.shape, np.nan),
        decision=answers[:, 0].copy(),
        stated=np.full(count, np.nan),
        entropy=np.full(count, np.nan),
        belief=np.zeros((count, 0), np.float32),
        relative=np.full((count, 3), np.nan),
        covariance=np.full((count, 3, 3), np.nan),
        truth=Accepted("poses", "the log's own truth topic"),
        view=MapView(
            place_ids=ids,
            place_pose=poses,
            extent_m=np.ones(len(ids)),
            edges=chain_edges(edges),
            novelty=np.full(len(references), np.nan),
            threshold=np.nan,
        ),
    )
    return replace(result, **fields)


def corridor_path(step_m: float, offset_m: float = 0.0) -> NDArray[np.float64]:
    """Poses along a rectangle of corridors of 24 x 10 m with a branch, ``offset_m`` to the left."""
    corners = np.array([[0, 0], [24, 0], [24, 10], [12, 10], [12, 4], [12, 10], [0, 10], [0, 0]])
    points = []
    for start, end in pairwise(corners):
        along = (end - start) / np.hypot(*(end - start))
        left = np.array([-along[1], along[0]])
        distances = np.arange(0.0, np.hypot(*(end - start)), step_m)
        heading = np.full(len(distances), np.arctan2(along[1], along[0]))
        xy = start + distances[:, None] * along + offset_m * left
        points.append(np.column_stack([xy, heading]))
    return np.vstack(points)


def office_run(
    method: str = "filter", *, quality: float = 1.0, seed: int = 7, step_m: float = 0.35
) -> Result:
    """A made-up run of the size of a real one on a map of twenty places, with a belief.

    ``quality`` scales how well observations tell places apart. Nothing here is a measurement.
    """
    random = np.random.default_rng(seed)
    mapping, queries = corridor_path(0.15), corridor_path(step_m, offset_m=0.25)
    owner = np.minimum((path_length(mapping) / 4.2).astype(np.int64), 19)
    count = int(owner.max()) + 1
    centre = np.array([mapping[owner == place].mean(axis=0) for place in range(count)])
    away = np.hypot(*(queries[:, None, :2] - centre[None, :, :2]).transpose(2, 0, 1))
    scores = 0.75 * np.exp(-away / 4.0) + random.normal(0, 0.16 / quality, away.shape)
    belief = np.exp(9.0 * quality * scores)
    if method != "match":
        kernel = np.ones(7) / 7
        belief = np.exp(
            np.apply_along_axis(lambda c: np.convolve(c, kernel, "same"), 0, 14 * scores)
        )
    belief = belief / belief.sum(axis=1, keepdims=True)
    order = np.argsort(-belief, axis=1, kind="stable")[:, :10]
    edges = [(place, place + 1) for place in range(count - 1)] + [(count - 1, 0)]
    result = on_map(
        mapping, owner.tolist(), queries, order, scores=np.take_along_axis(belief, order, axis=1)
    )
    stated = np.take_along_axis(belief, order[:, :1], axis=1)[:, 0]
    turn = wrap_array(queries[:, 2] - mapping[np.searchsorted(owner, order[:, 0]), 2])
    headings = np.full(order.shape, np.nan)
    headings[:, 0] = turn + random.normal(0, 0.08, len(turn))
    novelty = np.clip(random.normal(0.3, 0.07, len(mapping)), 0, 1)
    novelty[np.flatnonzero(np.diff(owner)) + 1] += 0.32
    letters = np.array(list("vvvcccnnnnfABEI"))
    strips = tuple("".join(random.choice(letters, size)) for size in random.integers(18, 28, count))
    view = replace(
        result.view,
        edges=chain_edges(edges + [(b, a) for a, b in edges]),
        extent_m=np.full(count, 4.2),
        novelty=novelty,
        threshold=0.5,
        strips=strips,
    )
    return replace(
        result,
        header=header(method, protocol={"travelled_from": "odometry", "step_m": step_m}),
        headings_rad=headings,
        stated=stated,
        entropy=-(belief * np.log(belief)).sum(axis=1),
        decision=np.where(stated > 0.35, order[:, 0], -1),
        belief=belief.astype(np.float32),
        view=view,
        query_strips=tuple("".join(random.choice(letters, 22)) for _ in range(len(queries))),
    )


def revisit_run(*, quality: float = 1.0, seed: int = 3) -> Result:
    """A made-up run of two laps matched against its own past. Nothing here is a measurement."""
    random = np.random.default_rng(seed)
    path = np.vstack([corridor_path(0.4), corridor_path(0.4, offset_m=0.2)[:140]])
    table = rows(path)
    away = np.hypot(*(path[:, None, :2] - path[None, :, :2]).transpose(2, 0, 1))
    turned = np.abs(wrap_array(path[:, None, 2] - path[None, :, 2])) > np.pi / 4
    likeness = np.exp(-away / 3.0) * np.where(turned, 0.4, 1.0)
    scores = likeness + random.normal(0, 0.14 / quality, away.shape)
    travelled = table["travelled_m"]
    candidates = np.searchsorted(travelled, travelled - 15.0, side="right")
    result = recognition(scores, queries=table, references=table, candidates=candidates, depth=10)
    best = np.where(np.isfinite(result.scores[:, 0]), result.scores[:, 0], 0.0)
    stated = np.where(best > 0, 1 / (1 + np.exp(-12 * (best - 0.75))), np.nan)
    facts = {
        "protocol": {
            "radius_m": 1.5,
            "heading_deg": 45,
            "exclude_path_m": 15.0,
            "exclude_frames": 0,
            "query_every": 1,
            "travelled_from": "truth",
        }
    }
    return replace(
        result,
        header=header("recognize", **facts),
        stated=stated,
        decision=np.where(np.nan_to_num(stated) >= 0.5, result.places[:, 0], -1),
    )
