"""Writes a run as a recorder would: state at its rate, data sets between, truth beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fpnav.logs.writer import LogWriter
from fpnav.sim.motion import TICK_S
from fpnav.sim.rig import Rig, calibrations, mounts
from fpnav.sim.sense import Reading
from fpnav.sim.truth import Labels, world_json
from fpnav.sim.world import Route, World
from fpnav.values import Pose2

START_NS = 1_100_000_000 * 10**9
DAY_NS = 86_400 * 10**9


class Journal:
    """The log of one run: open it, add states and readings in the order of time, close it."""

    def __init__(self, log: LogWriter, world: World, route: Route, rig: Rig) -> None:
        self.log, self.world, self.route, self.rig = log, world, route, rig
        self.zero_ns = START_NS + world.run * DAY_NS
        self._labels, self._label = Labels(world, route), ""

    def ns(self, time_s: float) -> int:
        """Stamp of a time of the run."""
        return self.zero_ns + round(time_s * 1e9)

    def begin(self) -> None:
        """Mounts and calibrations."""
        self.log.static_transforms(self.zero_ns, mounts(self.rig))
        for role, calibration in calibrations(self.rig):
            self.log.camera_info(role, self.zero_ns, calibration)

    def state(
        self,
        tick: int,
        truth: Pose2,
        odometry: Pose2,
        speeds: tuple[float, float],
        heading_rad: float,
    ) -> None:
        """Odometry, compass, truth and, where it changes, the label, at a tick."""
        stamp = self.ns(tick * TICK_S)
        label = self._labels.at(truth.x_m, truth.y_m)
        if label and label != self._label:
            self.log.label(stamp, label)
            self._label = label
        self.log.odometry(stamp, odometry, *speeds)
        self.log.heading(stamp, heading_rad)
        self.log.truth(stamp, truth)

    def command(self, time_s: float, linear_mps: float, angular_radps: float) -> None:
        """What a policy asked for."""
        self.log.command(self.ns(time_s), linear_mps, angular_radps)

    def readings(self, readings: Sequence[tuple[Reading, bytes | None]]) -> None:
        """Readings, images with their encoded bytes."""
        for reading, encoded in readings:
            self._reading(reading, encoded)

    def _reading(self, reading: Reading, encoded: bytes | None) -> None:
        stamp = self.ns(reading.time_s)
        if encoded is not None:
            self.log.image(reading.role, stamp, encoded)
            return
        writers: dict[str, Any] = {
            "scan": self.log.scan,
            "sonar": self.log.sonar,
            "pan": self.log.pan,
        }
        writers[reading.role](stamp, reading.value)

    def finish(self) -> None:
        """Attach what poses do not tell."""
        data = world_json(self.world, self.route.name)
        self.log.attach("world.json", "application/json", data)
