"""Small logs, built in the test that needs them."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from fpnav.logs.writer import LogWriter
from fpnav.values import Calibration, LaserScan, Pose2, SonarRing

START_NS = 1_600_000_000 * 10**9
STEP_NS = 100_000_000


def jpeg(width: int = 32, height: int = 16, shade: int = 90) -> bytes:
    """A JPEG of one shade with a bright square."""
    pixels = np.full((height, width, 3), shade, dtype=np.uint8)
    pixels[: height // 2, : width // 4] = (20, 200, 250)
    done, data = cv2.imencode(".jpg", pixels)
    assert done
    return bytes(data)


def scan(beams: int = 8, range_m: float = 2.0, mount: Pose2 | None = None) -> LaserScan:
    """A half circle of equal ranges."""
    increment = np.pi / beams
    ranges = np.full(beams, range_m, dtype=np.float32)
    first = -np.pi / 2 + increment / 2
    return LaserScan(ranges, first, increment, 0.1, 10.0, mount or Pose2(0.2, 0.0, 0.0))


def ring(count: int = 4, range_m: float = 1.0) -> SonarRing:
    """A ring of transducers that look outward from 0.2 m."""
    angles = np.arange(count) * 2 * np.pi / count
    mounts = np.column_stack([0.2 * np.cos(angles), 0.2 * np.sin(angles), angles])
    return SonarRing(np.full(count, range_m, dtype=np.float32), mounts, 0.4, 0.1, 5.0)


def drive(writer: LogWriter, frames: int = 12) -> None:
    """A straight drive along x, 0.1 m a frame: panorama, scan, ring, odometry, truth, labels."""
    calibration = Calibration(32, 16, vertical_fov_rad=0.8, horizon_row=7.5)
    writer.camera_info("panorama", START_NS, calibration)
    writer.label(START_NS, "hall")
    for i in range(frames):
        stamp = START_NS + i * STEP_NS
        pose = Pose2(0.1 * i, 0.0, 0.0)
        writer.odometry(stamp, pose, 1.0, 0.0)
        writer.truth(stamp, Pose2(0.1 * i, 0.5, 0.01 * i))
        writer.heading(stamp, 0.01 * i)
        writer.image("panorama", stamp, jpeg(shade=60 + i))
        writer.scan(stamp, scan(range_m=1.0 + 0.1 * i))
        writer.sonar(stamp, ring(range_m=1.0 + 0.01 * i))
        if i == frames // 2:
            writer.label(stamp, "office")


def log_bytes(fill: Callable[[LogWriter], None] = drive, compression: str = "zstd") -> bytes:
    """Bytes of a standard log."""
    stream = io.BytesIO()
    with LogWriter(stream, compression=compression) as writer:
        fill(writer)
    return stream.getvalue()


def write_log(
    path: Path, fill: Callable[[LogWriter], None] = drive, compression: str = "zstd"
) -> Path:
    """A standard log in a file."""
    path.write_bytes(log_bytes(fill, compression))
    return path
