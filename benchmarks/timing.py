"""Fair timing on a shared machine: candidates in turn, medians, ratios of pairs."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable


def in_turn(candidates: dict[str, Callable[[], object]], rounds: int = 5) -> dict[str, float]:
    """Median seconds of each candidate, one warm-up each, then run in turn."""
    for candidate in candidates.values():
        candidate()
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(rounds):
        for name, candidate in candidates.items():
            start = time.perf_counter()
            candidate()
            times[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in times.items()}


def show(medians: dict[str, float], unit: str = "ms") -> None:
    """Print the medians and their ratio to the first."""
    scale = {"ms": 1e3, "s": 1.0}[unit]
    first = next(iter(medians.values()))
    for name, seconds in medians.items():
        print(f"  {name:44s} {seconds * scale:10.2f} {unit}  x {seconds / first:.2f}")
