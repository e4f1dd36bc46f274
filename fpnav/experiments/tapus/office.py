"""The office of the experiments: one building a seed, driven for a map and again to be located.

The mapping run and the test run differ in path, noise, people, light and what was moved; the
building and its rooms are those of the seed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.evaluate import Evaluation, evaluate
from fpnav.execution.stages import locate_by, recall_run, spots_along, take
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.localization.locate import Method
from fpnav.localization.spots import Spots
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import SignatureTable
from fpnav.systems.base import Recall
from fpnav.values import Metric

MAP, TEST = 1, 2
"""Runs of a building: another day each."""

SAMPLES = 1010
"""Samples of the test run that are asked, evenly along it: more than 1000, as in the paper."""

JUMPS = 10
"""Times the robot is set down elsewhere on the kidnapped run."""

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
    return _log(shop, "test", seed, TEST, {})


def loop_log(shop: Workshop, seed: int) -> Path:
    """A way that comes back to where it was; another one of five for each seed."""
    return _log(shop, f"loop-{1 + (seed - 1) % LOOPS}", seed, MAP, {"step_m": 0.2})


def _log(shop: Workshop, route: str, seed: int, run: int, capture: dict[str, Any]) -> Path:
    tables: dict[str, dict[str, Any]] = {"capture": capture} if capture else {}
    if shop.small:
        tables = {"world": {"map_m": 30.0, "test_m": 30.0}, "capture": {"step_m": 0.3}}
    return shop.log(job_of("office", route, seed, run, tables=tables))


def asked(shop: Workshop, seed: int, chosen: SystemChoice, samples: int = SAMPLES) -> Run:
    """The test run as it is located: so many samples, evenly along it."""
    return sampled(shop.run(test_log(shop, seed), chosen), samples)


def sampled(run: Run, samples: int) -> Run:
    """So many signatures of a run, evenly along it; all where there are fewer."""
    count = len(run.table)
    rows = np.unique(np.linspace(0, count - 1, min(samples, count)).round().astype(np.int64))
    return Run(run.header, take(run.table, rows), run.system)


def kidnapped(run: Run, jumps: int) -> tuple[Run, NDArray[np.int64]]:
    """The run cut into stretches that are driven in another order: a jump at every seam.

    The odometry does not notice; the path counts on. Also the rows of the run in their new order.
    """
    parts = np.array_split(np.arange(len(run.table)), jumps + 1)
    order = [*range(0, len(parts), 2), *range(1, len(parts), 2)]
    rows = np.concatenate([parts[number] for number in order])
    table = take(run.table, rows)
    steps = np.diff(table.references["travelled_m"], prepend=table.references["travelled_m"][0])
    steps[np.cumsum([len(parts[number]) for number in order])[:-1]] = 0.0
    references = table.references.copy()
    references["travelled_m"] = np.cumsum(steps)
    moved = SignatureTable(references, table.records, table.parts)
    return Run(run.header, moved, run.system), rows


@dataclass(frozen=True, eq=False)
class Drive:
    """The test run of a building on the map of the mapping run, every sample matched once."""

    run: Run
    mapped: Mapped
    recall: Recall

    @cached_property
    def spots(self) -> Spots | None:
        """How like each place the views along the mapping path are."""
        return spots_along(self.run.system, self.mapped[1])

    def located(self, *methods: Method) -> list[Evaluation]:
        """The run located in one or several ways, and measured."""
        spots = self.spots if set(methods) - {Method.MATCH} else None
        return located(self.run, self.mapped, *methods, recall=self.recall, spots=spots)

    def filtered(self, run: Run, recall: Recall) -> Evaluation:
        """A changed run of the same queries located by filter."""
        return located(run, self.mapped, Method.FILTER, recall=recall, spots=self.spots)[0]

    def set_down(self, jumps: int) -> Evaluation:
        """The run with jumps in it, located by filter."""
        moved, rows = kidnapped(self.run, jumps)
        known = self.recall
        recall = Recall(known.places[rows], known.scores[rows], known.headings_rad[rows])
        return self.filtered(moved, recall)

    def without_sight(self, run: Run, rows: NDArray[np.bool_]) -> Evaluation:
        """A run in whose given rows nothing is seen, located by filter."""
        one = take(run.table, np.flatnonzero(rows)[:1])
        blind = recall_run(run.system, self.mapped[1], one, lambda done: None)
        known, unlit = self.recall, rows[:, None]
        recall = Recall(
            np.where(unlit, blind.places, known.places),
            np.where(unlit, blind.scores, known.scores),
            np.where(unlit, blind.headings_rad, known.headings_rad),
        )
        return self.filtered(run, recall)


@cache
def drive(shop: Workshop, seed: int, preset: str) -> Drive:
    """The test run of a building with a preset; kept, since several experiments ask it."""
    chosen = choice(preset)
    mapped = shop.map(mapping_log(shop, seed), chosen)
    run = asked(shop, seed, chosen)
    recall = recall_run(run.system, mapped[1], run.table, lambda done: None)
    return Drive(run, mapped, recall)


def located(
    run: Run,
    mapped: Mapped,
    *methods: Method,
    recall: Recall | None = None,
    spots: Spots | None = None,
) -> list[Evaluation]:
    """A run located on a map in one or several ways, and measured."""
    header, built = mapped
    results = locate_by(run.system, header, built, run, methods=methods, recall=recall, spots=spots)
    return [evaluate(result) for result in results]


def figures(found: Evaluation, *names: str, suffix: str = "") -> list[Metric]:
    """The named figures that could be measured, renamed by a suffix."""
    return [
        renamed(found.metrics[name], f"{name}{suffix}") for name in names if name in found.metrics
    ]


def renamed(metric: Metric, name: str) -> Metric:
    """The same figure under another name."""
    return Metric(name, metric.value, metric.n, metric.of, metric.unit, metric.low, metric.high)
