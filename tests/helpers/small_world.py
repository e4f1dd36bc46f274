"""A corridor with side rooms, ray-cast: frames with every sensor role, for tests of all systems."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import column_bearings, compose
from fpnav.values import (
    ORIGIN,
    Calibration,
    Decoded,
    Frame,
    Image,
    LaserScan,
    Pose2,
    Reference,
    SonarRing,
)

WALLS = np.array(
    [
        # x0, y0, x1, y1, blue, green, red
        [0, -1, 3, -1, 200, 60, 40],
        [3, -1, 3, -3, 60, 60, 60],
        [3, -3, 5, -3, 40, 200, 60],
        [5, -3, 5, -1, 60, 60, 60],
        [5, -1, 9, -1, 160, 160, 160],
        [9, -1, 9, 1, 30, 120, 220],
        [9, 1, 7, 1, 140, 140, 140],
        [7, 1, 7, 4, 220, 40, 160],
        [7, 4, 5.5, 4, 90, 90, 90],
        [5.5, 4, 5.5, 1, 60, 200, 200],
        [5.5, 1, 2, 1, 120, 120, 120],
        [2, 1, 2, 2.2, 40, 40, 200],
        [2, 2.2, 0.8, 2.2, 80, 80, 80],
        [0.8, 2.2, 0.8, 1, 200, 200, 40],
        [0.8, 1, 0, 1, 110, 110, 110],
        [0, 1, 0, -1, 180, 100, 20],
    ],
    dtype=np.float64,
)
ROLES = ("panorama", "omni", "camera", "camera_offset", "scan", "sonar", "pan", "label")
FOV_RAD = math.radians(60.0)


def cast(
    origin: Pose2, bearings: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Range and wall hit by each ray, given in the frame of the origin."""
    angle = bearings + origin.heading_rad
    direction = np.column_stack([np.cos(angle), np.sin(angle)])[:, None, :]
    start, span = WALLS[None, :, :2], (WALLS[:, 2:4] - WALLS[:, :2])[None]
    offset = start - np.array([origin.x_m, origin.y_m])
    cross = direction[..., 0] * span[..., 1] - direction[..., 1] * span[..., 0]
    safe = np.where(np.abs(cross) < 1e-12, 1e-12, cross)
    along = (offset[..., 0] * span[..., 1] - offset[..., 1] * span[..., 0]) / safe
    share = (offset[..., 0] * direction[..., 1] - offset[..., 1] * direction[..., 0]) / safe
    hit = (along > 1e-6) & (share >= 0.0) & (share <= 1.0)
    ranges = np.where(hit, along, np.inf)
    wall = ranges.argmin(axis=1)
    return ranges[np.arange(len(wall)), wall], wall


def scan(pose: Pose2, beams: int = 180, fov_rad: float = 2.0 * math.pi) -> LaserScan:
    """Laser scan centred ahead."""
    step = fov_rad / beams
    first = -fov_rad / 2.0 + step / 2.0
    ranges, _ = cast(pose, first + step * np.arange(beams))
    return LaserScan(ranges.astype(np.float32), first, step, 0.05, 30.0)


def strip(pose: Pose2, bearings: NDArray[np.float64], height: int = 48) -> NDArray[np.uint8]:
    """Image columns of the walls, darker with distance, under a grey sky."""
    ranges, wall = cast(pose, bearings)
    shade = np.clip(1.2 - 0.1 * ranges, 0.3, 1.0)[:, None]
    colours = np.clip(WALLS[wall, 4:] * shade, 0, 250).astype(np.uint8)
    rows = np.abs(np.arange(height) - height / 2.0 + 0.5)[:, None]
    seen = rows <= (height * 0.9 / np.maximum(ranges, 0.9))[None, :]
    pixels = np.where(seen[..., None], colours[None], np.uint8(150))
    return np.ascontiguousarray(pixels.astype(np.uint8))


def panorama(pose: Pose2, width: int = 360) -> Image:
    """Unwrapped 360 degree image."""
    pixels = strip(pose, column_bearings(width))
    calibration = Calibration(width, len(pixels), vertical_fov_rad=math.radians(50.0))
    return Image(pixels, calibration)


