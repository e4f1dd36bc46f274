"""Checks of what the sensors measured, on frames spread over the log."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fpnav.errors import LogError
from fpnav.logs.checks.finding import Finding, fail, note, ok, warn
from fpnav.logs.frames import Log
from fpnav.logs.ledger import Budget
from fpnav.logs.roles import IMAGE_ROLES
from fpnav.values import Calibration, Image, LaserScan, SonarRing

SAMPLES = 40


def frames_of_reference(log: Log, budget: Budget) -> Iterator[Finding]:
    """It is known where every sensor stands on the robot."""
    unknown = []
    for role in (*IMAGE_ROLES, "scan", "sonar"):
        for stream in log.streams.get(role, []):
            if log.tree.mount(stream.frame_id) is None:
                unknown.append(f"{role} frame {stream.frame_id!r}")
    if unknown:
        fix = "record /tf_static from base_link to it; it is taken to stand at the robot's centre"
        message = f"{', '.join(unknown[:3])} has no transform to the robot's base"
        yield warn("mounts", "E503", message, fix)
    else:
        yield ok("mounts", "every sensor has a transform to the robot's base")


def calibration(log: Log, budget: Budget) -> Iterator[Finding]:
    """Cameras are calibrated as far as systems need it."""
    for role in IMAGE_ROLES:
        if role not in log.streams:
            continue
        found = log.calibrations.get(role)
        missing = _missing(role, found)
        if missing:
            fix = f"fpnav ingest --role {role} {' '.join(missing)}"
            yield warn("calibration", "E503", f"{role}: not known: {', '.join(missing)}", fix)
        else:
            yield ok("calibration", f"{role} is calibrated")


def _missing(role: str, found: Calibration | None) -> list[str]:
    """Options of ingest that would fill what is unknown."""
    values = found or Calibration(0, 0)
    needed = {
        "panorama": {"--vfov": values.vertical_fov_rad},
        "omni": {"--centre": values.centre_x_px, "--radii": values.radius_out_px},
        "camera_offset": {"--hfov": values.horizontal_fov_rad, "--baseline": values.baseline_m},
    }.get(role, {"--hfov": values.horizontal_fov_rad})
    return [option for option, value in needed.items() if math.isnan(value)]


def images(log: Log, budget: Budget) -> Iterator[Finding]:
    """Images decode, are of one size, and show something."""
    for role in IMAGE_ROLES:
        if role not in log.streams:
            continue
        found, bad = _images(log, role)
        sizes = {image.pixels.shape[:2] for image in found}
        flat = sum(float(image.pixels.std()) < 2.0 for image in found)
        if bad:
            yield warn("images", "E406", f"{role}: {bad} of {len(found) + bad} do not decode",
                       "see check losses")  # fmt: skip
        if len(sizes) > 1:
            told = ", ".join(f"{w} x {h}" for h, w in sorted(sizes))
            yield warn("images", "E408", f"{role}: sizes differ: {told}", "record one size")
        if flat:
            yield note("images", "D13", f"{role}: {flat} of {len(found)} are of one shade")
        if found and not bad and len(sizes) == 1 and not flat:
            height, width = next(iter(sizes))
            yield ok("images", f"{role}: {width} x {height}, all of {len(found)} decode")


def _images(log: Log, role: str) -> tuple[list[Image], int]:
    found: list[Image] = []
    bad = 0
    for frame in log.sample(SAMPLES):
        try:
            image: Image | None = frame.get(role)
        except LogError:
            bad += 1
            continue
        if image is not None:
            found.append(image)
    return found, bad


def scans(log: Log, budget: Budget) -> Iterator[Finding]:
    """Scans hit something, and look alike from one to the next."""
    if "scan" not in log.streams or not log.primary:
        return
    found = [frame.scan for frame in log.sample(SAMPLES) if frame.scan is not None]
    if not found:
        yield fail("scans", "E502", "no scan can be used", "see check losses")
        return
    valid = float(np.mean([scan.valid.mean() for scan in found]))
    beams = sorted({len(scan.ranges_m) for scan in found})
    if valid < 0.2:
        fix = "check range_min and range_max of the driver"
        yield warn("scans", "E505", f"only {valid:.0%} of the beams hit something in range", fix)
    if len(beams) > 1:
        yield note("scans", "E2", f"the number of beams changes: {beams[0]} to {beams[-1]}")
    if any(math.isinf(scan.range_max_m) for scan in found):
        yield note("scans", "E5", "the scans give no range limits")
    yield ok("scans", _scan_words(found[0], valid))


def _scan_words(scan: LaserScan, valid: float) -> str:
    view = math.degrees(scan.field_of_view_rad)
    return f"{len(scan.ranges_m)} beams over {view:.0f} degrees, {valid:.0%} hit something"


def sonar(log: Log, budget: Budget) -> Iterator[Finding]:
    """Rings are complete and their transducers stand apart."""
    if "sonar" not in log.streams or not log.primary:
        return
    found = [frame.sonar for frame in log.sample(SAMPLES) if frame.sonar is not None]
    if not found:
        yield fail("sonar", "E502", "no ring can be used", "see check losses")
        return
    silent = float(np.mean([np.isnan(ring.ranges_m).mean() for ring in found]))
    if silent > 0.05:
        yield warn("sonar", "E15", f"{silent:.0%} of the readings are missing from the rings",
                   "transducers that take turns fill a ring only in part")  # fmt: skip
    if len(_headings(found[0])) < len(found[0].ranges_m):
        fix = "record /tf_static with the place of each transducer"
        yield warn("sonar", "E503", "transducers point the same way", fix)
    yield ok("sonar", f"{len(found[0].ranges_m)} transducers")


def _headings(ring: SonarRing) -> set[float]:
    return {round(float(heading), 3) for heading in ring.mounts[:, 2]}
