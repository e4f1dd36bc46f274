"""The grid of a scene."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.sensing.cues import CUE
from fpnav.sensing.scene import cells_of, columns_of, compatible, distance_class, facing_of


def cue(x: float, top: float, bottom: float) -> NDArray[np.void]:
    return np.array([(0, 1, x, top, bottom, 1.0, math.nan)], CUE)


def rows_of(x: float, top: float, bottom: float) -> list[int]:
    bits = int(cells_of(cue(x, top, bottom))[0])
    return [cell // 5 for cell in range(25) if bits >> cell & 1]


def test_pixel_100_lies_in_column_1() -> None:
    assert columns_of(cue(100, 0, 100)).tolist() == [1]


@pytest.mark.parametrize(("x", "column"), [(0, 0), (95.9, 0), (96, 1), (383.9, 3), (479.5, 4)])
def test_columns_are_96_pixels_wide(x: float, column: int) -> None:
    assert columns_of(cue(x, 0, 100)).tolist() == [column]


@pytest.mark.parametrize(
    ("top", "bottom", "rows"),
    [
        (0, 95, [0]),
        (0, 479, [0, 1, 2, 3, 4]),
        (48, 143, [0, 1]),
        (49, 142, [0]),
        (50, 143, [1]),
        (66, 125, [0]),
        (70, 140, [1]),
    ],
)
def test_a_cue_lies_in_the_rows_it_covers_half_of_or_most_of_none(
    top: float, bottom: float, rows: list[int]
) -> None:
    assert rows_of(100, top, bottom) == rows


def test_cells_carry_row_and_column() -> None:
    assert int(cells_of(cue(100, 192, 287))[0]) == 1 << (5 * 2 + 1)


def test_no_cues_lie_nowhere() -> None:
    none = np.zeros(0, CUE)
    assert len(cells_of(none)) == len(columns_of(none)) == 0


def test_distances_fall_into_five_classes() -> None:
    metres = np.array([1.9, 2.0, 3.9, 4.0, 8.0, 90.0, np.nan], np.float32)
    assert distance_class(metres).tolist() == [0, 1, 1, 2, 3, 3, 4]


@pytest.mark.parametrize(
    ("first", "second", "fits"),
    [
        (0.5, 1.9, False),
        (1.9, 2.1, True),
        (1.0, 2.5, False),
        (3.5, 4.5, True),
        (3.3, 4.5, False),
        (9.0, 11.9, True),
        (9.0, 70.0, False),
        (math.nan, math.nan, True),
        (math.nan, 9.0, True),
        (math.nan, 5.0, False),
    ],
)
def test_distances_are_compatible_within_a_share_and_the_unknown_may_be_far(
    first: float, second: float, fits: bool
) -> None:
    a, b = np.float32(first), np.float32(second)
    assert bool(compatible(np.array([a]), np.array([b]), 0.25)[0]) is fits
    assert bool(compatible(np.array([b]), np.array([a]), 0.25)[0]) is fits


@pytest.mark.parametrize(
    ("degrees", "facing"), [(0, 0), (22, 0), (-22, 0), (23, 1), (90, 2), (180, 4), (-90, 6)]
)
def test_a_camera_looks_in_one_of_eight_directions(degrees: float, facing: int) -> None:
    assert facing_of(math.radians(degrees)) == facing
