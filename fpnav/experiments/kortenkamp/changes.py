"""A door closed since training (the paper: relying on sonar alone can then be dangerous)."""

from __future__ import annotations

import numpy as np

from fpnav.evaluation.gateways import rate, told_apart
from fpnav.experiments.kortenkamp.learned import learned
from fpnav.experiments.kortenkamp.recognition import OURS, PARAMS, ROUTE, recognition
from fpnav.experiments.kortenkamp.tours import NEAR, TEST, TRAINING, choice, traversals
from fpnav.experiments.study import Outcome
from fpnav.experiments.workshop import Workshop
from fpnav.params import Tables

CLOSED = "C"
WALLED: Tables = {**NEAR, "world": {"closed": [CLOSED]}}


def closed_door(shop: Workshop, seed: int) -> Outcome:
    """C10: C is walled up on the test; "the third right opening" is then another place."""
    drives = traversals(shop, seed, choice(), [ROUTE], TRAINING)
    test = traversals(shop, seed, choice(), [ROUTE], [TEST], WALLED)
    places = learned([*drives, *test], PARAMS)
    seen, ours = recognition(places), recognition(places, OURS)
    left = np.array([row for row, name in enumerate(seen.names) if name != CLOSED])
    counted = _by_counting(places.tests, places.names)
    reported = places.tests[places.names.index(CLOSED)] is not None
    metrics = [
        told_apart("closed_combined", seen.both[left], left),
        told_apart("closed_combined_default", ours.both[left], left),
        rate("closed_by_counting", counted, len(left)),
        rate("closed_reported", int(reported), 1),
    ]
    return Outcome(metrics, (), {"preset": "paper", "closed": CLOSED})


def _by_counting(tests: tuple[object, ...], names: tuple[str, ...]) -> int:
    """Gateways named right by a robot that counts them as it learned them."""
    met = [name for name, test in zip(names, tests, strict=True) if test is not None]
    return sum(a == b for a, b in zip(met, names, strict=False))
