"""What the paper says beside its figures: a street on several days, things moved, three places,
drifting azimuths, partial views (P1 to P5); memory that is bounded (P6); the silent points (S)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from msgspec import structs

from fpnav.evaluation.fields import Fields, half_width, learned_activity, nearest_wins, peak_error
from fpnav.evaluation.guidance import ends_home, follows, taught_along
from fpnav.execution.walk import Run
from fpnav.experiments.giovannangeli.lines import (
    LEARN,
    SAME_DAY,
    SAME_LAMPS,
    TEST,
    choice,
    line,
    line_job,
    line_of,
    named,
)
from fpnav.experiments.giovannangeli.trips import (
    MORNING,
    PLACES_EVERY_M,
    drive,
    few,
    home_trips,
    success,
    taught_ring,
    taught_way,
    within,
)
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.params import Tables
from fpnav.values import Metric

THREE = ("place-1", "place-4", "place-6")
"""Places at 0, 135 and 225 degrees about the goal: three pairs make a basin."""

THREE_S = 30.0
"""Time of a trip: between few places the way home is roundabout."""

INNER = tuple(f"place-{k}" for k in range(2, 6))
"""Places before and after which the camera has panned all the way."""

DRIFT_DEG = 15.0
"""Largest error of the azimuth that builds up along the line."""

BUDGET = 20
"""Landmarks kept of the sixty of a place."""

SILENT: dict[str, tuple[Any, ...]] = {
    "focus": (15, 30, 60),
    "rho_az": (0.15, 0.6),
    "dog_size": (8, 22),
    "rt": (0.7, 0.85),
}
"""Values beside the preset's of what the paper leaves open, one changed at a time."""


def street(shop: Workshop, seed: int) -> Outcome:
    """P1: an S-shaped street learned once, driven the same hour two days on and one morning."""
    length: Tables = {"capture": {"length_m": 15.0}} if shop.small else {}
    learn = job_of("suburb", "street", seed, LEARN, tables=length)
    leader = taught_way(shop, learn, choice("fig8", spacing_m=PLACES_EVERY_M))
    closed, right, of = [], 0, 0
    for run in (TEST, MORNING):
        driven, way = drive(leader, job_of("suburb", "street", seed, run, tables=length))
        closed.append(bool(follows(driven, way)[0]))
        near = within("", driven, taught_along(driven, way))
        right, of = right + near.n, of + near.of
    metrics = [
        success("route_closed", np.array(closed)),
        Metric("action_within_45", right / max(1, of), right, of),
    ]
    return Outcome(metrics, (), {"preset": "fig8", "days": 2})


def moved(shop: Workshop, seed: int) -> Outcome:
    """P2: half of what can be moved in the room is added, removed or elsewhere at the test."""
    changed: Tables = {**SAME_LAMPS, "world": {**SAME_LAMPS["world"], "moved_share": 0.5}}
    learn = shop.log(line_job(shop, "room", seed, LEARN, SAME_LAMPS, step_m=0.2))
    same = line(
        shop, learn, shop.log(line_job(shop, "room", seed, TEST, SAME_LAMPS)), choice("fig3b")
    )
    other = line(
        shop, learn, shop.log(line_job(shop, "room", seed, TEST, changed)), choice("fig3b")
    )
    kept = other.activity.max(axis=0) / np.maximum(same.activity.max(axis=0), 1e-9)
    metrics = [
        nearest_wins(other),
        Metric("peaks_kept", float(kept.mean()), len(kept), len(kept)),
    ]
    return Outcome(metrics, (), {"preset": "fig3b", "moved_share": 0.5})


def three_pairs(shop: Workshop, seed: int) -> Outcome:
    """P3: three place-action pairs about the goal."""
    leader, goal = taught_ring(shop, seed, THREE)
    steady = replace(leader, params=structs.replace(leader.params, blend=0.0))
    home = home_trips(shop, seed, steady, goal, few(shop, 8), THREE_S)
    return Outcome([success("homing_success", ends_home(home, goal))], (), {"places": THREE})


