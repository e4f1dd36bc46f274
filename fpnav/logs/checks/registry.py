"""Every assumption a stage makes of a log, as a named check; a new one is one line."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from fpnav.logs.checks import files, poses, sensors, times
from fpnav.logs.checks.finding import Finding
from fpnav.logs.frames import Log
from fpnav.logs.ledger import Budget

Check = Callable[[Log, Budget], Iterator[Finding]]

CHECKS: tuple[Check, ...] = (
    files.container,
    files.losses,
    files.decodable,
    files.definitions,
    files.roles_present,
    files.choices,
    times.clock,
    times.order,
    times.stamps_against_log_time,
    times.rates,
    times.gaps,
    times.joined,
    sensors.frames_of_reference,
    sensors.calibration,
    sensors.images,
    sensors.scans,
    sensors.sonar,
    poses.covered,
    poses.motion,
    poses.odometry_against_truth,
    files.labels,
)


def check_log(log: Log, budget: Budget) -> list[Finding]:
    """Findings of every check, in the order of the table."""
    return [finding for check in CHECKS for finding in check(log, budget)]
