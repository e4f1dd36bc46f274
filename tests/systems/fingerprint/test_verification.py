"""The geometric check of laser fingerprints, in a corridor with side rooms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from helpers import small_world

from fpnav.geometry import compose, relative
from fpnav.params import resolve
from fpnav.systems.base import Verification
from fpnav.systems.fingerprint import Fingerprint, evidence
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.systems.fingerprint.verification import distinct, verified
from fpnav.values import ORIGIN, Decoded, Frame, LaserScan, Pose2, Reference, Signature

DEFAULT = Fingerprint(PRESETS["default"])
HERE = Pose2(3.0, 0.1, 0.2)
NEAR, ALONG, AWAY = Pose2(3.4, -0.1, 0.4), Pose2(2.4, 0.2, 0.1), Pose2(8.2, 0.0, 2.0)
AHEAD = Pose2(0.25, 0.05, 0.1)


def scan_at(robot: Pose2, mount: Pose2 = ORIGIN) -> LaserScan:
    scan = small_world.scan(compose(robot, mount), 180, math.pi)
    return LaserScan(
        scan.ranges_m, scan.angle_min_rad, scan.angle_increment_rad,
        scan.range_min_m, scan.range_max_m, mount,
    )  # fmt: skip


def signature_of(scan: LaserScan | None) -> Signature:
    payloads = {} if scan is None else {"scan": Decoded(scan)}
    frame = Frame(Reference(0, 0), payloads)
    return next(iter(DEFAULT.assemble([(frame.reference, DEFAULT.describe(frame))])))


def checked(query: Signature, candidates: Sequence[Signature]) -> Verification:
    found = DEFAULT.verify(query, candidates)
    assert found is not None
    return found


def test_the_same_place_is_stated_likely_and_another_is_not() -> None:
    found = checked(
        signature_of(scan_at(HERE)), [signature_of(scan_at(one)) for one in (AWAY, NEAR, ALONG)]
    )
    assert found.stated is not None
    assert found.stated[1] > 0.9
    assert found.stated[2] > 0.9
    assert found.stated[0] < 0.2
    assert np.argmin(found.scores) == 0


@pytest.mark.parametrize("there", [NEAR, ALONG])
def test_the_relative_pose_is_the_robots_whatever_the_mount(there: Pose2) -> None:
    query, candidate = (signature_of(scan_at(one, AHEAD)) for one in (HERE, there))
    pose = checked(query, [candidate]).relative[0]
    assert pose is not None
    truth = relative(there, HERE)
    assert pose.pose.x_m == pytest.approx(truth.x_m, abs=0.05)
    assert pose.pose.y_m == pytest.approx(truth.y_m, abs=0.05)
    assert pose.pose.heading_rad == pytest.approx(truth.heading_rad, abs=math.radians(1.0))


def test_the_covariance_is_one_and_wider_along_a_bare_corridor() -> None:
    bearings = np.deg2rad(np.arange(-89.5, 90.0))
    with np.errstate(divide="ignore"):
        bare = np.minimum(1.5 / np.abs(np.sin(bearings)), 12.0).astype(np.float32)
    bare[bare >= 12.0] = np.inf
    corridor = signature_of(LaserScan(bare, bearings[0], np.pi / 180, 0.05, 30.0))
    room = signature_of(scan_at(HERE))
    spread = []
    for one in (corridor, room):
        pose = checked(one, [one]).relative[0]
        assert pose is not None
        matrix = np.reshape(pose.covariance, (3, 3))
        assert matrix == pytest.approx(matrix.T)
        assert (np.linalg.eigvalsh(matrix) > 0.0).all()
        spread.append(np.sqrt(matrix[0, 0]))
    assert spread[0] > 1.0
    assert spread[1] < 0.1


def test_without_a_scan_nothing_is_checked_and_candidates_without_one_come_last() -> None:
    here, blank = signature_of(scan_at(HERE)), signature_of(None)
    assert DEFAULT.verify(blank, [here]) is None
    found = checked(here, [blank, signature_of(scan_at(NEAR))])
    assert found.relative[0] is None
    assert found.scores[0] < found.scores[1]


def test_candidates_beyond_the_number_asked_for_keep_their_order_at_the_end() -> None:
    params = DEFAULT.params.__class__(**{**_fields(), "candidates": 2})
    here = signature_of(scan_at(HERE))
    others = [signature_of(scan_at(one)) for one in (AWAY, ALONG, NEAR, HERE)]
    found = verified(here, others, params)
    assert found is not None
    assert found.scores[:2].min() > found.scores[2] > found.scores[3]
    assert found.relative[2:] == (None, None)


def _fields() -> dict[str, object]:
    params = DEFAULT.params
    return {name: getattr(params, name) for name in type(params).__struct_fields__}


def test_the_paper_preset_checks_nothing_and_keeps_no_rays() -> None:
    paper = Fingerprint(PRESETS["paper"])
    frame = Frame(Reference(0, 0), {"scan": Decoded(scan_at(HERE))})
    signature = next(iter(paper.assemble([(frame.reference, paper.describe(frame))])))
    assert len(signature.parts["rays"]) == len(signature.parts["attributes"]) == 0
    assert paper.verify(signature, [signature]) is None


def test_where_many_places_fit_the_best_is_worth_less() -> None:
    own = np.array([3.0, 1.0])
    alone, crowded = (evidence.among(own, np.array(row)) for row in ([0.0, -2.0], [1.6, 0.8]))
    assert crowded[0] < alone[0] - 2.0
    assert crowded[0] - crowded[1] == pytest.approx(2.0)  # the order is that of the overlays


def test_candidates_at_one_stretch_of_path_are_one_place() -> None:
    along = [Reference(k, k, travelled_m=m) for k, m in enumerate([0.0, 1.0, 9.0, 8.0, 20.0])]
    assert distinct(along).tolist() == [0, 2, 4]
    assert distinct(along, 2).tolist() == [0, 2]
    frames = [Reference(k, k, travelled_m=math.nan) for k in (0, 4, 30)]
    assert distinct(frames).tolist() == [0, 2]
    later = [replace(along[0], session=1), along[0]]
    assert distinct(later).tolist() == [0, 1]


def test_like_corridors_all_over_the_run_lower_what_is_stated() -> None:
    query = signature_of(scan_at(HERE))
    same = signature_of(scan_at(NEAR))
    spread = [replace(same, reference=Reference(k, k, travelled_m=9.0 * k)) for k in range(12)]
    close = [replace(same, reference=Reference(k, k, travelled_m=0.1 * k)) for k in range(12)]
    many, one = (checked(query, group).scores.max() for group in (spread, close))
    assert many < one - 3.0


def test_the_check_is_whole_only_where_no_camera_saw_anything() -> None:
    query = signature_of(scan_at(HERE))
    assert checked(query, [query]).whole
    record = query.record.copy()
    record["camera_width_rad"] = 6.28
    assert not checked(replace(query, record=record), [query]).whole


def test_with_windows_a_place_is_the_same_whatever_the_heading() -> None:
    settings = {"fingerprint": {"window_m": 3.0}}
    windows = Fingerprint(resolve("fingerprint", PRESETS["default"], settings))
    there = Pose2(HERE.x_m, HERE.y_m, HERE.heading_rad + 2.0)
    scans = [small_world.scan(pose, 360, 2 * math.pi) for pose in (HERE, there)]
    query, turned = (signature_of(scan) for scan in scans)
    found, plain = (system.verify(query, [turned]) for system in (windows, DEFAULT))
    assert found is not None
    assert plain is not None
    assert found.scores[0] > 3.0 > plain.scores[0]
