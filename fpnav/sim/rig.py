"""What the robot carries, and everything that can go wrong with it, as parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated

import msgspec

from fpnav.errors import UsageError
from fpnav.params import Params, Tables, resolve
from fpnav.sim.sensors import ranges
from fpnav.sim.sensors.eyes import CameraEye, OmniEye, PanoramaEye, PanTilt
from fpnav.sim.sensors.film import Film, Mask
from fpnav.sim.sensors.ranges import Laser, Sonar
from fpnav.sim.sensors.state import Drift, Magnetism
from fpnav.values import ORIGIN, Calibration, Pose2

ROLES = ("panorama", "omni", "camera", "camera_offset", "pan", "scan", "sonar")
"""Sensors there are; ``pan`` turns the camera into a row of partial views."""

Count = Annotated[int, msgspec.Meta(ge=1)]


class Capture(Params, frozen=True):
    """When data sets are taken and how far the route is driven; 0 = as the route says.

    ``images_near_m`` : where not 0, cameras only look within this distance of the route's marks;
    ``images_every`` : how many data sets there are to one with images.
    ``state_s`` : time between two odometry, truth and compass messages. ``scan_late_s``,
    ``sonar_late_s`` : how long after the images of a data set these are taken.
    ``kidnaps`` : times the robot is lifted and set down elsewhere on its route, its odometry none
    the wiser.
    """

    step_m: float = 0.0
    length_m: float = 0.0
    images_near_m: float = 0.0
    images_every: Count = 1
    kidnaps: int = 0
    speed_mps: float = 0.0
    state_s: float = 0.1
    scan_late_s: float = 0.015
    sonar_late_s: float = 0.03


class Rig(Params, frozen=True):
    """Sensors of the robot, with their faults."""

    roles: tuple[str, ...] = ("panorama", "scan", "sonar")
    capture: Capture = Capture()
    panorama: PanoramaEye = PanoramaEye()
    omni: OmniEye = OmniEye()
    camera: CameraEye = CameraEye()
    pan: PanTilt = PanTilt()
    film: Film = Film()
    mask: Mask = Mask()
    laser: Laser = Laser()
    sonar: Sonar = Sonar()
    drift: Drift = Drift()
    compass: Magnetism = Magnetism()


BLOCKS = tuple(name for name in Rig.__struct_fields__ if name != "roles")
"""Parameter blocks of a rig; ``world`` is the one more that ``fpnav simulate`` takes."""


def make_rig(roles: Sequence[str], *layers: Tables) -> Rig:
    """Rig with the values of the layers of tables in place of the defaults, later layers first.

    Raises
    ------
    UsageError
        An unknown role or parameter.
    """
    unknown = [role for role in roles if role not in ROLES]
    if unknown:
        raise UsageError(f"no sensor {unknown[0]!r}; known: {', '.join(ROLES)}")
    rig = Rig()
    for tables in layers:
        blocks = {name: resolve(name, getattr(rig, name), tables) for name in BLOCKS}
        rig = Rig(roles=tuple(roles), **blocks)
    return rig


def calibrations(rig: Rig) -> Iterator[tuple[str, Calibration]]:
    """Role and calibration of every camera."""
    if "panorama" in rig.roles:
        yield "panorama", rig.panorama.calibration()
    if "omni" in rig.roles:
        yield "omni", rig.omni.calibration()
    if "pan" in rig.roles:
        yield "camera", pan_camera(rig).calibration()
    elif "camera" in rig.roles:
        yield "camera", rig.camera.calibration()
    if "camera_offset" in rig.roles:
        yield "camera_offset", rig.camera.calibration(offset=True)


def pan_camera(rig: Rig) -> CameraEye:
    """The small camera of the pan-tilt head."""
    eye = rig.camera
    return CameraEye(
        width_px=rig.pan.width_px,
        height_px=rig.pan.height_px,
        fov_deg=eye.fov_deg,
        height_m=eye.height_m,
    )


def mounts(rig: Rig) -> dict[str, tuple[Pose2, float]]:
    """Frame -> place on the robot and height, of everything the rig carries."""
    frames: dict[str, tuple[Pose2, float]] = {}
    heights = {"panorama": rig.panorama.height_m, "omni": rig.omni.height_m}
    for role, calibration in calibrations(rig):
        frames[role] = (calibration.mount, heights.get(role, rig.camera.height_m))
    if "scan" in rig.roles:
        frames["scan"] = (ORIGIN, rig.laser.height_m)
    if "sonar" in rig.roles:
        for number, (x, y, heading) in enumerate(ranges.mounts(rig.sonar).tolist()):
            frames[f"sonar_{number}"] = (Pose2(x, y, heading), rig.sonar.height_m)
    return frames
