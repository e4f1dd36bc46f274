"""Half of the view hidden (B4, figure 7), the same afternoon and on another day."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fpnav.evaluation.fields import Fields, nearest_wins, occlusion
from fpnav.execution.walk import Run
from fpnav.experiments.giovannangeli.lines import (
    FOCUS,
    OTHER_DAY,
    afternoon,
    choice,
    fields_on,
    guided_map,
    labelled,
    named,
    other_day,
    picture,
)
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.geometry import TAU, angular_distance
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import Ragged
from fpnav.systems.placecell.params import PRESETS
from fpnav.values import Metric

FROM_SHARE, SIDE_RAD, HALF_RAD = 0.5, math.pi / 2, math.pi / 2
"""Share of the drive from which on something hangs over the panorama: its middle on the left, so
far to either side."""

RESERVE = 300
"""Focus points looked for, so that FOCUS are left in the half that is seen."""

PRESET = PRESETS["fig7b"]
DISC_RAD = TAU * PRESET.radius / PRESET.width
"""Radius of a local view: one that touches what is hidden is not seen."""


def occluded(shop: Workshop, seed: int) -> Outcome:
    """B4, figure 7: half of the view hidden from the middle of the line on, eq. 3 and eq. 4."""
    learn, test = (shop.log(job) for job in afternoon(shop, seed))
    metrics: list[Metric] = []
    pictures = []
    for name, rho_l in (("_eq3", 1.0), ("", PRESET.rho_l)):
        chosen = choice("fig7b", focus=RESERVE, rho_l=rho_l)
        made = guided_map(seen(labelled(shop.run(learn, chosen))), learn)
        free, dark = _free_and_dark(made, shop.run(test, chosen))
        metrics += _told(free, dark, name)
        title = "Figure 7b here: eq. 4" if rho_l < 1.0 else "Figure 7a here: eq. 3"
        pictures.append(picture(f"hidden{name}", title, dark, _middle(free)))
    later = _free_and_dark(made, shop.run(shop.log(other_day(shop, seed)), chosen))
    metrics += _told(*later, OTHER_DAY)
    return Outcome(metrics, pictures, {"preset": "fig7b", "focus": FOCUS})


def seen(run: Run, *, hidden: bool = False) -> Run:
    """The FOCUS strongest views of every panorama; where half is hidden, of those clear of it."""
    views, pixels = [], []
    for row, signature in enumerate(run.table):
        own = signature.parts["views"]
        clear = np.ones(len(own), bool)
        if hidden and row >= FROM_SHARE * len(run.table):
            away = angular_distance(own["bearing_rad"], SIDE_RAD)
            clear = away >= HALF_RAD + DISC_RAD
        kept = np.flatnonzero(clear)[:FOCUS]
        views.append(own[kept])
        pixels.append(signature.parts["pixels"].reshape(-1, PRESET.pixels)[kept].ravel())
    records = run.table.records.copy()
    records["views"] = [len(rows) for rows in views]
    parts = {
        "views": Ragged.of(views, run.table.parts["views"].flat.dtype),
        "pixels": Ragged.of(pixels, run.table.parts["pixels"].flat.dtype),
    }
    return Run(run.header, replace(run.table, records=records, parts=parts), run.system)


def _free_and_dark(made: tuple[Header, BuiltMap], run: Run) -> tuple[Fields, Fields]:
    """Fields of a run without and with half of the view hidden."""
    free, dark = (_inner(fields_on(made, seen(run, hidden=half))) for half in (False, True))
    return free, dark


def _told(free: Fields, dark: Fields, ending: str) -> list[Metric]:
    ratio, winner = occlusion(dark, free, _middle(free))
    near = nearest_wins(dark.between(_middle(free), np.inf))
    return [
        named(ratio, f"occlusion_peak_ratio{ending}"),
        named(winner, f"occlusion_winner{ending}"),
        named(near, f"occlusion_nearest_wins{ending}"),
    ]


def _middle(fields: Fields) -> float:
    return float(fields.position_m.mean())


def _inner(fields: Fields) -> Fields:
    """Figure 7 has four places, those between the ends of the line."""
    return Fields(fields.position_m, fields.activity[:, 1:-1], fields.learned_m[1:-1])
