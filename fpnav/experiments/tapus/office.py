"""The office of the experiments: one building a seed, driven for a map and again to be located.

The mapping run and the test run differ in path, noise, people, light and what was moved; the
building and its rooms are those of the seed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fpnav.evaluation.evaluate import Evaluation
from fpnav.execution.stages import locate_run, take
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.localization.locate import Method
from fpnav.params import Tables
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import Result
from fpnav.values import Metric

MAP, TEST, KIDNAPPED = 1, 2, 3
"""Runs of a building: another day each."""

STEP_M = 0.24
"""Travel between the samples of a test run: more than 1000 on 250 m, as in the paper."""

LOOPS = 5

Mapped = tuple[Header, BuiltMap]


def choice(preset: str = "paper", **changes: Any) -> SystemChoice:
    """The system with a preset's parameters and changes to them."""
    return SystemChoice("fingerprint", preset, {"fingerprint": changes})


def mapping_log(shop: Workshop, seed: int) -> Path:
    """75 m with a data set every 0.15 m."""
    return _log(shop, "map", seed, MAP, {})


def test_log(shop: Workshop, seed: int) -> Path:
    """250 m on another path through the rooms of the map."""
    return _log(shop, "test", seed, TEST, {"step_m": STEP_M})


def kidnapped_log(shop: Workshop, seed: int) -> Path:
    """The robot lifted and set down elsewhere ten times in 150 m."""
    length_m, kidnaps = (20.0, 2) if shop.small else (150.0, 10)
    return _log(
        shop, "test", seed, KIDNAPPED, {"step_m": STEP_M, "length_m": length_m, "kidnaps": kidnaps}
    )


def loop_log(shop: Workshop, seed: int) -> Path:
    """A way that comes back to where it was; another one of five for each seed."""
    return _log(shop, f"loop-{1 + (seed - 1) % LOOPS}", seed, MAP, {"step_m": 0.2})


def _log(shop: Workshop, route: str, seed: int, run: int, capture: dict[str, Any]) -> Path:
    tables: dict[str, dict[str, Any]] = {"capture": capture}
    if shop.small:
        tables = {"world": {"map_m": 30.0, "test_m": 30.0}, "capture": {**capture, "step_m": 0.3}}
    return shop.log(job_of("office", route, seed, run, sensors=["panorama", "scan"], tables=tables))


def located(
    shop: Workshop,
    log: Path,
    mapped: Mapped,
    chosen: SystemChoice,
    method: Method,
    *,
    every: int = 1,
    tables: Tables | None = None,
) -> Result:
    """A run located on a map; ``every`` n-th signature of it is asked."""
    run = thinned(shop.run(log, chosen), every)
    header, built = mapped
    return locate_run(
        run.system,
        header,
        built,
        run,
        method=method,
        tables=tables or {},
        advance=lambda done: None,
    )


def thinned(run: Run, every: int) -> Run:
    """Every n-th signature of a run."""
    rows = list(range(0, len(run.table), every))
    return run if every == 1 else Run(run.header, take(run.table, rows), run.system)


def figures(found: Evaluation, *names: str, suffix: str = "") -> list[Metric]:
    """The named figures that could be measured, renamed by a suffix."""
    return [
        renamed(found.metrics[name], f"{name}{suffix}") for name in names if name in found.metrics
    ]


def renamed(metric: Metric, name: str) -> Metric:
    """The same figure under another name."""
    return Metric(name, metric.value, metric.n, metric.of, metric.unit, metric.low, metric.high)
