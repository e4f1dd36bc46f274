"""The standard memory of frame-level descriptors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.systems.base import Features, State
from fpnav.systems.descriptors import DescriptorMemory, stacked
from fpnav.values import FloatArray, Reference, Signature

RECORD = np.dtype([("spot_m", "<f8"), ("heading_rad", "<f8")])
PLAIN = np.zeros(1, RECORD)


class Spots:
    """Signatures are spots on a line: likeness falls with their distance in units of a scale."""

    def fit(self, signatures: Sequence[Signature]) -> State:
        return {"scale": np.array([np.ptp([one.record["spot_m"] for one in signatures])])}

    def descriptor(self, signature: Signature, model: State) -> Features:
        row = signature.record
        return {"at": np.array([row["spot_m"], row["heading_rad"]]), "tail": np.arange(3)}

    stack = stacked

    def compare(
        self, query: Features, members: Any, rows: NDArray[np.int64], model: State
    ) -> tuple[FloatArray, FloatArray]:
        off = query["at"] - members["at"][rows]
        return -np.abs(off[:, 0]), off[:, 1]

    def likeness(self, first: Features, second: Features, model: State) -> float:
        return float(np.exp(-abs(first["at"][0] - second["at"][0]) / model["scale"][0]))


def at(spot_m: float, heading_rad: float = 0.0) -> Signature:
    row = PLAIN.copy()
    row["spot_m"], row["heading_rad"] = spot_m, heading_rad
    return Signature(Reference(0, 0), row[0], {})


def memory_of(places: dict[int, Sequence[float]]) -> DescriptorMemory:
    memory = DescriptorMemory(Spots())
    memory.fit([at(0.0), at(10.0)])
    for place, spots in places.items():
        for spot in spots:
            memory.learn(place, at(spot))
    return memory


def test_a_place_is_as_like_a_query_as_its_best_member() -> None:
    memory = memory_of({4: (0.0, 7.0), 2: (3.0,), 9: (20.0,)})
    found, _ = memory.recall([at(6.0)], 3, None, None)
    assert found.places.tolist() == [[4, 2, 9]]
    assert found.scores.tolist() == [[-1.0, -3.0, -14.0]]


def test_the_turn_is_that_of_the_best_member() -> None:
    memory = DescriptorMemory(Spots())
    memory.learn(0, at(0.0, 0.1))
    memory.learn(0, at(5.0, 0.2))
    found, _ = memory.recall([at(4.0, 1.0), at(1.0, 1.0)], 1, None, None)
    assert found.headings_rad[:, 0] == pytest.approx([0.8, 0.9])


def test_members_of_places_not_allowed_are_not_compared() -> None:
    seen: list[NDArray[np.int64]] = []

    class Watched(Spots):
        def compare(
            self, query: Features, members: Any, rows: NDArray[np.int64], model: State
        ) -> tuple[FloatArray, FloatArray]:
            seen.append(rows)
            return super().compare(query, members, rows, model)

    memory = DescriptorMemory(Watched())
    for place, spot in ((0, 0.0), (0, 1.0), (1, 2.0), (1, 3.0)):
        memory.learn(place, at(spot))
    allowed = np.array([[False, True]])
    found, _ = memory.recall([at(0.0)], 2, allowed, None)
    assert found.places.tolist() == [[1, -1]]
    assert [rows.tolist() for rows in seen] == [[2, 3]]


def test_novelty_is_measured_from_where_the_place_began() -> None:
    memory = memory_of({0: (0.0, 1.0, 2.0)})
    value, _ = memory.novelty(at(3.0), at(2.0), None)
    assert value == pytest.approx(1.0 - np.exp(-0.3))


def test_the_least_alike_are_kept_when_a_place_shrinks() -> None:
    memory = memory_of({0: (0.0, 0.1, 4.0, 4.1, 9.0), 1: (5.0,)})
    memory.shrink(3)
    assert [one["at"][0] for one in memory.members(0)] == [0.0, 4.1, 9.0]
    assert len(memory.members(1)) == 1


def test_merging_joins_the_members() -> None:
    memory = memory_of({0: (0.0,), 1: (5.0, 6.0)})
    memory.merge(0, 1)
    assert memory.places.tolist() == [0]
    assert [one["at"][0] for one in memory.members(0)] == [0.0, 5.0, 6.0]


def test_a_batch_is_made_anew_after_learning() -> None:
    memory = memory_of({0: (0.0,)})
    memory.recall([at(1.0)], 1, None, None)
    memory.learn(1, at(1.0))
    found, _ = memory.recall([at(1.0)], 1, None, None)
    assert found.places.tolist() == [[1]]


def test_what_was_learned_of_the_run_is_saved_too() -> None:
    memory = memory_of({3: (0.0, 2.0), 8: (5.0,)})
    other = DescriptorMemory(Spots())
    other.load(memory.save())
    assert other.model["scale"].tolist() == [10.0]
    assert [len(other.members(place)) for place in (3, 8)] == [2, 1]
    assert other.novelty(at(7.0), None, None) == memory.novelty(at(7.0), None, None)


def test_a_state_without_one_of_its_arrays_is_refused() -> None:
    state = memory_of({0: (0.0,)}).save()
    for name in state:
        if name.startswith("model_"):
            continue
        with pytest.raises(StoreError, match=name):
            DescriptorMemory(Spots()).load({k: v for k, v in state.items() if k != name})
