"""Bounded memory (P6): how few landmarks a place needs, chosen for what they tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fpnav.evaluation.fields import learned_activity, nearest_wins
from fpnav.execution.stages import take
from fpnav.execution.walk import Run
from fpnav.experiments.giovannangeli.lines import (
    OTHER_DAY,
    afternoon,
    choice,
    fields_on,
    guided_map,
    labelled,
    named,
    other_day,
)
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.report.figures.budgets import Budgets, draw
from fpnav.report.study import Illustration
from fpnav.values import Metric

BUDGETS = (10, 20, 40, 60, 90, 0)
"""Landmarks kept of the 120 of a place; 0 = all."""

KEPT = 40
"""The budget that is held against a plain run: a third."""


def bounded(shop: Workshop, seed: int) -> Outcome:
    """P6: accuracy and memory over the number of landmarks a place keeps."""
    learn, test = (shop.log(job) for job in afternoon(shop, seed))
    asked = shop.run(test, choice("fig4c"))
    later = shop.run(shop.log(other_day(shop, seed)), choice("fig4c"))
    metrics: list[Metric] = []
    for budget in BUDGETS:
        run = seen_again(shop.run(learn, choice("fig4c", budget=budget)))
        made = guided_map(run, learn)
        fields, memory = fields_on(made, asked), made[1].memory
        told = {KEPT: "bounded", 0: "plain"}.get(budget, f"of_{budget}")
        if budget in (KEPT, 0):
            won = nearest_wins(fields_on(made, later))
            metrics.append(named(won, f"nearest_wins_{told}{OTHER_DAY}"))
        held = sum(memory[name].nbytes for name in ("pixels", "triplets", "cells"))
        count = len(np.unique(memory["triplets"]["landmark"]))
        metrics += [
            named(nearest_wins(fields), f"nearest_wins_{told}"),
            named(learned_activity(fields), f"learned_activity_{told}"),
            Metric(f"landmarks_{told}", float(count), 1, 1, "landmarks"),
            Metric(f"memory_{told}", held / 1e6, 1, 1, "MB"),
        ]
    facts = {"preset": "fig4c", "budgets": list(BUDGETS)}
    return Outcome(metrics, (), facts, {metric.name: metric for metric in metrics})


def over_budgets(materials: Sequence[dict[str, Metric]]) -> list[Illustration]:
    """The curve of accuracy over memory, one line a world."""
    told = [{KEPT: "bounded", 0: "plain"}.get(budget, f"of_{budget}") for budget in BUDGETS]
    found = Budgets(
        np.array([[world[f"landmarks_{name}"].value for name in told] for world in materials]),
        np.array([[world[f"nearest_wins_{name}"].value for name in told] for world in materials]),
    )
    title = "Accuracy over the landmarks kept"
    caption = "One line a world, the bold one their mean; at the right end all landmarks are kept."
    return [Illustration("budgets", title, caption, lambda: draw(found))]


def seen_again(run: Run) -> Run:
    """Every panorama of a drive labelled with the place nearest to it, founding ones first.

    What a place shows from around where it was learned tells which landmarks come back.
    """
    founding = labelled(run)
    at = founding.table.references["truth"][:, :2]
    here = run.table.references["truth"][:, :2]
    nearest = np.argmin(np.hypot(*(here[:, None] - at).transpose(2, 0, 1)), axis=1)
    founders = np.argmin(np.hypot(*(at[:, None] - here).transpose(2, 0, 1)), axis=1)
    rest = np.setdiff1d(np.arange(len(here)), founders)
    order = np.concatenate([founders, rest])
    references = run.table.references.copy()
    references["label"] = founding.table.references["label"][nearest]
    return Run(run.header, take(replace(run.table, references=references), order), run.system)