def camera(pose: Pose2, width: int = 160) -> Image:
    """Forward pinhole image, 60 degrees."""
    focal = width / (2.0 * math.tan(FOV_RAD / 2.0))
    bearings = np.arctan((width / 2.0 - 0.5 - np.arange(width)) / focal)
    pixels = strip(pose, bearings, height=120)
    return Image(pixels, Calibration(width, 120, horizontal_fov_rad=FOV_RAD, baseline_m=0.18))


def omni(pose: Pose2, size: int = 201) -> Image:
    """Catadioptric image: up is ahead, radius grows with elevation."""
    rows, columns = np.mgrid[0:size, 0:size]
    centre = (size - 1) / 2.0
    bearing = np.arctan2(centre - columns, centre - rows)
    radius = np.hypot(rows - centre, columns - centre)
    flat = strip(pose, np.radians(np.arange(-180.0, 180.0, 0.5)))
    column = np.floor(np.degrees(bearing) * 2.0 + 360.0).astype(int) % 720
    row = np.clip((90.0 - radius) / 60.0 * len(flat), 0, len(flat) - 1).astype(int)
    calibration = Calibration(
        size, size, centre_x_px=centre, centre_y_px=centre, radius_in_px=30.0, radius_out_px=90.0
    )
    return Image(flat[row, column], calibration)


def sonar(pose: Pose2, count: int = 24) -> SonarRing:
    """Ring of transducers on the robot's centre, nearest echo in each cone."""
    headings = 2.0 * math.pi * np.arange(count) / count
    cone = np.radians(np.linspace(-12.0, 12.0, 7))
    ranges = cast(pose, (headings[:, None] + cone).ravel())[0].reshape(count, -1).min(axis=1)
    mounts = np.column_stack([np.zeros(count), np.zeros(count), headings])
    return SonarRing(ranges.astype(np.float32), mounts, math.radians(30.0), 0.1, 6.0)


def bare_frame(index: int, walls: int, roles: Iterable[str]) -> Frame:
    """A frame whose sensors work and see nothing (0 walls) or one post on the left (1)."""
    near = np.abs(np.arange(180) - 120) < 6 if walls else np.zeros(180, bool)
    beams = np.where(near, 2.0, np.inf).astype(np.float32)
    echoes = np.full(24, np.inf, np.float32)
    echoes[5:7] = 2.0 if walls else np.inf
    step = 2.0 * math.pi / 180.0
    values: dict[str, object] = {
        "scan": LaserScan(beams, -math.pi + step / 2.0, step, 0.05, 30.0),
        "sonar": SonarRing(echoes, sonar(ORIGIN).mounts, math.radians(30.0), 0.1, 6.0),
        "pan": 0.0,
        "label": "",
    }
    for role, make in (("panorama", panorama), ("omni", omni), ("camera", camera)):
        image = make(ORIGIN)
        pixels = np.full_like(image.pixels, 150)
        if walls:
            pixels[:, 20:30] = (20, 20, 230)
        values[role] = Image(pixels, image.calibration)
    values["camera_offset"] = values["camera"]
    pose = Pose2(0.1 * index, 0.0, 0.0)
    reference = Reference(index, index * 100_000_000, travelled_m=0.1 * index, odometry=pose)
    return Frame(reference, {role: Decoded(values[role]) for role in roles})


def frame(index: int, pose: Pose2, roles: Iterable[str] = ROLES) -> Frame:
    """What every sensor sees at a pose."""
    offset = compose(pose, Pose2(0.0, -0.18, 0.0))
    make = {
        "panorama": lambda: panorama(pose),
        "omni": lambda: omni(pose),
        "camera": lambda: camera(pose),
        "camera_offset": lambda: camera(offset),
        "scan": lambda: scan(pose),
        "sonar": lambda: sonar(pose),
        "pan": lambda: 0.0,
        "label": lambda: "corridor",
    }
    reference = Reference(
        index,
        index * 100_000_000,
        travelled_m=0.1 * index,
        odometry=pose,
        truth=pose,
        heading_rad=pose.heading_rad,
    )
    return Frame(reference, {role: Decoded(make[role]()) for role in roles})


def route(count: int, roles: Iterable[str] = ROLES, step_m: float = 0.1) -> list[Frame]:
    """Frames along the corridor, every step of travel, weaving a little."""
    wanted = tuple(roles)
    return [
        frame(i, Pose2(0.6 + step_m * i, 0.1 * math.sin(0.3 * i), 0.02 * math.cos(0.3 * i)), wanted)
        for i in range(count)
    ]
