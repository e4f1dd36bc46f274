"""Odometry and compass: errors of the size asked for, and none where none was asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fpnav.geometry import wrap_array
from fpnav.sim.motion import TICK_S, Track, track_of
from fpnav.sim.seeds import generator
from fpnav.sim.sensors import state
from fpnav.sim.sensors.state import Drift, Magnetism

RUNS = 400
NONE = Drift(
    along_m_per_sqrt_m=0.0,
    scale=0.0,
    heading_deg_per_sqrt_m=0.0,
    heading_share=0.0,
    slips_per_m=0.0,
)


def straight(length_m: float, speed: float = 0.5) -> Track:
    ticks = round(length_m / speed / TICK_S)
    return track_of(
        [(k * speed * TICK_S, 0.0, 0.0, speed * (k > 0), 0.0) for k in range(ticks + 1)]
    )


def ends(drift: Drift, track: Track) -> np.ndarray:
    """Last dead-reckoned poses of many runs, (RUNS, 3)."""
    return np.array([state.odometry(track, drift, generator(run))[-1] for run in range(RUNS)])


def within(sample: np.ndarray, sigma: float) -> bool:
    """Whether the variance is the one asked for, at 3.5 standard errors of a variance."""
    error = 3.5 * math.sqrt(2.0 / len(sample))
    return abs(np.var(sample) / sigma**2 - 1.0) < error


def test_without_errors_odometry_is_the_way_gone() -> None:
    turns = [(0.0, 0.0, 0.0, 0.0, 0.0)]
    heading, x, y = 0.0, 0.0, 0.0
    for k in range(200):
        angular = 0.6 * math.sin(k / 20)
        middle = heading + angular * TICK_S / 2
        x, y = x + 0.02 * math.cos(middle), y + 0.02 * math.sin(middle)
        heading += angular * TICK_S
        turns.append((x, y, heading, 0.02 / TICK_S, angular))
    track = track_of(turns)
    np.testing.assert_allclose(state.odometry(track, NONE, generator(1)), track.poses, atol=1e-9)


def test_heading_drifts_with_the_variance_asked_for() -> None:
    drift = Drift(
        along_m_per_sqrt_m=0.0,
        scale=0.0,
        heading_deg_per_sqrt_m=0.8,
        heading_share=0.0,
        slips_per_m=0.0,
    )
    heading = ends(drift, straight(25.0))[:, 2]
    assert within(heading, math.radians(0.8) * 5.0)
    assert abs(heading.mean()) < 4.0 * math.radians(0.8) * 5.0 / math.sqrt(RUNS)


def test_distance_drifts_with_the_variance_asked_for() -> None:
    drift = Drift(
        along_m_per_sqrt_m=0.03,
        scale=0.0,
        heading_deg_per_sqrt_m=0.0,
        heading_share=0.0,
        slips_per_m=0.0,
    )
    assert within(ends(drift, straight(16.0))[:, 0], 0.03 * 4.0)


def test_the_wheels_scale_is_off_by_the_share_asked_for() -> None:
    drift = Drift(
        along_m_per_sqrt_m=0.0,
        scale=0.02,
        heading_deg_per_sqrt_m=0.0,
        heading_share=0.0,
        slips_per_m=0.0,
    )
    assert within(ends(drift, straight(10.0))[:, 0], 0.2)


def test_slips_come_as_often_as_asked() -> None:
    drift = Drift(
        along_m_per_sqrt_m=0.0,
        scale=0.0,
        heading_deg_per_sqrt_m=0.0,
        heading_share=0.0,
        slips_per_m=0.5,
        slip_m=0.0,
        slip_deg=2.0,
    )
    # A compound Poisson sum: variance = expected slips times the variance of one.
    heading = ends(drift, straight(20.0))[:, 2]
    assert np.var(heading) == pytest.approx(10.0 * math.radians(2.0) ** 2, rel=0.3)


def test_variance_grows_in_proportion_to_travel() -> None:
    drift = Drift(scale=0.0, heading_share=0.0, slips_per_m=0.0)
    short, long = (np.var(ends(drift, straight(d))[:, 2]) for d in (5.0, 20.0))
    assert long / short == pytest.approx(4.0, rel=0.35)


POSES = np.column_stack([np.linspace(0, 20, 500), np.zeros(500), np.linspace(0, 3, 500)])


def errors_deg(magnetism: Magnetism, seed: int, run: int) -> np.ndarray:
    read = state.compass_of(magnetism, seed, run).read(POSES)
    return np.degrees(wrap_array(read - POSES[:, 2]))


def test_a_faultless_compass_tells_the_heading() -> None:
    perfect = Magnetism(bias_deg=0.0, noise_deg=0.0, disturbance_deg=0.0)
    np.testing.assert_allclose(errors_deg(perfect, 1, 1), 0.0, atol=1e-9)


def test_the_disturbance_belongs_to_the_place_and_the_bias_to_the_run() -> None:
    quiet = Magnetism(noise_deg=0.0)
    first, second = errors_deg(quiet, 1, 1), errors_deg(quiet, 1, 2)
    assert np.ptp(first - second) < 1e-9
    assert abs((first - second)[0]) > 1e-3
    assert np.ptp(errors_deg(quiet, 2, 1) - first) > 1.0


def test_the_disturbance_has_the_size_asked_for() -> None:
    quiet = Magnetism(noise_deg=0.0, bias_deg=0.0, disturbance_deg=4.0)
    spread = np.sqrt(np.mean([np.mean(errors_deg(quiet, seed, 1) ** 2) for seed in range(60)]))
    assert spread == pytest.approx(4.0, rel=0.15)


def test_compass_noise_has_the_spread_asked_for() -> None:
    noisy = Magnetism(bias_deg=0.0, disturbance_deg=0.0, noise_deg=2.0)
    assert np.std(errors_deg(noisy, 1, 1)) == pytest.approx(2.0, rel=0.1)
