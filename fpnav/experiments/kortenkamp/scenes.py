"""Sixteen scenes and sixteen stored ones: the four matchers of the paper, and the soft one."""

from __future__ import annotations

from functools import partial
from typing import Any

import msgspec
import numpy as np

from fpnav.evaluation.gateways import told_apart
from fpnav.experiments.kortenkamp.learned import Learned, learned
from fpnav.experiments.kortenkamp.tours import choice, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.report.figures import gateways as drawing
from fpnav.report.study import Illustration
from fpnav.systems.gateway.params import PRESETS
from fpnav.values import Metric

MATCHERS: tuple[Any, ...] = (1, 2, 3, 4, "soft")
PAPER_MATCHED = (7, 9, 5, 6)
PARAMS = PRESETS["paper"]


def matchers(shop: Workshop, seed: int) -> Outcome:
    """C2: a scene matches the stored one of its own gateway, and no other as well."""
    places = learned(traversals(shop, seed, choice()), PARAMS)
    told = [_matched(places, matcher) for matcher in MATCHERS]
    second = told[1]
    lead = [
        Metric(f"matcher_2_over_{n}", second.value - told[n - 1].value, second.of, second.of)
        for n in (1, 3, 4)
    ]
    blank = sum(test is None or len(test.parts["cues"]) == 0 for test in places.tests)
    scenes = Metric("scenes_without_cues", blank / len(places.tests), blank, len(places.tests))
    picture = Illustration(
        "matchers", "Scenes matched by each algorithm",
        "Of sixteen test scenes those whose own stored scene scored best, alone.",
        partial(drawing.matchers, [m.n for m in told], PAPER_MATCHED, len(places.tests)),
    )  # fmt: skip
    return Outcome([*told, *lead, scenes], [picture], {"preset": "paper", "scenes": 16})


def _matched(places: Learned, matcher: Any) -> Metric:
    params = msgspec.structs.replace(PARAMS, matcher=matcher)
    own = np.arange(len(places.names))
    return told_apart(f"matcher_{matcher}", places.scores(params), own)
