"""The metric of fingerprints with attributes, in a corridor with side rooms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import small_world

from fpnav.matching.attributed import SYMBOL
from fpnav.sensing.rays import rays_of
from fpnav.systems.fingerprint import Fingerprint
from fpnav.systems.fingerprint.attributed import Attributed
from fpnav.systems.fingerprint.laser import CORNER, EMPTY
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.values import LaserScan, Pose2, Signature

DEFAULT = Fingerprint(PRESETS["default"])
METRIC = Attributed(PRESETS["default"])
PLACES = (Pose2(3.0, 0.1, 0.2), Pose2(3.3, 0.0, 0.4), Pose2(8.2, 0.0, 2.0))


def seen(pose: Pose2, roles: tuple[str, ...] = ("scan",)) -> Signature:
    frame = small_world.frame(0, pose, roles)
    return next(iter(DEFAULT.assemble([(frame.reference, DEFAULT.describe(frame))])))


def test_symbols_are_corners_with_range_and_the_depth_of_what_is_empty() -> None:
    rows = seen(PLACES[0]).parts["attributes"]
    assert rows.dtype == SYMBOL
    assert (np.diff(rows["angle_rad"]) >= 0.0).all()
    assert (rows["kind"] == EMPTY).sum() == 36
    corners = seen(PLACES[0]).parts["features"]
    assert (rows["kind"] == CORNER).sum() == (corners["type"] == b"c").sum()
    assert np.exp(rows["log_range"]).max() < 9.0


def test_the_nearer_place_scores_higher_and_tells_the_turn() -> None:
    found = [METRIC.descriptor(seen(one), {}) for one in PLACES]
    scores, turns = METRIC.compare(found[0], METRIC.stack(found[1:]), np.arange(2), {})
    assert scores[0] > scores[1]
    assert turns[0] == pytest.approx(-0.2, abs=math.radians(6.0))


def test_channels_count_where_both_have_them() -> None:
    laser, camera = seen(PLACES[0]), seen(PLACES[0], ("panorama",))
    both = seen(PLACES[0], ("scan", "panorama"))
    found = [METRIC.descriptor(one, {}) for one in (laser, camera, both)]
    scores, _ = METRIC.compare(found[0], METRIC.stack(found), np.arange(3), {})
    assert scores[0] == pytest.approx(scores[2])
    assert scores[1] == 0.0
    assert METRIC.likeness(found[0], found[1], {}) == 0.0
    assert METRIC.likeness(found[0], found[2], {}) == pytest.approx(1.0)


def test_rays_are_thinned_turned_left_and_say_what_is_unknown() -> None:
    ranges = np.array([1.0, 2.0, np.inf, np.nan, -np.inf, 5.0, 90.0], np.float32)
    scan = LaserScan(ranges, 0.3, -math.radians(0.5), 0.1, 30.0, Pose2(0.0, 0.0, 0.5))
    rays = rays_of(scan, math.radians(0.5))
    assert (np.diff(rays["bearing_rad"]) > 0.0).all()
    assert rays["bearing_rad"][-1] == pytest.approx(0.8)
    assert rays["range_m"][::-1].tolist() == [1.0, 2.0, np.inf, 0.0, 0.0, 5.0, 0.0]
    assert len(rays_of(scan, math.radians(1.0))) == 4


def test_lasers_alone_are_remembered_by_members_and_others_by_means() -> None:
    laser = [seen(one) for one in PLACES]
    both = [seen(one, ("scan", "panorama")) for one in PLACES]
    for signatures, members in ((laser, True), (both, False)):
        memory = DEFAULT.memory()
        memory.fit(signatures)
        memory.learn(0, signatures[0])
        state = memory.save()
        assert bool(state["members"][0]) is members
        other = DEFAULT.memory()
        other.load(state)
        found = [one.recall(signatures[:1], 1, None, None)[0].scores for one in (memory, other)]
        assert found[0].tobytes() == found[1].tobytes()
        assert bool(found[0][0, 0] > 1.0 + 1e-9) is members
