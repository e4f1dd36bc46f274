"""What the reproduction of a paper is: experiments, the claims they are measured against, seeds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from fpnav.errors import UsageError
from fpnav.execution.spread import Here
from fpnav.experiments.workshop import Workshop
from fpnav.report.study import Claim, Finding, Heading, Illustration
from fpnav.values import Metric

Experiment = Callable[[Workshop, int], "Outcome"]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What one experiment gave in one world: figures of merit, pictures, how it was made.

    ``material`` : what a picture over all worlds is drawn from
    """

    metrics: Sequence[Metric]
    pictures: Sequence[Illustration] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    material: Any = None


Together = Callable[[Sequence[Any]], Sequence[Illustration]]
"""The materials of all worlds to pictures over them."""


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """A paper: how to name it, its experiments in order, and what is claimed of them.

    ``together`` : pictures over all worlds of an experiment; ``most`` : worlds that a long
    experiment is run in at most, the first of those asked for; ``long`` : experiments begun first,
    in that order, so that at the end no worker waits for another
    """

    heading: Heading
    claims: Sequence[Claim]
    experiments: Mapping[str, Experiment]
    together: Mapping[str, Together] = field(default_factory=dict)
    most: Mapping[str, int] = field(default_factory=dict)
    long: Sequence[str] = ()


def conduct(
    study: Study,
    workshop: Workshop,
    seeds: Sequence[int],
    only: Sequence[str] = (),
    advance: Callable[[int], None] = lambda done: None,
) -> list[Finding]:
    """All experiments, or those named, for every seed; each once more over all seeds.

    Raises
    ------
    UsageError
        An experiment is named that the study does not have.
    """
    unknown = [name for name in only if name not in study.experiments]
    if unknown:
        known = ", ".join(study.experiments)
        raise UsageError(f"{study.heading.name} has no experiment {unknown[0]!r}; it has {known}")
    worlds = {
        name: seeds[: study.most.get(name, len(seeds))]
        for name in study.experiments
        if not only or name in only
    }
    outcomes: dict[tuple[str, int], Outcome] = {}
    for task, outcome in _outcomes(study, workshop, worlds):
        outcomes[task] = outcome
        advance(1)
    findings = []
    for name, own in worlds.items():
        advance(len(seeds) - len(own))
        found = {seed: outcomes[name, seed] for seed in own}
        pictures = study.together.get(name, _none)([o.material for o in found.values()])
        findings += _findings(name, found, pictures)
    return findings


def _outcomes(
    study: Study, workshop: Workshop, worlds: Mapping[str, Sequence[int]]
) -> Iterator[tuple[tuple[str, int], Outcome]]:
    """Outcomes by experiment and world, long experiments first: in several worlds all side by
    side, without a pause; in one world each by itself, its own work spread instead."""
    names = [name for name in dict.fromkeys([*study.long, *worlds]) if name in worlds]
    tasks = [(name, seed) for name in names for seed in worlds[name]]
    if len({seed for _, seed in tasks}) < 2:
        for name, seed in tasks:
            yield (name, seed), study.experiments[name](workshop, seed)
        return
    alone = replace(workshop, spread=Here())
    work = [(study.experiments[name], seed) for name, seed in tasks]
    made = workshop.spread.ordered(partial(_in_world, alone), work)
    yield from zip(tasks, made, strict=True)


def _in_world(workshop: Workshop, task: tuple[Experiment, int]) -> Outcome:
    """One experiment in one world: the unit of work that is spread."""
    experiment, seed = task
    return experiment(workshop, seed)


def _none(materials: Sequence[Any]) -> Sequence[Illustration]:
    return ()


def _findings(
    name: str, outcomes: Mapping[int, Outcome], pictures: Sequence[Illustration]
) -> list[Finding]:
    single = [
        Finding(name, seed, _by_name(outcome.metrics), outcome.pictures, outcome.facts)
        for seed, outcome in outcomes.items()
    ]
    names = dict.fromkeys(metric for finding in single for metric in finding.metrics)
    pooled = {
        metric: over_seeds([f.metrics[metric] for f in single if metric in f.metrics])
        for metric in names
    }
    facts = {"seeds": list(outcomes)}
    return [Finding(name, None, pooled, pictures, facts), *single]


def _by_name(metrics: Sequence[Metric]) -> dict[str, Metric]:
    return {metric.name: metric for metric in metrics}


def over_seeds(metrics: Sequence[Metric]) -> Metric:
    """One figure over several worlds: the mean of theirs, counts added.

    ``low`` and ``high`` : 95 % of the means of worlds drawn with replacement, all draws counted.
    """
    values = np.array([metric.value for metric in metrics])
    n, of = sum(metric.n for metric in metrics), sum(metric.of for metric in metrics)
    low = high = math.nan
    if len(values) > 1:
        low, high = _interval(values)
    return Metric(metrics[0].name, float(values.mean()), n, of, metrics[0].unit, low, high)


MOST = 6
"""Worlds up to which every draw with replacement is counted; above, a fixed sample of them."""


def _interval(values: np.ndarray[Any, np.dtype[np.float64]]) -> tuple[float, float]:
    count = len(values)
    if count <= MOST:
        draws = np.array(list(itertools.product(range(count), repeat=count)))
    else:
        draws = np.random.default_rng(0).integers(0, count, (20_000, count))
    low, high = np.quantile(values[draws].mean(axis=1), [0.025, 0.975])
    return float(low), float(high)
