"""One decision of the place cells: 30 local views against stored landmarks, exact (eq. 1).

The peer is faiss, the flat L1 index, one thread each, the same views and the same answers. faiss is
no dependency: put it on the path for this measurement alone,
pip install --no-deps --target DIR faiss-cpu && PYTHONPATH=DIR python -m benchmarks landmarks
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import in_turn
from fpnav.execution.checkpoint import Checkpoints
from fpnav.execution.spread import Here
from fpnav.execution.walk import LogOptions, Run, SystemChoice, signatures_of
from fpnav.matching.patches import Nearest, Patches, nearest
from fpnav.systems.placecell.landmarks import sad_limit
from fpnav.systems.placecell.params import PRESETS

LOGS = Path(__file__).parents[1] / "sample_logs"
PRESET = "fig7b"
VIEWS = 30
COUNTS = (300, 1_000, 10_000, 100_000, 1_000_000)
"""Numbers of landmarks; beyond those of the log, its views with another light and noise."""

LARGEST_PEER = 100_000
"""Landmarks up to which the peer is asked: it holds four bytes a pixel."""


def main() -> None:
    """Print the time of a decision over the number of landmarks, and the ratio to the peer."""
    cv2.setNumThreads(1)
    params = PRESETS[PRESET]
    views = pixels_of("office_test.mcap")[-VIEWS:]
    known = pixels_of("office_map.mcap")
    limit = sad_limit(params.pixels, params.rt)
    asked = Patches.of(views, params.patch_rows, params.patch_columns)
    for count in COUNTS:
        store = Patches.of(landmarks(known, count), params.patch_rows, params.patch_columns)
        calls: dict[str, Callable[[], Any]] = {
            "ours": lambda store=store: nearest(asked, store, params.interpretations, limit)  # type: ignore[misc]
        }
        theirs = (
            peer(store.pixels, views, params.interpretations) if count <= LARGEST_PEER else None
        )
        if theirs is not None:
            check(calls["ours"](), *theirs(), limit)
            calls["faiss"] = theirs
        medians = in_turn(calls, rounds=5)
        told = f"  {count:9,d} landmarks {1e3 * medians['ours']:10.2f} ms a decision"
        if theirs is not None:
            ratio = medians["faiss"] / medians["ours"]
            told += f", faiss flat L1 {1e3 * medians['faiss']:9.1f} ms, {ratio:.1f} times faster"
        print(told, flush=True)
    if peer(known[:1], views, 1) is None:
        print("  faiss is not installed: no ratio (see the head of this file)")


def pixels_of(name: str) -> NDArray[np.uint8]:
    """All local views of a sample log, (n, D)."""
    run = signatures_of(
        [LOGS / name],
        SystemChoice("placecell", PRESET),
        LogOptions(),
        Here(),
        lambda done: None,
        Checkpoints(LOGS / name, resume=False),
    )
    return flat(run)


def flat(run: Run) -> NDArray[np.uint8]:
    """Pixels of every view of a run, (n, D)."""
    size = PRESETS[PRESET].pixels
    return np.ascontiguousarray(run.table.parts["pixels"].flat.reshape(-1, size))


def landmarks(known: NDArray[np.uint8], count: int) -> NDArray[np.uint8]:
    """So many landmarks: views of the log, then the same in other light with noise."""
    rng = np.random.default_rng(0)
    made = np.empty((count, known.shape[1]), np.uint8)
    made[: len(known)] = known[:count]
    for start in range(len(known), count, len(known)):
        part = made[start : start + len(known)]
        light = rng.uniform(0.7, 1.3, (len(part), 1))
        noise = rng.normal(0.0, 8.0, part.shape)
        part[:] = np.clip(known[: len(part)] * light + noise, 0, 255)
    return made


def peer(
    store: NDArray[np.uint8], views: NDArray[np.uint8], count: int
) -> Callable[[], tuple[Any, Any]] | None:
    """Search of faiss for the same; None where it is not installed."""
    try:
        import faiss  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        return None
    faiss.omp_set_num_threads(1)
    index = faiss.IndexFlat(store.shape[1], faiss.METRIC_L1)
    index.add(store.astype(np.float32))
    asked = views.astype(np.float32)
    return lambda: index.search(asked, count)


def check(ours: Nearest, distances: Any, rows: Any, limit: int) -> None:
    """Both found landmarks at the same distances, as far as they are recognised at all."""
    found = ours.rows >= 0
    same = (distances < limit) == found
    if not (same.all() and np.array_equal(distances[found].astype(np.int64), ours.sads[found])):
        raise SystemExit(f"the answers differ: {rows[~same]}")
