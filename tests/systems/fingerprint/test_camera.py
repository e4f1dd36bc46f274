"""Strips of a camera alone: the place and the turn are found, through save and load."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import small_world

from fpnav.systems.fingerprint import Fingerprint
from fpnav.systems.fingerprint.camera import AHEAD, AROUND
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.values import Frame, Pose2, Signature

DEFAULT = Fingerprint(PRESETS["default"])


def run_of(frames: list[Frame]) -> list[Signature]:
    return list(DEFAULT.assemble((one.reference, DEFAULT.describe(one)) for one in frames))


@pytest.mark.parametrize(("role", "count"), [("panorama", AROUND), ("camera", AHEAD)])
def test_a_run_is_found_again(role: str, count: int) -> None:
    poses = [Pose2(0.6 + 0.4 * i, 0.0, 0.0) for i in range(20)]
    moved = [Pose2(p.x_m + 0.03, 0.02, np.deg2rad(4.0)) for p in poses]
    mapped, asked = (
        run_of([small_world.frame(i, pose, [role]) for i, pose in enumerate(group)])
        for group in (poses, moved)
    )
    assert len(mapped[0].parts["strips"]) == count
    memory, other = DEFAULT.memory(), DEFAULT.memory()
    memory.fit(mapped)
    for row, signature in enumerate(mapped):
        memory.learn(row, signature)
    found, _ = memory.recall(asked, 3, None, None)
    assert np.mean(np.abs(found.places[:, 0] - np.arange(20)) <= 1) > 0.85
    other.load(memory.save())
    again, _ = other.recall(asked, 3, None, None)
    assert np.array_equal(again.scores, found.scores)
    if role == "panorama":
        assert np.rad2deg(np.median(found.headings_rad[:, 0])) == pytest.approx(4.0, abs=2.5)


def test_likeness_is_symmetric_one_for_equal_and_less_for_another() -> None:
    near, same, far = run_of(
        [
            small_world.frame(i, pose, ["panorama"])
            for i, pose in enumerate([Pose2(1, 0, 0), Pose2(1, 0, 1.0), Pose2(8, 0, 0)])
        ]
    )
    assert DEFAULT.similarity(near, near) == pytest.approx(1.0)
    assert DEFAULT.similarity(near, same) > DEFAULT.similarity(near, far) + 0.2
    assert DEFAULT.similarity(near, far) == pytest.approx(DEFAULT.similarity(far, near))


def test_with_a_laser_no_strips_are_kept() -> None:
    (both,) = run_of([small_world.frame(0, Pose2(1, 0, 0), ["panorama", "scan"])])
    assert len(both.parts["strips"]) == 0
    assert len(both.parts["rays"]) > 0
