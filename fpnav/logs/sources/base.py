"""What a source of recordings is: a module that turns one foreign format into items.

An item is one message of a standard topic. Sources yield items as they read, in time order
within a role, and count what they cannot use in the ledger; they never write.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from fpnav.logs.ledger import Ledger
from fpnav.logs.roles import natural
from fpnav.logs.writer import LogWriter
from fpnav.values import Calibration, LaserScan, Pose2, SonarRing

Poses = Literal["auto", "truth", "odometry"]


@dataclass(frozen=True, slots=True)
class Picture:
    """One image as JPEG, PNG or WebP bytes; ``format`` names which."""

    data: bytes
    format: str


@dataclass(frozen=True, slots=True)
class Motion:
    """Odometry with its speeds."""

    pose: Pose2
    linear_mps: float = 0.0
    angular_radps: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Echo:
    """One reading of one transducer of a ring; ``ring`` is a ring of one."""

    number: int
    ring: SonarRing


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """One message: a role of values.ROLES (or ``calibration:ROLE``), its stamp and its value.

    Values: Picture for camera roles, LaserScan, SonarRing or Echo, Motion (odometry), Pose2
    (truth), float (heading, pan), str (label), Calibration, and bytes for role ``world``: what a
    simulated log says of its world, carried on as it is. ``log_ns`` is the log time where the
    source has one.
    """

    role: str
    stamp_ns: int
    value: Any
    log_ns: int | None = None


NOT_CALIBRATED = Calibration(0, 0)

WORLD = "world.json"
"""Attachment that says what cannot be read from poses, and that the log is simulated."""


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """What the user said about a recording.

    ``poses`` : what the poses of a CARMEN or g2o log are. ``role`` : what the images are.
    ``calibration`` : what the recording lacks, its size is not used. ``topics`` : role -> topic.
    """

    poses: Poses = "auto"
    role: str = ""
    calibration: Calibration = NOT_CALIBRATED
    topics: Mapping[str, str] = field(default_factory=dict)

    @property
    def calibrated(self) -> bool:
        """Whether the user gave any calibration."""
        given = (getattr(self.calibration, entry.name) for entry in fields(self.calibration))
        return any(isinstance(value, float) and not math.isnan(value) for value in given)

    def calibration_for(self, width: int, height: int) -> Calibration:
        """The given calibration for images of a size."""
        return replace(self.calibration, width_px=width, height_px=height)


class Source(Protocol):
    """A module of fpnav.logs.sources."""

    SUMMARY: str

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file (its first 4 KiB) or folder (no bytes) is of this format."""
        ...

    def read(self, paths: Sequence[Path], options: SourceOptions, ledger: Ledger) -> Iterator[Item]:
        """Items of one recording, which may have several files.

        Raises
        ------
        LogError
            The recording cannot be used at all.
        """
        ...


def write_item(writer: LogWriter, item: Item) -> None:
    """Write an item to its standard topic."""
    role, value, log_ns = item.role, item.value, item.log_ns
    if isinstance(value, bytes):
        writer.attach(WORLD, "application/json", value)
    elif isinstance(value, Picture):
        writer.image(role, item.stamp_ns, value.data, value.format, log_ns=log_ns)
    elif isinstance(value, Calibration):
        writer.camera_info(role.partition(":")[2], item.stamp_ns, value, log_ns=log_ns)
    elif isinstance(value, LaserScan):
        writer.scan(item.stamp_ns, value, log_ns=log_ns)
    elif isinstance(value, SonarRing):
        writer.sonar(item.stamp_ns, value, log_ns=log_ns)
    elif isinstance(value, Echo):
        writer.echo(item.stamp_ns, value.number, value.ring, log_ns=log_ns)
    elif isinstance(value, Motion):
        speeds = (value.linear_mps, value.angular_radps)
        writer.odometry(item.stamp_ns, value.pose, *speeds, log_ns=log_ns)
    elif isinstance(value, Pose2):
        writer.truth(item.stamp_ns, value, log_ns=log_ns)
    elif isinstance(value, str):
        writer.label(item.stamp_ns if log_ns is None else log_ns, value)
    elif role == "heading":
        writer.heading(item.stamp_ns, value, log_ns=log_ns)
    else:
        writer.pan(item.stamp_ns, value, log_ns=log_ns)


def files_in(path: Path, suffix: str) -> list[Path]:
    """Files of a folder with a suffix, 2 before 10; none where the path is no folder."""
    if not path.is_dir():
        return []
    return sorted(path.glob(f"*{suffix}"), key=lambda file: natural(file.name))
