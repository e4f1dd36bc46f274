"""What walks through fpnav: small frozen values, units in their names, integer nanoseconds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SENSOR_ROLES = ("panorama", "omni", "camera", "camera_offset", "scan", "sonar", "pan", "label")
"""Roles a frame has a slot for; the state roles are interpolated to its stamp instead."""

PRIMARY_ROLES = ("panorama", "omni", "camera", "scan", "sonar")
"""Frames stand at the stamps of the first of these that a log has (commands.md)."""

STATE_ROLES = ("odometry", "heading", "truth")
ROLES = SENSOR_ROLES + STATE_ROLES


@dataclass(frozen=True, slots=True)
class Pose2:
    """Planar pose; heading counter-clockwise from the x axis."""

    x_m: float
    y_m: float
    heading_rad: float


ORIGIN = Pose2(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """One planar scan. Ranges follow REP 117.

    ``ranges_m`` : (N,) float32; +inf = nothing in range, -inf = too close, NaN = unknown.
    Beam i points at ``angle_min_rad + i * angle_increment_rad`` in the sensor's own frame, which
    stands at ``mount`` on the robot.
    """

    ranges_m: NDArray[np.float32]
    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    mount: Pose2 = ORIGIN

    @property
    def bearings_rad(self) -> FloatArray:
        """Beam directions in the sensor frame, (N,)."""
        beams = np.arange(len(self.ranges_m), dtype=np.float64)
        return np.asarray(self.angle_min_rad + self.angle_increment_rad * beams, dtype=np.float64)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Beams that hit something within the limits, (N,)."""
        with np.errstate(invalid="ignore"):
            inside = (self.ranges_m >= self.range_min_m) & (self.ranges_m <= self.range_max_m)
        return inside & np.isfinite(self.ranges_m)

    @property
    def field_of_view_rad(self) -> float:
        """Angle covered by the beams, each beam owning one increment; at most 2 pi."""
        return min(2.0 * math.pi, abs(self.angle_increment_rad) * len(self.ranges_m))

    def points_m(self) -> FloatArray:
        """Hits in the robot frame, (M, 2), in beam order."""
        keep = self.valid
        angles = self.bearings_rad[keep] + self.mount.heading_rad
        ranges = self.ranges_m[keep].astype(np.float64)
        return np.column_stack(
            [
                self.mount.x_m + ranges * np.cos(angles),
                self.mount.y_m + ranges * np.sin(angles),
            ]
        )


@dataclass(frozen=True, slots=True, eq=False)
class SonarRing:
    """One reading of every transducer.

    ``ranges_m`` : (N,) float32 as in LaserScan; ``mounts`` : (N, 3) float64 x_m, y_m, heading_rad
    of each transducer on the robot.
    """

    ranges_m: NDArray[np.float32]
    mounts: FloatArray
    field_of_view_rad: float
    range_min_m: float
    range_max_m: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """What is known of a camera; NaN where unknown.

    A panorama covers 360 degrees and needs ``vertical_fov_rad``; a forward camera needs
    ``horizontal_fov_rad`` (pinhole); an omni image needs centre and radii in pixels.
    ``horizon_row`` is the pixel row (from 0, fractional) of elevation 0.
    """

    width_px: int
    height_px: int
    horizontal_fov_rad: float = math.nan
    vertical_fov_rad: float = math.nan
    horizon_row: float = math.nan
    centre_x_px: float = math.nan
    centre_y_px: float = math.nan
    radius_in_px: float = math.nan
    radius_out_px: float = math.nan
    baseline_m: float = math.nan
    mount: Pose2 = ORIGIN


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """Decoded image: ``pixels`` (H, W, 3) uint8 in BGR order."""

    pixels: NDArray[np.uint8]
    calibration: Calibration | None = None


