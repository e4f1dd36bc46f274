"""Landmark recognition: eq. 1 and the competition, worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.matching.patches import Patches
from fpnav.systems.placecell.landmarks import level, recognise, reusable, sad_limit
from fpnav.systems.placecell.params import PlacecellParams

SMALL = PlacecellParams(patch_rows=4, patch_columns=4, interpretations=2)


def flat(*levels: int) -> Patches:
    """Views of one grey level each."""
    return Patches.of(np.repeat(np.array(levels, np.uint8), 16).reshape(-1, 16), 4, 4)


@pytest.mark.parametrize(
    ("difference", "wanted"), [(0.0, 1.0), (0.1, 0.5), (0.2, 0.0), (0.15, 0.25), (0.7, 0.0)]
)
def test_recognition_of_equation_1(difference: float, wanted: float) -> None:
    assert level(np.array([difference * 255 * 1024]), 1024, 0.8)[0] == pytest.approx(wanted)


def test_without_threshold_the_level_is_the_likeness() -> None:
    assert level(np.array([51.0 * 16]), 16, 0.0)[0] == pytest.approx(0.8)


@pytest.mark.parametrize("pixels", [16, 256, 1024])
@pytest.mark.parametrize("threshold", [0.0, 0.6, 0.8, 0.9])
def test_the_limit_is_the_least_sad_without_recognition(pixels: int, threshold: float) -> None:
    limit = sad_limit(pixels, threshold)
    assert level(np.array([limit]), pixels, threshold)[0] == pytest.approx(0.0, abs=1e-9)
    assert level(np.array([limit - 1]), pixels, threshold)[0] > 0.0


def test_soft_competition_keeps_the_best_above_the_threshold() -> None:
    found = recognise(flat(100), flat(100, 110, 120, 200), SMALL)
    assert found.landmark.tolist() == [0, 1]
    assert found.level == pytest.approx([1.0, 1.0 - 10 / 51])


def test_strict_competition_keeps_one() -> None:
    strict = PlacecellParams(patch_rows=4, patch_columns=4, interpretations=1)
    found = recognise(flat(100, 121), flat(100, 110, 120), strict)
    assert found.view.tolist() == [0, 1]
    assert found.landmark.tolist() == [0, 2]


def test_equal_landmarks_compete_by_their_order() -> None:
    found = recognise(flat(50), flat(60, 60, 60), SMALL)
    assert found.landmark.tolist() == [0, 1]


def test_a_view_like_nothing_has_no_interpretation() -> None:
    found = recognise(flat(10), flat(100, 200), SMALL)
    assert len(found.level) == 0


def test_landmarks_that_take_no_part_leave_room_for_others() -> None:
    allowed = np.array([False, True, True])
    found = recognise(flat(100), flat(100, 101, 102), SMALL, allowed)
    assert found.landmark.tolist() == [1, 2]


def test_without_reuse_every_view_is_new() -> None:
    assert reusable(flat(100), flat(100), SMALL).tolist() == [-1]


def test_a_view_at_the_vigilance_reuses_its_landmark() -> None:
    params = PlacecellParams(patch_rows=4, patch_columns=4, reuse=True, reuse_vigilance=0.9)
    assert reusable(flat(100, 126, 125), flat(0, 100), params).tolist() == [1, -1, 1]
