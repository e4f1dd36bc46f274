"""Place fields along a line: figures 3 and 4, and how fields grow with the world."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fpnav.evaluation.fields import (
    FIELD_SHARE,
    Fields,
    field_slope,
    fields_of,
    half_width_ratio,
    learned_activity,
    nearest_wins,
    peak_error,
    roughness_ratio,
    silent,
    widths,
)
from fpnav.execution.stages import locate_run, make_map, take
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.localization.locate import Method
from fpnav.params import NO_TABLES, Tables
from fpnav.report.figures import fields as drawing
from fpnav.report.study import Illustration
from fpnav.sim.record import Job
from fpnav.store.header import Header
from fpnav.store.maps import BuiltMap
from fpnav.systems.placecell.params import PRESETS
from fpnav.values import Metric

LEARN, TEST = 1, 3
"""Runs: the line is driven once to learn and once more at the same time of day."""

OTHER_DAY = "_other_day"
"""Ending of the figures of a test under other light, beside those of the afternoon of the learning.
The paper has none of them."""

SCALES = (0.25, 0.5, 1.0, 2.0)
"""Sizes of the outdoor world; at 1 landmarks stand 10 to 50 m away."""

SMALL_STEP_M = {"room": 0.1, "outdoor": 0.5}
"""Steps along the lines in small."""

FOCUS = PRESETS["fig4c"].focus
"""Focus points of a panorama, which the paper does not say: in figure 7 as many as in 3 and 4."""

SAME_DAY: Tables = {
    "world": {"moved_share": 0.0},
    "film": {"exposure_spread": 0.01, "rolling": 0.0},
}
"""Nothing is moved; the gain of the camera is fixed, and no lamp flickers in daylight."""

LINE_M, BEFORE_M, AGAIN_MPS = 25.0, 0.5, 0.4
"""Length of the line outdoors. The second drive along it begins so much before the first place and
is slower than the first, so that no image of it is taken where and when one was learned."""

SAME_LAMPS: Tables = {
    "world": {"moved_share": 0.0, "lamp_spread": 0.0, "warmth_spread": 0.0},
    "film": {"exposure_spread": 0.01},
}


def choice(preset: str, **changes: Any) -> SystemChoice:
    """The system with a preset's parameters and changes to them."""
    return SystemChoice("placecell", preset, {"placecell": changes})


def soft_and_strict(shop: Workshop, seed: int) -> Outcome:
    """B1, figure 3: five places 60 cm apart in a room, soft and strict competition."""
    learn = shop.log(line_job(shop, "room", seed, LEARN, SAME_LAMPS, step_m=0.2))
    test = shop.log(line_job(shop, "room", seed, TEST, SAME_LAMPS))
    soft = line(shop, learn, test, choice("fig3b"))
    strict = line(shop, learn, test, choice("fig3b", interpretations=1))
    wins = nearest_wins(soft), nearest_wins(strict)
    metrics = [
        min(wins, key=lambda metric: metric.value),
        named(wins[0], "nearest_wins_soft"),
        named(wins[1], "nearest_wins_strict"),
        named(silent(soft), "silent_samples_soft"),
        named(silent(strict), "silent_samples_strict"),
        half_width_ratio(soft, strict),
        max((peak_error(soft), peak_error(strict)), key=lambda metric: metric.value),
        learned_activity(soft),
    ]
    pictures = [
        picture("strict", "Figure 3a here: strict competition", strict),
        picture("soft", "Figure 3b here: soft competition", soft),
    ]
    return Outcome(metrics, pictures, {"preset": "fig3b"})


def short_term_memory(shop: Workshop, seed: int) -> Outcome:
    """B2, figure 4: six places 5 m apart in the open, with and without short-term memory."""
    learn, test = (shop.log(job) for job in afternoon(shop, seed))
    without = line(shop, learn, test, choice("fig4c", qmax=0))
    held = line(shop, learn, test, choice("fig4c"))
    window = line(shop, learn, test, choice("fig4c", stm="window"))
    later = line(shop, learn, shop.log(other_day(shop, seed)), choice("fig4c"))
    metrics = [
        roughness_ratio(held, without),
        named(roughness_ratio(window, without), "roughness_ratio_window"),
        learned_activity(held),
        named(learned_activity(without), "learned_activity_without"),
        nearest_wins(held),
        named(nearest_wins(without), "nearest_wins_without"),
        _diameter(held),
        named(learned_activity(later), f"learned_activity{OTHER_DAY}"),
        named(nearest_wins(later), f"nearest_wins{OTHER_DAY}"),
    ]
    pictures = [
        picture("without", "Figure 4b here: without extended memory", without),
        picture("with", "Figure 4c here: the last four panoramas are held", held),
    ]
    return Outcome(metrics, pictures, {"preset": "fig4c"})


def growing_fields(shop: Workshop, seed: int) -> Outcome:
    """B3: the diameter of the fields over the size of the world."""
    diameters = []
    scales = SCALES[::2] if shop.small else SCALES
    for scale in scales:
        learn, test = (_scaled(shop, seed, scale, again=again) for again in (False, True))
        fields = line(shop, learn, test, choice("fig4c"))
        diameters.append(float(widths(fields, FIELD_SHARE).mean()))
    metrics = [field_slope(np.array(scales), np.array(diameters))]
    metrics += [
        Metric(f"diameter_at_scale_{scale:g}", width, 1, 1, "m")
        for scale, width in zip(scales, diameters, strict=True)
    ]
    return Outcome(metrics, (), {"preset": "fig4c", "scales": list(scales)})


