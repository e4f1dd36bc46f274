"""The parts of the study of Giovannangeli et al. that need no log."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from fpnav.experiments.giovannangeli import STUDY
from fpnav.experiments.giovannangeli.bounded import BUDGETS, over_budgets, seen_again
from fpnav.experiments.giovannangeli.carried import BETWEEN, JUMPS, jumping
from fpnav.experiments.giovannangeli.lines import (
    FOCUS,
    SMALL_STEP_M,
    afternoon,
    line_job,
    other_day,
)
from fpnav.experiments.giovannangeli.occlusion import DISC_RAD, PRESET, RESERVE, seen
from fpnav.experiments.giovannangeli.text import (
    DRIFT_DEG,
    PAN_S,
    PAN_STEP_M,
    STILL_S,
    STILL_STEP_M,
    afternoon_panned,
    drifted,
)
from fpnav.experiments.giovannangeli.trips import success, within
from fpnav.store.tables import ACTION, REFERENCE, Ragged, SignatureTable
from fpnav.systems.placecell.assembly import RECORD
from fpnav.systems.placecell.extract import VIEW
from fpnav.values import Metric


def table(x_m: np.ndarray[Any, Any]) -> SignatureTable:
    references = np.zeros(len(x_m), REFERENCE)
    references["truth"][:, 0] = x_m
    return SignatureTable(
        references,
        np.zeros(len(x_m), "i4"),
        {"none": Ragged.of([np.zeros(0, "i4")] * len(x_m), np.dtype("i4"))},
    )


def test_every_claim_is_about_an_experiment_with_a_title() -> None:
    assert set(STUDY.heading.titles) == set(STUDY.experiments)
    assert {claim.experiment for claim in STUDY.claims} <= set(STUDY.experiments)
    assert {f"B{k}" for k in range(1, 8)} <= set(STUDY.experiments)


def test_jumps_go_to_another_place_and_stay_there_a_while() -> None:
    places = [SimpleNamespace(id=k + 3, members=(k,)) for k in range(4)]
    built = SimpleNamespace(
        topomap=SimpleNamespace(places=places), signatures=table(np.arange(4.0))
    )
    run = SimpleNamespace(table=table(np.linspace(0.0, 3.0, 120)))
    rows, first, nearest = jumping(cast(Any, built), cast(Any, run), seed=1)
    x = run.table.references["truth"][rows, 0]
    assert len(first) == len(nearest) == JUMPS
    assert len(rows) == BETWEEN * (JUMPS + 1)
    assert np.round(x[first]).astype(int).tolist() == (nearest - 3).tolist()
    assert (np.abs(x[first] - x[first - 1]) > 1.0).all()
    assert np.abs(x[first] - np.round(x[first])).max() <= 0.4 + 1e-9


def test_the_drift_of_the_azimuth_grows_and_goes_again() -> None:
    run = cast(Any, SimpleNamespace(header={}, table=table(np.arange(11.0)), system=None))
    off = np.rad2deg(drifted(run).table.references["heading_rad"])
    assert off[[0, 5, 10]] == pytest.approx([0.0, DRIFT_DEG, 0.0], abs=1e-9)
    assert (run.table.references["heading_rad"] == 0.0).all()


def test_small_runs_take_longer_steps() -> None:
    step = {
        small: line_job(
            cast(Any, SimpleNamespace(small=small)), "room", 1, 1, {}
        ).rig.capture.step_m
        for small in (False, True)
    }
    assert step == {False: 0.0, True: SMALL_STEP_M["room"]}


def test_decisions_without_a_direction_are_not_within_45_degrees() -> None:
    actions = np.zeros(4, ACTION)
    actions["wanted_rad"] = [0.0, 0.7, 0.9, math.nan]
    found = within("x", actions, np.zeros(4))
    assert (found.n, found.of) == (2, 4)
    assert success("y", np.array([True, False])).value == 0.5


def test_the_second_drive_of_an_afternoon_meets_no_place_when_it_was_learned() -> None:
    learn, again = afternoon(cast(Any, SimpleNamespace(small=False)), 1)
    first, second = (job.setting.make() for job in (learn, again))
    assert first.daylight == second.daylight
    starts = [world.routes["line"].points[0][0] for world in (first, second)]
    speeds = [job.rig.capture.speed_mps or first.routes["line"].speed_mps for job in (learn, again)]
    assert starts[1] < starts[0]
    places = np.arange(0.0, 25.1, 5.0)
    met = [
        (places + starts[0] - start) / speed for start, speed in zip(starts, speeds, strict=True)
    ]
    assert np.abs(met[0] - met[1]).min() >= 1.0


def test_the_other_day_has_other_light_and_the_same_things() -> None:
    shop = cast(Any, SimpleNamespace(small=False))
    again, later = (job.setting.make() for job in (afternoon(shop, 1)[1], other_day(shop, 1)))
    assert again.daylight != later.daylight
    assert again.routes == later.routes
    assert len(again.faces) == len(later.faces)


def test_static_panoramas_are_taken_on_the_spot_and_noise_is_another_one() -> None:
    shop = cast(Any, SimpleNamespace(small=False))
    still, going = (
        afternoon_panned(shop, 1, period, step)[1].rig
        for period, step in ((STILL_S, STILL_STEP_M), (PAN_S, PAN_STEP_M))
    )
    swept = [
        rig.pan.period_s * (rig.pan.views - 1) * rig.capture.speed_mps for rig in (still, going)
    ]
    assert swept[0] < 0.002 < 0.05 < swept[1]
    assert still.capture.step_m != going.capture.step_m  # noise goes by the number of the data set


def test_half_of_the_view_is_hidden_from_the_middle_of_the_drive_on() -> None:
    views = np.zeros(RESERVE, VIEW)
    views["bearing_rad"] = (2.4 * np.arange(RESERVE)) % (2 * math.pi) - math.pi
    pixels = np.repeat(np.arange(RESERVE) % 256, PRESET.pixels).astype(np.uint8)
    run = cast(Any, SimpleNamespace(header={}, table=seen_table(views, pixels, 4), system=None))
    free, dark = seen(run).table, seen(run, hidden=True).table
    for row in range(4):
        assert len(free.parts["views"][row]) == FOCUS
        hidden = dark.parts["views"][row]["bearing_rad"]
        clear = (hidden < -DISC_RAD) & (hidden > DISC_RAD - math.pi)
        assert clear.all() == (row >= 2)
    last = dark.parts["views"][3]
    assert dark.records["views"].tolist()[:3] == [FOCUS, FOCUS, len(last)]
    kept = dark.parts["pixels"][3].reshape(-1, PRESET.pixels)[:, 0]
    own = np.flatnonzero(np.isin(views["bearing_rad"], last["bearing_rad"]))
    assert kept.tolist() == (own % 256).tolist()


def seen_table(
    views: np.ndarray[Any, Any], pixels: np.ndarray[Any, Any], count: int
) -> SignatureTable:
    parts = {
        "views": Ragged.of([views] * count, VIEW),
        "pixels": Ragged.of([pixels] * count, np.dtype(np.uint8)),
    }
    return SignatureTable(np.zeros(count, REFERENCE), np.zeros(count, RECORD), parts)


def test_a_place_sees_the_panoramas_nearest_to_it_again_its_own_first() -> None:
    run = cast(Any, SimpleNamespace(header={}, table=table(np.arange(7.0)), system=None))
    run.table.references["label"][[1, 5]] = [b"place-1", b"place-2"]
    found = seen_again(run).table.references
    assert found["truth"][:, 0].tolist() == [1.0, 5.0, 0.0, 2.0, 3.0, 4.0, 6.0]
    assert found["label"].tolist()[2:] == [b"place-1"] * 3 + [b"place-2"] * 2


def test_the_budgets_of_all_worlds_become_one_picture() -> None:
    names = [{40: "bounded", 0: "plain"}.get(budget, f"of_{budget}") for budget in BUDGETS]
    worlds = [
        {
            metric.name: metric
            for name in names
            for metric in (
                Metric(f"landmarks_{name}", 100.0, 1, 1, "landmarks"),
                Metric(f"nearest_wins_{name}", share, 1, 2),
            )
        }
        for share in (0.5, 0.7)
    ]
    (picture,) = over_budgets(worlds)
    assert picture.draw().alt.endswith("100 landmarks 60 %.")
