"""Image peers: each finds the frame it saw, panoramas give the turn, light changes little."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers import small_world
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.params import as_dict, resolve
from fpnav.systems.registry import SYSTEMS, system_class
from fpnav.systems.vlad import aggregated, inliers, k_means
from fpnav.values import Decoded, Frame, Image, Pose2, Reference, Signature

FORWARD = ("tiny", "colourhist", "hog", "vlad")
ROUND = ("ridf", "fourier")
PEERS = [name for name in SYSTEMS if name not in ("fingerprint", "placecell", "gateway")]


def frames_of(images: list[Image], role: str) -> list[Frame]:
    return [Frame(Reference(i, i), {role: Decoded(image)}) for i, image in enumerate(images)]


def signatures(system: Any, images: list[Image], role: str) -> list[Signature]:
    described = [(one.reference, system.describe(one)) for one in frames_of(images, role)]
    return list(system.assemble(iter(described)))


def recalled(system: Any, mapped: list[Signature], queries: list[Signature]) -> Any:
    memory = system.memory()
    memory.fit(mapped)
    for row, signature in enumerate(mapped):
        memory.learn(row, signature)
    return memory.recall(queries, len(mapped), None, None)[0]


def textured(seed: int) -> NDArray[np.uint8]:
    rng = np.random.default_rng(seed)
    blocks = rng.integers(0, 200, (15, 20, 3), dtype=np.uint8)
    return np.repeat(np.repeat(blocks, 16, axis=0), 16, axis=1)


@pytest.mark.parametrize("name", FORWARD)
def test_a_noisy_darker_view_is_recognised(name: str) -> None:
    kind = system_class(name)
    system = kind(kind.PRESETS["default"])
    rng = np.random.default_rng(0)
    views = [textured(seed) for seed in range(8)]
    worse = [np.clip(v * 0.97 + rng.normal(0, 2, v.shape), 0, 255).astype(np.uint8) for v in views]
    mapped = signatures(system, [Image(view) for view in views], "camera")
    found = recalled(system, mapped, signatures(system, [Image(v) for v in worse], "camera"))
    assert list(found.places[:, 0]) == list(range(8))


@pytest.mark.parametrize("name", ROUND)
@pytest.mark.parametrize("turn_deg", [-90.0, 30.0, 120.0])
def test_a_turned_panorama_is_recognised_with_its_turn(name: str, turn_deg: float) -> None:
    kind = system_class(name)
    system = kind(kind.PRESETS["default"])
    places = [(0.8, 0.1), (4.0, -2.0), (6.2, 3.0), (8.0, 0.0)]
    there = [small_world.panorama(Pose2(x, y, 0.0)) for x, y in places]
    turned = [small_world.panorama(Pose2(x, y, np.deg2rad(turn_deg))) for x, y in places]
    mapped = signatures(system, there, "panorama")
    found = recalled(system, mapped, signatures(system, turned, "panorama"))
    assert list(found.places[:, 0]) == list(range(4))
    assert np.rad2deg(found.headings_rad[:, 0]) == pytest.approx(np.full(4, turn_deg), abs=4.0)


@pytest.mark.parametrize("name", [*FORWARD, *ROUND])
def test_a_frame_without_an_image_is_ranked_last(name: str) -> None:
    kind = system_class(name)
    system = kind(kind.PRESETS["default"])
    role = "panorama" if name in ROUND else "camera"
    frames = frames_of([Image(textured(seed)) for seed in range(3)], role)
    frames[1] = Frame(frames[1].reference, {})
    described = [(one.reference, system.describe(one)) for one in frames]
    rows = list(system.assemble(iter(described)))
    found = recalled(system, rows, rows[:1])
    assert found.places[0, 0] == 0
    assert found.scores[0, list(found.places[0]).index(1)] == found.scores[0].min()


def test_k_means_finds_separate_clusters() -> None:
    rng = np.random.default_rng(2)
    centres = np.array([[0, 0], [10, 0], [0, 10]], np.float32)
    rows = np.concatenate([c + rng.normal(0, 0.1, (40, 2)) for c in centres]).astype(np.float32)
    found = k_means(rows, 3)
    gaps = np.linalg.norm(found[:, None] - centres[None], axis=2)
    assert gaps.min(axis=0).max() < 0.2


def test_an_aggregated_vector_has_length_one() -> None:
    rng = np.random.default_rng(4)
    rows = rng.normal(size=(30, 128)).astype(np.float32)
    vector = aggregated(rows, rows[:5].copy())
    assert vector.shape == (5 * 128,)
    assert np.linalg.norm(vector) == pytest.approx(1.0, abs=1e-5)


def test_epipolar_geometry_tells_the_same_view_from_another() -> None:
    kind = system_class("vlad")
    system: Any = kind(kind.PRESETS["default"])
    images = [Image(textured(1)), Image(np.roll(textured(1), 12, axis=1)), Image(textured(2))]
    same, moved, other = (row.parts["vector"] for row in signatures(system, images, "camera"))
    assert inliers(same, moved) > 3 * max(inliers(same, other), 5)
    assert inliers(same, same[:0]) == 0


@pytest.mark.parametrize("name", PEERS)
def test_sizes_and_counts_of_nothing_are_refused_where_they_are_set(name: str) -> None:
    default = system_class(name).PRESETS["default"]
    counts = [key for key, value in as_dict(default).items() if type(value) is int]
    assert counts
    for key in counts:
        with pytest.raises(UsageError, match=f"{name}.*>= 1.*{key}"):
            resolve(name, default, {name: {key: 0}})
