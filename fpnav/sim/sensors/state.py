"""Odometry that drifts and slips, and a compass with a bias and an indoor disturbance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fpnav.params import Params
from fpnav.sim.motion import TICK_S, Track
from fpnav.sim.seeds import generator
from fpnav.values import FloatArray


class Drift(Params, frozen=True):
    """Errors of dead reckoning, each drawn anew for every run.

    Variances grow with travel: after D metres the heading has variance
    ``heading_deg_per_sqrt_m ** 2 * D`` (plus the turning share), the distance ``along ** 2 * D``.
    """

    along_m_per_sqrt_m: float = 0.01
    scale: float = 0.01
    heading_deg_per_sqrt_m: float = 0.5
    heading_share: float = 0.01
    slips_per_m: float = 0.01
    slip_m: float = 0.06
    slip_deg: float = 2.5


class Magnetism(Params, frozen=True):
    """Errors of the compass; the disturbance belongs to the place and stays from run to run."""

    bias_deg: float = 2.0
    noise_deg: float = 1.0
    disturbance_deg: float = 4.0
    disturbance_m: float = 4.0


def compass_of(magnetism: Magnetism, seed: int, run: int) -> Compass:
    """The compass as it is in a world on a run."""
    return Compass(magnetism, generator(seed, "magnetism"), generator(seed, run, "compass"))


class Encoders:
    """Wheel encoders of one run: what they make of the way really gone."""

    def __init__(self, drift: Drift, rng: np.random.Generator) -> None:
        self.drift, self.rng = drift, rng
        self.scale = 1.0 + drift.scale * rng.standard_normal()
        self.gain = 1.0 + drift.heading_share * rng.standard_normal()

    def measure(self, steps_m: FloatArray, turns_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Measured steps and turns of N ticks, (N,) each."""
        drift, count, root = self.drift, len(steps_m), np.sqrt(np.abs(steps_m))
        noise, wander, slide, twist = self.rng.standard_normal((4, count))
        slipped = self.rng.random(count) < drift.slips_per_m * np.abs(steps_m)
        along = steps_m * self.scale + drift.along_m_per_sqrt_m * root * noise
        along = along + slipped * drift.slip_m * slide
        turned = turns_rad * self.gain + math.radians(drift.heading_deg_per_sqrt_m) * root * wander
        return along, turned + slipped * math.radians(drift.slip_deg) * twist


def odometry(track: Track, drift: Drift, rng: np.random.Generator) -> FloatArray:
    """Dead-reckoned poses (N, 3), beginning at the origin, one for each row of the track."""
    steps, turns = track.speeds[1:, 0] * TICK_S, track.speeds[1:, 1] * TICK_S
    return dead_reckon(*Encoders(drift, rng).measure(steps, turns))


def dead_reckon(
    along_m: FloatArray, turned_rad: FloatArray, start: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Poses (N + 1, 3) reached by N steps, each along the middle of its turn."""
    x, y, heading = start
    headings = heading + np.concatenate([[0.0], np.cumsum(turned_rad)])
    middle = headings[:-1] + turned_rad / 2
    xs = x + np.concatenate([[0.0], np.cumsum(along_m * np.cos(middle))])
    ys = y + np.concatenate([[0.0], np.cumsum(along_m * np.sin(middle))])
    return np.column_stack([xs, ys, headings])


class Compass:
    """Compass of one run; ``place`` fixes the disturbance, ``run`` the bias and the noise."""

    def __init__(
        self, magnetism: Magnetism, place: np.random.Generator, run: np.random.Generator
    ) -> None:
        self.magnetism, self.run = magnetism, run
        self.angles, self.phases = place.uniform(0.0, 2 * math.pi, (2, 6))
        self.waves = 2 * math.pi / (magnetism.disturbance_m * place.uniform(0.7, 2.0, 6))
        self.bias_deg = magnetism.bias_deg * run.standard_normal()

    def read(self, poses: FloatArray) -> NDArray[np.float64]:
        """Measured headings (N,) at true poses (N, 3)."""
        along = np.outer(poses[:, 0], np.cos(self.angles))
        along = along + np.outer(poses[:, 1], np.sin(self.angles))
        field = np.sin(along * self.waves + self.phases).sum(axis=1) / math.sqrt(3.0)
        error = self.bias_deg + self.magnetism.disturbance_deg * field
        error = error + self.magnetism.noise_deg * self.run.standard_normal(len(poses))
        return np.asarray(poses[:, 2] + np.radians(error))
