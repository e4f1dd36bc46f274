"""A robot that is carried off and set down elsewhere (B7), on the lines of figures 3 and 4."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnav.execution.stages import locate_run, take
from fpnav.execution.walk import Run, SystemChoice
from fpnav.experiments.giovannangeli.lines import (
    LEARN,
    OTHER_DAY,
    SAME_LAMPS,
    TEST,
    afternoon,
    choice,
    guided_map,
    labelled,
    line_job,
    other_day,
)
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.localization.locate import Method
from fpnav.sim.record import Job
from fpnav.sim.seeds import generator
from fpnav.store.maps import BuiltMap
from fpnav.values import Metric

Rows = NDArray[np.int64]

JUMPS = 40
BETWEEN = 5
"""Panoramas between two jumps, more than any memory lasts."""

CLEAR = 0.2
"""Samples nearer to the border of two places than this share of their distance are not asked."""


def carried_off(shop: Workshop, seed: int) -> Outcome:
    """B7: which cell wins at the first panorama after a jump, with and without extended memory."""
    room = (
        line_job(shop, "room", seed, LEARN, SAME_LAMPS, 0.2),
        line_job(shop, "room", seed, TEST, SAME_LAMPS),
    )
    outdoor = afternoon(shop, seed)
    later = outdoor[0], other_day(shop, seed)
    found = {
        "recovered": recovered(shop, seed, *room, choice("fig3b")),
        "recovered_outdoor": recovered(shop, seed, *outdoor, choice("fig4c", qmax=0)),
        "recovered_outdoor_memory": recovered(shop, seed, *outdoor, choice("fig4c")),
        f"recovered_outdoor{OTHER_DAY}": recovered(shop, seed, *later, choice("fig4c", qmax=0)),
    }
    metrics = [
        Metric(name, float(right.mean()), int(right.sum()), len(right))
        for name, right in found.items()
    ]
    return Outcome(metrics, (), {"preset": "fig3b, fig4c", "jumps": JUMPS})


def recovered(
    shop: Workshop, seed: int, learn: Job, test: Job, chosen: SystemChoice
) -> NDArray[np.bool_]:
    """Whether the nearest place wins at the first panorama after each jump, (JUMPS,)."""
    log = shop.log(learn)
    header, built = guided_map(labelled(shop.run(log, chosen)), log)
    asked = shop.run(shop.log(test), chosen)
    rows, first, nearest = jumping(built, asked, seed)
    result = locate_run(
        asked.system,
        header,
        built,
        Run(asked.header, take(asked.table, rows), asked.system),
        method=Method.MATCH,
        advance=lambda done: None,
    )
    return np.asarray(result.places[first, 0] == nearest)


def jumping(built: BuiltMap, asked: Run, seed: int) -> tuple[Rows, Rows, Rows]:
    """Stretches of a run in an order that jumps from one place to another.

    Returns
    -------
    rows : of the run; ``first`` of each stretch among them, and the place ``nearest`` to it
    """
    places = built.topomap.places
    at = built.signatures.references["truth"][[place.members[0] for place in places], :2]
    here = asked.table.references["truth"][:, :2]
    apart = np.hypot(*(here[:, None] - at).transpose(2, 0, 1))
    spacing = min(float(np.hypot(*step)) for step in np.diff(at, axis=0))
    order = np.sort(apart, axis=1)
    nearest = np.argmin(apart, axis=1)
    clear = order[:, 1] - order[:, 0] > CLEAR * (order[:, 1] + order[:, 0])
    possible = np.flatnonzero(clear[: len(clear) - BETWEEN])
    rng, starts = generator(seed, "jumps"), [int(possible[0])]
    while len(starts) <= JUMPS:
        start = int(rng.choice(possible))
        last = starts[-1] + BETWEEN - 1
        if nearest[start] != nearest[last] and np.hypot(*(here[start] - here[last])) > spacing:
            starts.append(start)
    rows = np.concatenate([np.arange(start, start + BETWEEN) for start in starts])
    ids = np.array([place.id for place in places])
    return rows, BETWEEN * np.arange(1, len(starts)), ids[nearest[starts[1:]]]
