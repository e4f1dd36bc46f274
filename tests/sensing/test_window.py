"""Scans all round from the scans of a stretch of travel."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.sensing.window import BEAMS, all_round, carried
from fpnav.values import Pose2

AHEAD = np.full(181, 3.0)
START, STEP = -np.pi / 2, np.pi / 180


def test_the_present_scan_is_kept_and_what_lies_behind_comes_from_the_past() -> None:
    behind = np.array([[-2.0, 0.0], [-4.0, 0.0], [1.0, 0.0]])
    scan = all_round(AHEAD, START, STEP, behind)
    assert scan.ranges_m[BEAMS // 2] == pytest.approx(3.0)  # not the 1 m of a scan gone by
    assert scan.ranges_m[0] == pytest.approx(2.0)  # the nearer of the two behind
    assert np.isnan(scan.ranges_m[10])  # 170 degrees to the right: nobody looked there
    assert scan.field_of_view_rad == pytest.approx(2 * np.pi)


def test_beams_of_the_present_that_say_nothing_are_filled_from_the_past() -> None:
    unknown = AHEAD.copy()
    unknown[90] = 0.0
    scan = all_round(unknown, START, STEP, np.array([[2.5, 0.0]]))
    assert scan.ranges_m[BEAMS // 2] == pytest.approx(2.5)


def test_hits_are_carried_into_the_frame_of_the_present_pose() -> None:
    here = Pose2(1.0, 0.0, np.pi / 2)
    found = carried([np.array([[2.0, 0.0]])], [Pose2(0.0, 1.0, 0.0)], here)
    np.testing.assert_allclose(found, [[1.0, -1.0]], atol=1e-12)
    assert carried([], [], here).shape == (0, 2)
