"""What the paper says beside its figures: a street on several days, things moved, three places,
drifting azimuths, partial views (P1 to P5); the silent points (S)."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs

from fpnav.evaluation.fields import Fields, half_width, nearest_wins, peak_error
from fpnav.evaluation.guidance import ends_from, ends_home, follows, taught_along
from fpnav.execution.stages import make_map
from fpnav.execution.walk import Run
from fpnav.experiments.giovannangeli.lines import (
    LEARN,
    OTHER_DAY,
    SAME_LAMPS,
    TEST,
    afternoon,
    choice,
    fields_on,
    guided_map,
    labelled,
    line,
    line_job,
    line_of,
    named,
    picture,
)
from fpnav.experiments.giovannangeli.trips import (
    MORNING,
    OTHER_LIGHT,
    drive,
    ended,
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
from fpnav.sim.record import Job
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.values import Metric

THREE = ("place-1", "place-4", "place-6")
"""Places at 0, 135 and 225 degrees about the goal: three pairs make a basin."""

THREE_S = 30.0
"""Time of a trip: between few places the way home is roundabout."""

DRIFT_DEG = 15.0
"""Largest error of the azimuth that builds up along the line."""

VIGILANCE = (0.4, 0.5, 0.6)
"""Activities below which a new place is learned; the preset's is 0.5."""

PAN_MPS, PAN_S, PAN_STEP_M = 100.0 / (20.0 * 60.0), 0.12, 0.25
"""Speed while the camera pans, that of figure 8: 100 m in 20 minutes; time between two views, and
way between two sweeps."""

STILL_S, STILL_STEP_M = 0.002, 0.2
"""For static panoramas all views are taken on the spot: within 2 mm."""

STATIC = choice("fig8", streaming=False, qmax=2)

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
    leader = taught_way(shop, learn, choice("fig8", **OTHER_LIGHT))
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
    return Outcome(metrics, (), {"preset": "fig8", **OTHER_LIGHT, "days": 2})


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
    metrics = [success("homing_success", ends_home(home, goal)), *ended(ends_from(home, goal))]
    return Outcome(metrics, (), {"places": THREE})


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
    """P5: fields of one map while the robot goes on and nine partial views stream, beside those of
    static panoramas of the same nine views. Both hold what the last two panoramas showed.
    """
    learn = shop.log(afternoon_panned(shop, seed, STILL_S, STILL_STEP_M)[0])
    made = guided_map(labelled(shop.run(learn, STATIC)), learn)
    streamed, panorama = _going_and_still(shop, seed, made, LEARN)
    later = _going_and_still(shop, seed, made, TEST)
    metrics = [
        _likeness(streamed, panorama),
        named(nearest_wins(streamed), "nearest_wins_streamed"),
        named(nearest_wins(panorama), "nearest_wins_panorama"),
        named(_likeness(*later), f"field_correlation{OTHER_DAY}"),
        named(nearest_wins(later[0]), f"nearest_wins_streamed{OTHER_DAY}"),
    ]
    pictures = [
        picture("streamed", "Fields of partial views that stream", streamed),
        picture("panorama", "Fields of static panoramas", panorama),
    ]
    return Outcome(metrics, pictures, {"preset": "fig8"})


def _going_and_still(
    shop: Workshop, seed: int, made: tuple[Header, BuiltMap], run: int
) -> tuple[Fields, Fields]:
    """Fields of a map on a run's day: of views that stream, and of static panoramas."""
    header, built = made
    still = shop.log(afternoon_panned(shop, seed, STILL_S, STILL_STEP_M, run)[1])
    going = shop.log(afternoon_panned(shop, seed, PAN_S, PAN_STEP_M, run)[1])
    asked = shop.run(going, choice("fig8"))
    streaming = {**header, "params": asked.header["params"]}
    return (
        _after_first(fields_on((streaming, built), asked)),
        _after_first(fields_on(made, shop.run(still, STATIC))),
    )


def _likeness(fields: Fields, other: Fields) -> Metric:
    """Correlation of activities at the same positions, those of the other between its samples."""
    at = fields.position_m
    beside = [np.interp(at, other.position_m, column) for column in other.activity.T]
    rho = float(np.corrcoef(fields.activity.T.ravel(), np.ravel(beside))[0, 1])
    return Metric("field_correlation", rho, len(at), len(at))


def afternoon_panned(
    shop: Workshop, seed: int, period_s: float, step_m: float, run: int = LEARN
) -> tuple[Job, Job]:
    """The two drives of the line with the panning camera, ``period_s`` between two views."""
    rig: Tables = {"pan": {"period_s": period_s}}
    return afternoon(shop, seed, "pan", speed_mps=PAN_MPS, step_m=step_m, rig=rig, run=run)


def _after_first(fields: Fields) -> Fields:
    """From the first to the last place: the camera has panned all the way by then."""
    return fields.between(0.0, float(fields.learned_m[-1]))


def silent_points(shop: Workshop, seed: int) -> Outcome:
    """S: figure 3 with other values of what the paper does not say."""
    learn = shop.log(line_job(shop, "room", seed, LEARN, SAME_LAMPS, step_m=0.2))
    test = shop.log(line_job(shop, "room", seed, TEST, SAME_LAMPS))
    metrics: list[Metric] = []
    for name, values in SILENT.items():
        for value in values[:1] if shop.small else values:
            metrics += _told(line(shop, learn, test, choice("fig3b", **{name: value})), name, value)
    metrics += _told(line(shop, learn, test, choice("fig3b")), "preset", "")
    for value in VIGILANCE[:1] if shop.small else VIGILANCE:
        metrics += _by_vigilance(shop, learn, test, value)
    tried = {**SILENT, "vigilance": VIGILANCE}
    return Outcome(metrics, (), {"preset": "fig3b", **{k: list(v) for k, v in tried.items()}})


def _by_vigilance(shop: Workshop, learn: Path, test: Path, value: float) -> list[Metric]:
    """Places the robot learns by itself on the way, and how well they are told apart."""
    chosen = choice("fig3b", vigilance=value)
    made = make_map(
        shop.run(learn, chosen),
        [learn],
        guided=False,
        close_loops=False,
        advance=lambda done: None,
    )
    count = len(made[1].topomap.places)
    fields = fields_on(made, shop.run(test, chosen))
    ending = f"vigilance_{value}"
    return [
        Metric(f"places_{ending}", float(count), 1, 1, "places"),
        *_told(fields, "vigilance", value),
    ]


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
