"""Fingerprints of a stretch of travel, all round, in a corridor with side rooms."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from helpers import small_world

from fpnav.errors import LogError
from fpnav.params import resolve
from fpnav.systems.fingerprint import Fingerprint
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.values import Decoded, Frame, Pose2, Reference, Signature

WINDOW = Fingerprint(resolve("fingerprint", PRESETS["default"], {"fingerprint": {"window_m": 3.0}}))
EAST = [Pose2(2.0 + 0.25 * k, 0.0, 0.0) for k in range(16)]


def run(poses: Sequence[Pose2], odometry: bool = True) -> list[Signature]:
    frames = []
    for k, pose in enumerate(poses):
        known = pose if odometry else None
        reference = Reference(k, k, travelled_m=0.25 * k, odometry=known)
        frames.append(Frame(reference, {"scan": Decoded(small_world.scan(pose, 180, math.pi))}))
    return list(WINDOW.assemble([(one.reference, WINDOW.describe(one)) for one in frames]))


def test_rays_go_all_round_and_say_what_was_driven_past() -> None:
    last = run(EAST)[-1]
    rays = last.parts["rays"]
    assert float(last.record["laser_width_rad"]) == pytest.approx(2 * math.pi)
    truth = small_world.scan(EAST[-1], 360, 2 * math.pi)
    aside = np.abs(np.abs(rays["bearing_rad"]) - np.deg2rad(135)) < 0.05
    wide = np.interp(rays["bearing_rad"][aside], truth.bearings_rad, truth.ranges_m)
    known = rays["range_m"][aside] > 0.0
    assert known.mean() > 0.4
    assert np.median(np.abs(rays["range_m"][aside] - wide)[known]) < 0.2


def test_the_first_scan_of_a_run_knows_nothing_of_what_is_behind() -> None:
    rays = run(EAST[:1])[0].parts["rays"]
    behind = np.abs(rays["bearing_rad"]) > np.deg2rad(95)
    assert (rays["range_m"][behind] == 0.0).all()


def test_without_odometry_it_is_said_what_is_missing() -> None:
    with pytest.raises(LogError, match=r"window_m joins scans by odometry"):
        run(EAST, odometry=False)
