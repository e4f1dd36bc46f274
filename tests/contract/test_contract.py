"""Every system of the registry keeps the contract of fpnav.systems.base."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from helpers import small_world, tiny_onnx
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.params import Params, as_dict
from fpnav.store.header import flat
from fpnav.systems.base import System, Trace
from fpnav.systems.registry import SYSTEMS, system_class
from fpnav.values import SENSOR_ROLES, Frame, Signature

FRAMES = 84
SOME = 14
JOINED = "fingerprint+placecell"
CASES = [
    *((name, preset) for name in sorted(SYSTEMS) for preset in ("default", "paper")),
    (JOINED, "default"),
]


def complete(params: Params) -> Params:
    """Parameters with the file a system cannot do without."""
    if "file" not in params.__struct_fields__:
        return params
    file = Path(tempfile.mkdtemp()) / "pool.onnx"
    return msgspec.structs.replace(params, file=str(tiny_onnx.write(file)))


class Run:
    """One system's frames, signatures and a memory of a few places."""

    def __init__(self, name: str, preset: str) -> None:
        kind = system_class(name)
        self.system: System = kind(complete(kind.PRESETS[preset]))
        roles = [role for role in small_world.ROLES if role in kind.NEEDS.uses]
        self.frames: list[Frame] = small_world.route(FRAMES, roles)
        self.features = [(one.reference, self.system.describe(one)) for one in self.frames]
        self.all: list[Signature] = list(self.system.assemble(iter(self.features)))
        self.signatures = self.all[:: -(-len(self.all) // SOME)]

    def memory(self, places: int = 4) -> Any:
        memory = self.system.memory()
        memory.fit(self.signatures)
        for at, signature in enumerate(self.signatures):
            memory.learn(at * places // len(self.signatures), signature)
        return memory


_runs: dict[tuple[str, str], Run] = {}


@pytest.fixture(params=CASES, ids=lambda case: "-".join(case))
def run(request: pytest.FixtureRequest) -> Run:
    if request.param not in _runs:
        _runs[request.param] = Run(*request.param)
    return _runs[request.param]


def equal(first: Mapping[str, NDArray[Any]], second: Mapping[str, NDArray[Any]]) -> bool:
    return list(first) == list(second) and all(
        first[key].dtype == second[key].dtype and first[key].tobytes() == second[key].tobytes()
        for key in first
    )


def one_by_one(memory: Any, queries: Sequence[Signature], k: int) -> list[Any]:
    trace: Trace = None
    found = []
    for query in queries:
        answer, trace = memory.recall([query], k, None, trace)
        found.append(answer)
    return found


def poor(run: Run, walls: int) -> list[Signature]:
    """Signatures of a stretch where sensors work but see next to nothing, if any are made."""
    roles = [role for role in small_world.ROLES if role in run.system.NEEDS.uses]
    frames = [small_world.bare_frame(at, walls, roles) for at in range(12)]
    described = ((one.reference, run.system.describe(one)) for one in frames)
    return list(run.system.assemble(described))[:3]


def test_what_it_declares_is_what_it_uses(run: Run) -> None:
    kind = type(run.system)
    assert set(kind.NEEDS.uses) <= set(SENSOR_ROLES)
    assert all(set(group) <= set(kind.NEEDS.uses) for group in kind.NEEDS.must)
    assert {"paper", "default"} <= set(kind.PRESETS)
    fields = set(flat(as_dict(run.system.params)))
    assert fields >= kind.LATE
    assert isinstance(run.system.params, kind.PARAMS)
    assert set(kind.NAME.split("+")) <= set(SYSTEMS)
    assert kind.SUMMARY
    assert run.system.rule.min_observations >= 1
    assert run.system.thinning.step_m >= 0.0


def test_describing_a_frame_again_gives_the_same_bytes(run: Run) -> None:
    for frame, (_, features) in list(zip(run.frames, run.features, strict=True))[:5]:
        assert equal(run.system.describe(frame), features)


def test_features_survive_pickling(run: Run) -> None:
    for _, features in run.features[:5]:
        assert equal(pickle.loads(pickle.dumps(dict(features))), features)


def test_a_pickled_system_describes_the_same(run: Run) -> None:
    other = pickle.loads(pickle.dumps(run.system))
    assert equal(other.describe(run.frames[0]), run.features[0][1])


def test_assembling_again_gives_the_same_signatures(run: Run) -> None:
    again = list(run.system.assemble(iter(run.features)))
    assert len(again) == len(run.all)
    for first, second in zip(again, run.all, strict=True):
        assert first.reference == second.reference
        assert first.record.tobytes() == second.record.tobytes()
        assert equal(first.parts, second.parts)


def test_signatures_have_the_declared_dtypes_in_travel_order(run: Run) -> None:
    assert run.signatures
    stamps = [signature.reference.stamp_ns for signature in run.all]
    assert stamps == sorted(stamps)
    for signature in run.all:
        assert signature.record.dtype == run.system.RECORD
        assert {name: part.dtype for name, part in signature.parts.items()} == dict(
            run.system.PARTS
        )


def test_similarity_is_one_for_equal_and_symmetric(run: Run) -> None:
    some = run.signatures[:: max(1, len(run.signatures) // 5)]
    for first in some:
        assert run.system.similarity(first, first) == pytest.approx(1.0, abs=1e-9)
        for second in some:
            value = run.system.similarity(first, second)
            assert 0.0 <= value <= 1.0
            assert value == pytest.approx(run.system.similarity(second, first), abs=1e-9)


def test_a_batch_is_recalled_as_its_members_one_by_one(run: Run) -> None:
    memory = run.memory()
    batch, _ = memory.recall(run.signatures, 3, None, None)
    singles = one_by_one(memory, run.signatures, 3)
    for at, single in enumerate(singles):
        assert np.array_equal(batch.places[at], single.places[0])
        assert np.array_equal(batch.scores[at], single.scores[0])
        assert np.array_equal(batch.headings_rad[at], single.headings_rad[0], equal_nan=True)


def test_rankings_descend_and_are_padded(run: Run) -> None:
    memory = run.memory(places=3)
    found, _ = memory.recall(run.signatures, 5, None, None)
    known = len(memory.places)
    assert found.places.shape == found.scores.shape == found.headings_rad.shape
    assert found.places.shape == (len(run.signatures), 5)
    assert (found.places[:, known:] == -1).all()
    assert np.isneginf(found.scores[:, known:]).all()
    filled = np.where(found.places >= 0, found.scores, -np.inf)
    assert (np.diff(filled[:, :known], axis=1) <= 0.0).all()
    for row in found.places:
        real = row[row >= 0]
        assert len(set(real)) == len(real)


def test_places_that_are_not_allowed_never_appear(run: Run) -> None:
    memory = run.memory()
    count = len(memory.places)
    allowed = np.zeros((len(run.signatures), count), dtype=bool)
    allowed[np.arange(len(run.signatures)), np.arange(len(run.signatures)) % count] = True
    allowed[0] = False
    found, _ = memory.recall(run.signatures, count, allowed, None)
    for row, permitted in zip(found.places, allowed, strict=True):
        assert set(row[row >= 0]) <= set(memory.places[permitted])
    assert (found.places[0] == -1).all()


def test_the_best_few_are_the_head_of_the_whole_ranking(run: Run) -> None:
    memory = run.memory()
    short, _ = memory.recall(run.signatures, 1, None, None)
    whole, _ = memory.recall(run.signatures, len(memory.places), None, None)
    assert np.array_equal(short.places[:, 0], whole.places[:, 0])
    assert np.array_equal(short.scores[:, 0], whole.scores[:, 0])


def test_equal_places_are_ordered_by_id(run: Run) -> None:
    memory = run.system.memory()
    memory.fit(run.signatures)
    for place in (7, 3, 5):
        memory.learn(place, run.signatures[0])
    assert list(memory.places) == [3, 5, 7]
    found, _ = memory.recall(run.signatures[:1], 3, None, None)
    ranking = list(zip(-found.scores[0], found.places[0], strict=True))
    assert ranking == sorted(ranking)


def test_a_learned_signature_is_recalled(run: Run) -> None:
    memory = run.system.memory()
    memory.fit(run.signatures)
    memory.learn(4, run.signatures[0])
    memory.learn(9, run.signatures[-1])
    for place, signature in ((4, run.signatures[0]), (9, run.signatures[-1])):
        found, _ = memory.recall([signature], 1, None, None)
        assert found.places[0, 0] == place


def test_saving_and_loading_changes_no_answer(run: Run) -> None:
    memory = run.memory()
    state = memory.save()
    assert all(isinstance(array, np.ndarray) and array.dtype != object for array in state.values())
    other = run.system.memory()
    other.load({name: array.copy() for name, array in state.items()})
    assert equal(other.save(), state)
    first, _ = memory.recall(run.signatures, 4, None, None)
    second, _ = other.recall(run.signatures, 4, None, None)
    assert np.array_equal(first.places, second.places)
    assert np.array_equal(first.scores, second.scores)
    assert np.array_equal(first.headings_rad, second.headings_rad, equal_nan=True)
    last = run.signatures[-1]
    assert memory.novelty(last, None, None)[0] == other.novelty(last, None, None)[0]


def test_learning_goes_on_after_loading_as_without_it(run: Run) -> None:
    memory = run.memory()
    other = run.system.memory()
    other.load(memory.save())
    for one in (memory, other):
        one.learn(1, run.signatures[0])
        one.learn(30, run.signatures[-1])
    assert equal(memory.save(), other.save())


def test_a_memory_of_nothing_is_saved_loaded_and_asked(run: Run) -> None:
    memory = run.system.memory()
    other = run.system.memory()
    other.load(memory.save())
    found, _ = other.recall(run.signatures[:2], 2, None, None)
    assert (found.places == -1).all()
    assert len(other.places) == 0


def test_a_state_that_lacks_an_array_is_refused(run: Run) -> None:
    state = run.memory().save()
    missing = next(iter(state))
    with pytest.raises(StoreError, match=missing):
        run.system.memory().load({k: v for k, v in state.items() if k != missing})


def test_merging_leaves_one_place_that_still_answers(run: Run) -> None:
    memory = run.memory()
    keep, drop = (int(place) for place in memory.places[:2])
    memory.merge(keep, drop)
    assert drop not in memory.places
    assert keep in memory.places
    found, _ = memory.recall(run.signatures, len(memory.places), None, None)
    assert drop not in found.places
    assert np.isfinite(found.scores).all()


def test_shrinking_to_no_bound_changes_nothing_and_to_one_still_answers(run: Run) -> None:
    memory = run.memory()
    before = memory.save()
    memory.shrink(0)
    assert equal(memory.save(), before)
    memory.shrink(1)
    found, _ = memory.recall(run.signatures[:2], 2, None, None)
    assert (found.places >= 0).all()
    small = memory.save()
    memory.shrink(1)
    assert equal(memory.save(), small)


def test_novelty_lies_between_nothing_and_one(run: Run) -> None:
    memory = run.system.memory()
    memory.fit(run.signatures)
    trace: Trace = None
    previous = None
    for signature in run.signatures:
        value, trace = memory.novelty(signature, previous, trace)
        assert 0.0 <= value <= 1.0
        memory.learn(0, signature)
        previous = signature


def test_what_was_just_learned_is_no_news(run: Run) -> None:
    memory = run.system.memory()
    memory.fit(run.signatures)
    first = run.signatures[0]
    _, trace = memory.novelty(first, None, None)
    memory.learn(0, first)
    value, _ = memory.novelty(first, first, trace)
    assert value == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("walls", [0, 1])
def test_signatures_of_next_to_nothing_are_survived(run: Run, walls: int) -> None:
    rich = run.signatures[-1]
    for bare in poor(run, walls):
        for first, second in ((bare, rich), (rich, bare), (bare, bare)):
            assert 0.0 <= run.system.similarity(first, second) <= 1.0
        memory = run.system.memory()
        memory.fit([bare, rich])
        assert 0.0 <= memory.novelty(bare, rich, None)[0] <= 1.0
        for place, signature in ((0, rich), (0, bare), (1, bare)):
            memory.learn(place, signature)
        found, _ = memory.recall([bare, rich], 2, None, None)
        assert not np.isnan(found.scores).any()
        memory.merge(0, 1)
        run.system.picture(bare)


def test_a_frame_whose_sensors_all_dropped_out_is_survived(run: Run) -> None:
    blank = Frame(run.frames[1].reference, {})
    features = run.system.describe(blank)
    stream = [run.features[0], (blank.reference, features), *run.features[2:6]]
    for signature in run.system.assemble(iter(stream)):
        assert run.system.similarity(signature, signature) >= 0.0


def test_likelihoods_peak_at_one_and_the_impossible_gets_the_least(run: Run) -> None:
    scores = np.array([[0.2, 0.9, 0.5, -np.inf], [0.3, 0.3, 0.3, 0.3]])
    values = run.system.likelihood(scores)
    assert values.shape == scores.shape
    assert values.max(axis=1) == pytest.approx([1.0, 1.0])
    assert (values >= 0.0).all()
    assert values[0, 3] == values[0].min()
    assert values[0, 1] > values[0, 2] > values[0, 0]


def test_the_picture_can_be_drawn(run: Run) -> None:
    picture = run.system.picture(run.signatures[0])
    assert picture.kind in ("strip", "curve", "grid", "scan")
    if picture.kind in ("strip", "curve"):
        assert picture.bearings_rad.shape == picture.weights.shape
        assert len(picture.symbols) in (0, len(picture.weights))
    else:
        assert picture.values is not None
        assert picture.values.ndim == 2


def test_verification_answers_for_every_candidate_or_not_at_all(run: Run) -> None:
    found = run.system.verify(run.signatures[0], run.signatures[:3])
    if found is not None:
        assert found.scores.shape == (min(3, len(run.signatures)),)
        assert len(found.relative) == len(found.scores)
