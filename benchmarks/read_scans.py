"""All scans of a 1 GB log: fpnav by the index, CRCs checked, against mcap with mcap-ros2-support.

Makes its own log in a temporary folder (a 10 Hz drive: panoramas, two laser scanners, odometry)
and reads the scans of both topics in turns in one process; prints medians and the ratio.

    python -m benchmarks.read_scans --megabytes 1000 --compression none
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from fpnav.logs.checksums import crc32
from fpnav.logs.fast import read_scans
from fpnav.logs.writer import LogWriter
from fpnav.values import LaserScan, Pose2

TOPICS = ("/scan", "/rear/scan")
BEAMS = (720, 360)
_IMAGE_BYTES = 200_000
_STEP_NS = 100_000_000


def write(path: Path, megabytes: int, compression: str, image_bytes: int = _IMAGE_BYTES) -> int:
    """Write a log of about this size; returns the number of scans in it."""
    noise = np.random.default_rng(7)
    scans = 0
    with open(path, "wb") as stream, LogWriter(stream, compression=compression) as writer:
        for frame in range(max(1, megabytes * 1_000_000 // (image_bytes + 7_000))):
            stamp_ns = (frame + 1) * _STEP_NS
            writer.image("panorama", stamp_ns, noise.bytes(image_bytes))
            for topic, beams in zip(TOPICS, BEAMS, strict=True):
                ranges = noise.uniform(0.5, 20.0, beams).astype(np.float32)
                scan = LaserScan(ranges, -np.pi, 2 * np.pi / beams, 0.1, 30.0)
                writer.scan(stamp_ns, scan, topic)
                scans += 1
            for part in range(5):
                pose = Pose2(0.05 * frame + 0.01 * part, 0.0, 0.0)
                writer.odometry(stamp_ns + part * _STEP_NS // 5, pose)
    return scans


def by_fpnav(path: Path) -> tuple[int, float]:
    """Number of scans and the sum of their finite ranges."""
    count, total = 0, 0.0
    for found in read_scans(path, TOPICS):
        count += len(found.rows)
        total += float(found.ranges_m.sum(dtype=np.float64))
    return count, total


def by_mcap(path: Path, *, checked: bool = False) -> tuple[int, float]:
    """The same by the mcap reader with mcap-ros2-support, which checks no CRC unless asked to."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    count, total = 0, 0.0
    with open(path, "rb") as stream:
        reader = make_reader(stream, checked, [DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=list(TOPICS)):
            count += 1
            total += float(np.sum(message.ranges, dtype=np.float64))
    return count, total


READINGS: dict[str, Callable[[Path], tuple[int, float]]] = {
    "fpnav": by_fpnav,
    "mcap": by_mcap,
    "mcap, CRCs checked": partial(by_mcap, checked=True),
}


def timed(read: Callable[[Path], tuple[int, float]], path: Path) -> tuple[float, int, float]:
    """Seconds a reading takes, and what it found."""
    start = time.perf_counter()
    count, total = read(path)
    return time.perf_counter() - start, count, total


def main(arguments: list[str] | None = None) -> None:
    """Write, read in turns, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--megabytes", type=int, default=1000)
    parser.add_argument("--compression", choices=["none", "lz4", "zstd"], default="none")
    parser.add_argument(
        "--image-bytes", type=int, default=_IMAGE_BYTES, help="size of a panorama among the scans"
    )
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.mcap"
        scans = write(path, given.megabytes, given.compression, given.image_bytes)
        runs: dict[str, list[float]] = {name: [] for name in READINGS}
        for _ in range(given.rounds):
            for name, read in READINGS.items():
                seconds, count, total = timed(read, path)
                runs[name].append(seconds)
                print(f"{name}: {count} of {scans} scans, sum {total:.3f}, {seconds:.3f} s")
        ours, theirs, checked = (statistics.median(runs[name]) for name in READINGS)
        size = path.stat().st_size / 1e6
        print(f"CRC by {crc32.__module__ or 'zlib'}")
        print(
            f"{size:.0f} MB, {given.compression}: fpnav {ours:.3f} s, mcap-ros2-support without "
            f"CRCs {theirs:.3f} s, ratio {theirs / ours:.1f}; with {checked:.3f} s, ratio "
            f"{checked / ours:.1f}"
        )


if __name__ == "__main__":
    main()