def line(
    shop: Workshop, learn: Path, test: Path, chosen: SystemChoice, names: Sequence[str] = ()
) -> Fields:
    """Fields of the places labelled on one log, or of those named, over another along the line."""
    return line_of(shop, learn, shop.run(test, chosen), chosen, names)


def line_of(
    shop: Workshop, learn: Path, asked: Run, chosen: SystemChoice, names: Sequence[str] = ()
) -> Fields:
    """The same over a run that is extracted already."""
    named_places = labelled(shop.run(learn, chosen), names)
    return fields_on(guided_map(named_places, learn), asked)


def guided_map(run: Run, log: Path) -> tuple[Header, BuiltMap]:
    """Map of the places that the labels of a run name."""
    return make_map(run, [log], guided=True, close_loops=False, advance=lambda done: None)


def fields_on(made: tuple[Header, BuiltMap], asked: Run) -> Fields:
    """Fields of the places of a map over a run, each signature on its own but for what is held."""
    header, built = made
    result = locate_run(
        asked.system, header, built, asked, method=Method.MATCH, advance=lambda done: None
    )
    return fields_of(result)


def labelled(run: Run, names: Sequence[str] = ()) -> Run:
    """The first signature of every place named on the way, or of those asked for."""
    first: dict[str, int] = {}
    for row, signature in enumerate(run.table):
        label = signature.reference.label
        if label in names or (not names and label.startswith("place-")):
            first.setdefault(label, row)
    return Run(run.header, take(run.table, np.array(list(first.values()))), run.system)


def line_job(
    shop: Workshop,
    world: str,
    seed: int,
    run: int,
    tables: Tables,
    step_m: float = 0.0,
    sensors: Sequence[str] = ("panorama",),
) -> Job:
    """A drive along the line of a world; its own step where none is given, longer in small."""
    if shop.small:
        step_m = max(step_m, SMALL_STEP_M[world])
    changed = {**tables, "capture": {**tables.get("capture", {}), "step_m": step_m}}
    return job_of(world, "line", seed, run, sensors=sensors, tables=changed)


def afternoon(
    shop: Workshop,
    seed: int,
    sensor: str = "panorama",
    *,
    speed_mps: float = 0.0,
    step_m: float = 0.0,
    rig: Tables = NO_TABLES,
    run: int = LEARN,
) -> tuple[Job, Job]:
    """The line outdoors driven to learn, and once more the same afternoon.

    Sun and clouds stay, as in figures 4 and 7; people have walked on, and noise is drawn anew.
    ``speed_mps`` : of both drives; 0 = the route's, then AGAIN_MPS. ``step_m`` : of the second,
    ``run`` its day. ``rig`` : what else is changed of what the robot carries
    """
    learn: Tables = {**SAME_DAY, **rig, "capture": {"speed_mps": speed_mps}}
    longer = {**SAME_DAY["world"], "line_m": LINE_M + 2.0 * BEFORE_M}
    again: Tables = {
        **SAME_DAY,
        **rig,
        "world": longer,
        "capture": {"speed_mps": speed_mps or AGAIN_MPS},
    }
    return (
        line_job(shop, "outdoor", seed, LEARN, learn, 1.0, [sensor]),
        line_job(shop, "outdoor", seed, run, again, step_m, [sensor]),
    )


def other_day(shop: Workshop, seed: int) -> Job:
    """The second drive on another day: other sun, clouds and shadows. Not in the paper, which
    changes the light in figure 8 alone."""
    return afternoon(shop, seed, run=TEST)[1]


def _scaled(shop: Workshop, seed: int, scale: float, *, again: bool) -> Path:
    """A line whose length, places, samples and speed grow with the world.

    Nothing but the places is looked at to learn.
    """
    length = LINE_M + (2.0 * BEFORE_M if again else 0.0)
    world = {
        **SAME_DAY["world"],
        "scale": scale,
        "line_m": length * scale,
        "spacing_m": 5.0 * scale,
        "line_step_m": 0.5 * scale,
    }
    capture = {"speed_mps": 5.0 * AGAIN_MPS * scale} if again else {"step_m": 5.0 * scale}
    tables: Tables = {**SAME_DAY, "world": world, "capture": capture}
    return shop.log(job_of("outdoor", "line", seed, LEARN, tables=tables))


def _diameter(fields: Fields) -> Metric:
    found = widths(fields, FIELD_SHARE)
    return Metric("field_diameter_m", float(found.mean()), len(found), len(found), "m")


def named(metric: Metric, name: str) -> Metric:
    return Metric(name, metric.value, metric.n, metric.of, metric.unit, metric.low, metric.high)


def picture(
    name: str, title: str, fields: Fields, hidden_from_m: float = float("nan")
) -> Illustration:
    """Activity of every place over position."""
    caption = "One line a place cell; triangles mark where places were learned, on another drive."
    return Illustration(name, title, caption, partial(drawing.draw, fields, hidden_from_m))
