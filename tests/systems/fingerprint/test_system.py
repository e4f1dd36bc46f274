"""The fingerprint system as the pipeline sees it."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from helpers import small_world

from fpnav.systems.base import MapRule
from fpnav.systems.fingerprint import Fingerprint, FingerprintParams
from fpnav.systems.fingerprint.params import LATE, PRESETS
from fpnav.systems.fingerprint.record import arcs_of
from fpnav.values import Frame, Pose2, Reference

POSE = Pose2(4.0, 0.2, 0.3)


def test_presets_are_the_papers_algorithm_and_ours() -> None:
    assert set(PRESETS) == {"paper", "default"}
    paper = PRESETS["paper"]
    assert (paper.gamma, paper.cuts, paper.delta_n_deg) == (0.5, "all", 20.0)
    assert PRESETS["default"].cuts == "view"


def test_late_parameters_exist_and_those_of_extraction_are_not_among_them() -> None:
    fields = set(FingerprintParams.__struct_fields__)
    assert fields >= LATE
    early = {"use_laser", "use_camera", "laser_fov_deg", "white_balance", "pair_deg"}
    early |= {"delta_n_deg", "certainty_n"}
    assert not LATE & early


def test_unknown_parameters_are_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="thta"):
        msgspec.convert({"thta": 0.5}, FingerprintParams)
    assert msgspec.convert({"theta": "auto"}, FingerprintParams).theta == "auto"


def test_the_rule_and_the_thinning_are_the_parameters() -> None:
    system = Fingerprint(FingerprintParams(theta="auto", nodes=20, min_node_obs=1, step_m=0.3))
    assert system.rule == MapRule("auto", 20, 1)
    assert system.thinning.step_m == 0.3


def test_a_fingerprint_stands_for_every_frame_with_its_record() -> None:
    system = Fingerprint(PRESETS["paper"])
    frames = small_world.route(5, ["panorama", "scan"])
    found = list(system.assemble((one.reference, system.describe(one)) for one in frames))
    assert [one.reference.index for one in found] == [0, 1, 2, 3, 4]
    for one in found:
        letters = one.parts["symbols"]["type"].tolist()
        record = one.record
        assert record["corners"] == letters.count(b"c")
        assert record["edges"] == letters.count(b"v")
        assert record["correspondences"] == letters.count(b"f")
        assert record["empty"] == letters.count(b"n")
        assert record["features"] == len(one.parts["features"])
        assert record["colours"] == record["features"] - record["corners"] - record["edges"]
        assert arcs_of(one)[:, 1] == pytest.approx([2.0 * math.pi] * 2)


def test_the_picture_is_a_strip_with_the_readable_string() -> None:
    system = Fingerprint(PRESETS["paper"])
    frame = small_world.frame(0, POSE, ["panorama", "scan"])
    one = next(system.assemble([(frame.reference, system.describe(frame))]))
    picture = system.picture(one)
    assert picture.kind == "strip"
    assert "".join(picture.symbols) == picture.text
    assert len(picture.text) == len(one.parts["symbols"])
    assert np.array_equal(picture.bearings_rad, one.parts["symbols"]["angle_rad"])


def test_nothing_sensed_makes_an_empty_fingerprint() -> None:
    system = Fingerprint(PRESETS["paper"])
    frame = Frame(Reference(3, 3), {})
    one = next(system.assemble([(frame.reference, system.describe(frame))]))
    assert system.picture(one).text == ""
    assert system.similarity(one, one) == 0.0  # nothing matches nothing by nought


def test_near_fingerprints_are_more_alike_than_far_ones() -> None:
    system = Fingerprint(PRESETS["paper"])
    poses = [Pose2(2.0 + step, 0.0, 0.0) for step in (0.0, 0.1, 0.2, 0.3, 4.5, 6.0)]
    frames = [small_world.frame(0, pose, ["panorama", "scan"]) for pose in poses]
    signatures = list(system.assemble((one.reference, system.describe(one)) for one in frames))
    values = [system.similarity(signatures[0], other) for other in signatures]
    assert values[0] == 1.0
    assert min(values[1:4]) > max(values[4:]) + 0.1
