"""What guided traversals taught, and what the test saw, as square tables: query by stored place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fpnav.experiments.kortenkamp.tours import TEST, Traversal
from fpnav.systems.gateway.bayes import normalised
from fpnav.systems.gateway.evidence import scene_scores, sonar_evidence
from fpnav.systems.gateway.memory import GatewayMemory
from fpnav.systems.gateway.model import PlaceModel
from fpnav.systems.gateway.params import GatewayParams
from fpnav.systems.gateway.types import NAMES
from fpnav.values import FloatArray, Signature

Key = tuple[str, str, int]
Evidence = Callable[[Sequence[Signature], Sequence[PlaceModel], GatewayParams], FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """Places as the guided traversals taught them, and what the last traversal saw of each.

    ``names``, ``routes`` (P,) of the places, which are numbered so in ``memory``; ``tests`` (P,)
    None where the gateway was not found.
    """

    names: tuple[str, ...]
    routes: tuple[str, ...]
    memory: GatewayMemory
    tests: tuple[Signature | None, ...]

    def scores(self, params: GatewayParams) -> FloatArray:
        """Match scores of the scenes (P, P); 0 where there is no scene or no place."""
        return self._square(scene_scores, params)

    def sonar(self, params: GatewayParams) -> FloatArray:
        """Likelihoods of the gateways alone (P, P), rows normalised."""
        return normalised(self._square(sonar_evidence, params))

    def misread(self, name: str, kind: str) -> Learned:
        """The same, had the sonar taken the gateway of that name for another type."""
        tests = tuple(
            _taken_for(test, kind) if test is not None and own == name else test
            for own, test in zip(self.names, self.tests, strict=True)
        )
        return replace(self, tests=tests)

    def _square(self, evidence: Evidence, params: GatewayParams) -> FloatArray:
        table = np.zeros((len(self.names), len(self.names)))
        rows = [row for row, test in enumerate(self.tests) if test is not None]
        columns = [int(place) for place in self.memory.places]
        if rows and columns:
            seen = [test for test in self.tests if test is not None]
            places = [self.memory.model(place) for place in columns]
            table[np.ix_(rows, columns)] = evidence(seen, places, params)
        return table


def learned(drives: Sequence[Traversal], params: GatewayParams) -> Learned:
    """Every gateway of every route is a place, told to the robot but for the last traversal."""
    keys: list[Key] = []
    for drive in drives:
        keys += [key for key in _keys(drive) if key not in keys]
    memory = GatewayMemory(params)
    tests: list[Signature | None] = [None] * len(keys)
    for drive in drives:
        own = _keys(drive)
        for number, signature in drive.guided():
            place = keys.index(own[number])
            if drive.number == TEST:
                tests[place] = signature
            else:
                memory.learn(place, signature)
    names, routes = tuple(name for _, name, _ in keys), tuple(route for route, _, _ in keys)
    return Learned(names, routes, memory, tuple(tests))


def _keys(drive: Traversal) -> list[Key]:
    """Route, name and how often it was met before, of every gateway of a drive."""
    names = drive.survey.truth.names
    return [(drive.route, name, names[:row].count(name)) for row, name in enumerate(names)]


def _taken_for(signature: Signature, kind: str) -> Signature:
    record = np.array([signature.record])
    record["type"] = NAMES.index(kind)
    return Signature(signature.reference, record[0], signature.parts)