class Payload(Protocol):
    """An undecoded message: cheap to hold, to pickle and to send to another process."""

    def decode(self) -> Any:
        """The value: Image, LaserScan, SonarRing, float (pan, rad) or str (label)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """A payload that is a value already (tests, simulator)."""

    value: Any

    def decode(self) -> Any:
        """The value itself."""
        return self.value


@dataclass(frozen=True, slots=True)
class Reference:
    """Which frame, where and when: what stays of a frame in a signature.

    ``index`` counts the primary role's messages of its log from 0, before thinning; ``session``
    counts the logs of one signature file; ``travelled_m`` is the path length since the session's
    start, by odometry where it exists, else by truth, else NaN.
    """

    index: int
    stamp_ns: int
    session: int = 0
    travelled_m: float = math.nan
    odometry: Pose2 | None = None
    truth: Pose2 | None = None
    heading_rad: float = math.nan
    label: str = ""


@dataclass(frozen=True, eq=False)
class Frame:
    """All a log says at one stamp; sensor slots decode on first access.

    ``payloads`` maps a role of SENSOR_ROLES to its undecoded message; a role without a message
    near enough in time is absent.
    """

    reference: Reference
    payloads: Mapping[str, Payload]
    _cache: dict[str, Any] = field(default_factory=dict, repr=False)

    def get(self, role: str) -> Any:
        """Decoded value of a role, or None where the frame has none."""
        if role not in self.payloads:
            return None
        if role not in self._cache:
            self._cache[role] = self.payloads[role].decode()
        return self._cache[role]

    def __getstate__(self) -> dict[str, Any]:
        return {"reference": self.reference, "payloads": dict(self.payloads), "_cache": {}}

    @property
    def panorama(self) -> Image | None:
        """Unwrapped 360 degree image."""
        value: Image | None = self.get("panorama")
        return value

    @property
    def omni(self) -> Image | None:
        """Raw catadioptric image."""
        value: Image | None = self.get("omni")
        return value

    @property
    def camera(self) -> Image | None:
        """Forward perspective image."""
        value: Image | None = self.get("camera")
        return value

    @property
    def camera_offset(self) -> Image | None:
        """Forward image of the laterally offset twin."""
        value: Image | None = self.get("camera_offset")
        return value

    @property
    def scan(self) -> LaserScan | None:
        """Laser scan."""
        value: LaserScan | None = self.get("scan")
        return value

    @property
    def sonar(self) -> SonarRing | None:
        """Sonar ring."""
        value: SonarRing | None = self.get("sonar")
        return value

    @property
    def pan_rad(self) -> float | None:
        """Camera pan angle on the robot."""
        value: float | None = self.get("pan")
        return value


@dataclass(frozen=True, slots=True, eq=False)
class Signature:
    """What makes one place recognisable.

    ``record`` : scalar of the dtype the system declares as RECORD; ``parts`` : name -> (n,)
    structured array in the dtype the system declares in PARTS.
    """

    reference: Reference
    record: np.void
    parts: Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Place:
    """A node of a topological map. ``members`` index the map's signatures, in travel order."""

    id: int
    members: tuple[int, ...]
    extent_m: float
    label: str = ""
    merged_from: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class RelativePose:
    """Where a query stands as seen from a reference signature; covariance (3, 3) row-major."""

    pose: Pose2
    covariance: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Where one query is thought to be.

    ``places``, ``members``, ``scores``, ``headings_rad`` : (k,) the ranking, best first;
    ``members`` is the best member signature of the place (-1 unknown), ``headings_rad`` the
    rotation from that place's frame to the query (NaN unknown). ``place`` is the decision, None =
    not localized; ``belief`` the probability stated for it, ``entropy`` that of the whole belief
    (nats).
    """

    query: Reference
    places: NDArray[np.int64]
    members: NDArray[np.int64]
    scores: FloatArray
    headings_rad: FloatArray
    place: int | None
    belief: float = math.nan
    entropy: float = math.nan
    relative: RelativePose | None = None


@dataclass(frozen=True, slots=True)
class Metric:
    """One figure: ``n`` of ``of`` beside every rate; ``low``, ``high`` the 95 % interval."""

    name: str
    value: float
    n: int
    of: int
    unit: str = ""
    low: float = math.nan
    high: float = math.nan
