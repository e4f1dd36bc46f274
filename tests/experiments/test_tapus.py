"""Parts of the reproduction of Tapus et al. that can be held against known answers."""

from __future__ import annotations

import numpy as np
import pytest

from fpnav.evaluation.calibration import calibration_error, skill
from fpnav.execution.walk import Run, make_system
from fpnav.experiments.registry import STUDIES, study_of
from fpnav.experiments.tapus.beyond import _crossing, blinded, moved_apart
from fpnav.experiments.tapus.office import choice, kidnapped, sampled
from fpnav.store.signatures import collect
from fpnav.store.tables import SignatureTable
from fpnav.systems.fingerprint.record import record_of
from fpnav.systems.fingerprint.symbols import FEATURE
from fpnav.values import Reference, Signature


@pytest.mark.parametrize("name", STUDIES)
def test_every_claim_belongs_to_an_experiment_with_a_title(name: str) -> None:
    study = study_of(name)
    assert {claim.experiment for claim in study.claims} <= set(study.experiments)
    assert set(study.heading.titles) == set(study.experiments)


def test_moving_no_feature_changes_nothing_and_moving_them_far_does() -> None:
    system, _ = make_system(choice())
    seen = signature(0, 12)
    assert system.similarity(seen, moved_apart(seen, 0.0)) == pytest.approx(1.0)
    near, far = (system.similarity(seen, moved_apart(seen, by)) for by in (0.02, 1.0))
    assert near > far


def test_a_blinded_run_sees_nothing_on_the_last_metres_of_each_stretch() -> None:
    run, unlit = blinded(small_run(60, step_m=0.5), 2.0)
    sizes = np.array([len(row.parts["features"]) for row in run.table])
    travelled = run.table.references["travelled_m"]
    assert (sizes[travelled % 12.0 >= 10.0] == 0).all()
    assert (sizes[travelled % 12.0 < 10.0] > 0).all()
    assert unlit.tolist() == (sizes == 0).tolist()
    assert (run.table.records["laser_width_rad"][sizes == 0] == 0.0).all()


def test_a_sampled_run_keeps_its_ends_and_even_steps() -> None:
    assert sampled(small_run(10), 4).table.references["index"].tolist() == [0, 3, 6, 9]
    assert len(sampled(small_run(3), 40).table) == 3


def test_a_kidnapped_run_is_all_of_it_in_another_order_and_its_path_counts_on() -> None:
    run, rows = kidnapped(small_run(12, step_m=0.5), 2)
    moved = run.table.references
    assert moved["index"].tolist() == rows.tolist()
    assert moved["index"].tolist() == [0, 1, 2, 3, 8, 9, 10, 11, 4, 5, 6, 7]
    assert moved["travelled_m"].tolist() == [0, 0.5, 1, 1.5, 1.5, 2, 2.5, 3, 3, 3.5, 4, 4.5]


def test_a_falling_curve_crosses_between_its_points_or_at_its_end() -> None:
    x = np.array([0.0, 10.0, 20.0])
    assert _crossing(x, np.array([1.0, 0.6, 0.2]), 0.5) == pytest.approx(12.5)
    assert _crossing(x, np.array([1.0, 0.9, 0.8]), 0.5) == 20.0


def test_calibration_of_plain_probabilities() -> None:
    right = np.array([True, True, False, False])
    assert calibration_error(right.astype(float), right) == 0.0
    assert skill(right.astype(float), right) == pytest.approx(1.0)
    assert calibration_error(np.full(4, 0.9), right) == pytest.approx(0.4)
    assert skill(np.full(4, 0.5), right) == pytest.approx(0.0)


def signature(index: int, count: int) -> Signature:
    """Edges all round, a corner at every third, as sure as they come."""
    features = np.zeros(count, FEATURE)
    features["type"] = np.where(np.arange(count) % 3 == 0, b"c", b"v")
    features["angle_rad"] = np.arange(count) * 2 * np.pi / count + 0.01 * index
    features["certainty"] = 0.9
    arcs = np.array([[0.0, 2 * np.pi], [0.0, 2 * np.pi]])
    reference = Reference(index, index, travelled_m=0.0)
    return Signature(reference, record_of(arcs, b""), {"features": features})


def small_run(count: int, step_m: float = 0.2) -> Run:
    system, preset = make_system(choice())
    rows = [signature(i, 12) for i in range(count)]
    table: SignatureTable = collect(rows, system.RECORD, {"features": FEATURE})
    table.references["travelled_m"] = np.arange(count) * step_m
    return Run({"preset": preset}, table, system)