def drifting(shop: Workshop, seed: int) -> Outcome:
    """P4: ranks of the cells while the azimuth drifts along the line."""
    learn = shop.log(line_job(shop, "room", seed, LEARN, SAME_LAMPS, step_m=0.2))
    test = shop.log(line_job(shop, "room", seed, TEST, SAME_LAMPS))
    true = line(shop, learn, test, choice("fig3b"))
    off = line_of(shop, learn, drifted(shop.run(test, choice("fig3b"))), choice("fig3b"))
    same = true.winner == off.winner
    active = true.active & off.active
    metrics = [
        Metric(
            "winner_kept", float(same[active].mean()), int(same[active].sum()), int(active.sum())
        ),
        nearest_wins(off),
    ]
    return Outcome(metrics, (), {"preset": "fig3b", "drift_deg": DRIFT_DEG})


def partial_views(shop: Workshop, seed: int) -> Outcome:
    """P5: fields from nine partial views that stream beside those of whole panoramas."""
    fields = []
    whole = {"images": 1, "streaming": False, "qmax": 0}
    changes: tuple[tuple[str, dict[str, Any]], ...] = (("pan", {}), ("panorama", whole))
    for sensor, change in changes:
        learn, test = (
            shop.log(line_job(shop, "outdoor", seed, run, SAME_DAY, 1.0, [sensor]))
            for run in (LEARN, TEST)
        )
        fields.append(line(shop, learn, test, choice("fig8", focus=54, **change), INNER))
    at = fields[1].position_m
    streamed = np.column_stack(
        [np.interp(at, fields[0].position_m, column) for column in fields[0].activity.T]
    )
    rho = float(np.corrcoef(streamed.ravel(), fields[1].activity.ravel())[0, 1])
    return Outcome([Metric("field_correlation", rho, len(at), len(at))], (), {"preset": "fig8"})


def bounded(shop: Workshop, seed: int) -> Outcome:
    """P6: a third of the landmarks, chosen for what they tell apart, beside all."""
    learn = shop.log(line_job(shop, "outdoor", seed, LEARN, SAME_DAY, step_m=1.0))
    test = shop.log(line_job(shop, "outdoor", seed, TEST, SAME_DAY))
    plain = line(shop, learn, test, choice("fig4c"))
    few_kept = line(shop, learn, test, choice("fig4c", budget=BUDGET))
    metrics = [
        named(nearest_wins(few_kept), "nearest_wins_bounded"),
        named(nearest_wins(plain), "nearest_wins_plain"),
        named(learned_activity(few_kept), "learned_activity_bounded"),
    ]
    return Outcome(metrics, (), {"preset": "fig4c", "budget": BUDGET})


def silent_points(shop: Workshop, seed: int) -> Outcome:
    """S: figure 3 with other values of what the paper does not say."""
    learn = shop.log(line_job(shop, "room", seed, LEARN, SAME_LAMPS, step_m=0.2))
    test = shop.log(line_job(shop, "room", seed, TEST, SAME_LAMPS))
    metrics: list[Metric] = []
    for name, values in SILENT.items():
        for value in values[:1] if shop.small else values:
            metrics += _told(line(shop, learn, test, choice("fig3b", **{name: value})), name, value)
    metrics += _told(line(shop, learn, test, choice("fig3b")), "preset", "")
    return Outcome(metrics, (), {"preset": "fig3b", **{k: list(v) for k, v in SILENT.items()}})


def _told(fields: Fields, name: str, value: Any) -> list[Metric]:
    ending = f"{name}_{value}".rstrip("_")
    width = half_width(fields)
    return [
        named(nearest_wins(fields), f"nearest_wins_{ending}"),
        named(peak_error(fields), f"peak_error_{ending}"),
        Metric(f"half_width_{ending}", width, len(fields.learned_m), len(fields.learned_m), "m"),
    ]


def drifted(run: Run) -> Run:
    """The run with an azimuth that drifts to DRIFT_DEG and back along the way."""
    rows = run.table.references.copy()
    share = np.linspace(0.0, 1.0, len(rows))
    rows["heading_rad"] += math.radians(DRIFT_DEG) * np.sin(math.pi * share)
    return Run(run.header, replace(run.table, references=rows), run.system)
