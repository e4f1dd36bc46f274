"""What the reproduction of a paper is: experiments, the claims they are measured against, seeds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fpnav.errors import UsageError
from fpnav.experiments.workshop import Workshop
from fpnav.report.study import Claim, Finding, Heading, Illustration
from fpnav.values import Metric

Experiment = Callable[[Workshop, int], "Outcome"]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What one experiment gave in one world: figures of merit, pictures, how it was made."""

    metrics: Sequence[Metric]
    pictures: Sequence[Illustration] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """A paper: how to name it, its experiments in order, and what is claimed of them."""

    heading: Heading
    claims: Sequence[Claim]
    experiments: Mapping[str, Experiment]


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
    findings = []
    for name, experiment in study.experiments.items():
        if only and name not in only:
            continue
        outcomes = {}
        for seed in seeds:
            outcomes[seed] = experiment(workshop, seed)
            advance(1)
        findings += _findings(name, outcomes)
    return findings


def _findings(name: str, outcomes: Mapping[int, Outcome]) -> list[Finding]:
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
    return [Finding(name, None, pooled, (), facts), *single]


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
