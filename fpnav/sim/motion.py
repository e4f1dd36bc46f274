"""How the robot moves: bounded speeds, following a way of points, and where it was when."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import wrap
from fpnav.sim.world import Point, Route
from fpnav.values import Pose2

Row = tuple[float, float, float, float, float]
TICK_S = 0.05
TURN_RADPS = 1.0
SHARP_RAD = math.radians(60.0)
REACHED_M = 0.05
CARRY_S = 0.5
ACCELERATION_MPS2 = 0.8
ANGULAR_RADPS2 = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where the robot was: one row per tick of TICK_S.

    ``poses`` (N, 3) x_m, y_m, heading_rad (not wrapped); ``speeds`` (N, 2) m/s and rad/s, held
    during the tick that ends there; ``travelled_m`` (N,).
    """

    poses: NDArray[np.float64]
    speeds: NDArray[np.float64]
    travelled_m: NDArray[np.float64]

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last."""
        return (len(self.poses) - 1) * TICK_S

    def pose_at(self, time_s: float) -> Pose2:
        """Pose between ticks, linear."""
        i = min(max(time_s / TICK_S, 0.0), len(self.poses) - 1.0)
        low = min(int(i), len(self.poses) - 2)
        w = i - low
        x, y, heading = (1 - w) * self.poses[low] + w * self.poses[low + 1]
        return Pose2(float(x), float(y), wrap(float(heading)))

    def until(self, time_s: float) -> Track:
        """The track's beginning, up to the first tick past a time."""
        rows = math.floor(time_s / TICK_S) + 2
        return Track(self.poses[:rows], self.speeds[:rows], self.travelled_m[:rows])

    def state_at(self, time_s: float) -> tuple[Pose2, float]:
        """Pose, and rate of turn in rad/s."""
        tick = min(math.ceil(time_s / TICK_S), len(self.speeds) - 1)
        return self.pose_at(time_s), float(self.speeds[tick, 1])


@dataclass(slots=True)
class Base:
    """Differential drive with bounded speed and acceleration."""

    x_m: float
    y_m: float
    heading_rad: float
    linear_mps: float = 0.0
    angular_radps: float = 0.0

    def step(self, linear_mps: float, angular_radps: float, dt_s: float = TICK_S) -> None:
        """Move for ``dt_s`` towards the speeds asked for, exactly along the arc."""
        self.linear_mps += _bounded(linear_mps - self.linear_mps, ACCELERATION_MPS2 * dt_s)
        self.angular_radps += _bounded(angular_radps - self.angular_radps, ANGULAR_RADPS2 * dt_s)
        turn = self.angular_radps * dt_s
        middle = self.heading_rad + turn / 2
        chord = self.linear_mps * dt_s * float(np.sinc(turn / 2 / math.pi))
        self.x_m += chord * math.cos(middle)
        self.y_m += chord * math.sin(middle)
        self.heading_rad += turn

    @property
    def pose(self) -> Pose2:
        """Where it stands."""
        return Pose2(self.x_m, self.y_m, wrap(self.heading_rad))

    def row(self) -> Row:
        """Pose, heading not wrapped, and speeds."""
        return self.x_m, self.y_m, self.heading_rad, self.linear_mps, self.angular_radps


def _bounded(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


class WayFollower:
    """Pure pursuit along a way of points; turns on the spot where the way turns sharply.

    ``square`` : sharp corners are driven to, not cut.
    """

    def __init__(
        self,
        points: Sequence[Point],
        speed_mps: float,
        lookahead_m: float,
        *,
        square: bool = False,
    ) -> None:
        self.points = [
            p for i, p in enumerate(points) if i == 0 or math.dist(p, points[i - 1]) > 1e-6
        ]
        self.speed_mps, self.lookahead_m = speed_mps, lookahead_m
        self.square = square
        self._segment = 0
        self._along = 0.0

    @property
    def done(self) -> bool:
        """Whether the end was reached."""
        return self._segment >= len(self.points) - 1

    @property
    def piece(self) -> tuple[Point, Point]:
        """Ends of the straight piece of way it is on."""
        return self.points[self._segment], self.points[self._segment + 1]

    def command(self, pose: Pose2) -> tuple[float, float]:
        """Speeds that lead back to and along the way."""
        target = self._carrot(pose)
        bearing = wrap(math.atan2(target[1] - pose.y_m, target[0] - pose.x_m) - pose.heading_rad)
        if abs(bearing) > math.radians(50):
            return 0.0, math.copysign(TURN_RADPS, bearing)
        slow = max(0.25, math.cos(bearing) ** 2)
        reach = max(math.hypot(target[0] - pose.x_m, target[1] - pose.y_m), 0.1)
        speed = self.speed_mps * slow
        return speed, _bounded(2.0 * speed * math.sin(bearing) / reach, TURN_RADPS)

    def _carrot(self, pose: Pose2) -> Point:
        """Point ahead on the way; it only ever moves forward, and waits for the robot."""
        while not self.done:
            a, b = self.points[self._segment], self.points[self._segment + 1]
            length = math.dist(a, b)
            at = self._along / length
            x, y = a[0] + at * (b[0] - a[0]), a[1] + at * (b[1] - a[1])
            if math.hypot(x - pose.x_m, y - pose.y_m) >= self.lookahead_m:
                return x, y
            self._along += 0.25 * min(self.lookahead_m, 0.08)
            if self._along >= length and self._waits(pose):
                self._along = length
                return b
            if self._along >= length:
                self._segment, self._along = self._segment + 1, 0.0
        return self.points[-1]

    def _waits(self, pose: Pose2) -> bool:
        """Whether a sharp corner lies ahead that is to be reached before the robot turns."""
        if not self.square or self._segment + 2 >= len(self.points):
            return False
        a, b, c = self.points[self._segment : self._segment + 3]
        before, after = math.atan2(b[1] - a[1], b[0] - a[0]), math.atan2(c[1] - b[1], c[0] - b[0])
        left = (b[0] - pose.x_m) * math.cos(before) + (b[1] - pose.y_m) * math.sin(before)
        return abs(wrap(after - before)) > SHARP_RAD and left > REACHED_M


def drive(route: Route, speed_mps: float) -> Track:
    """Drive the way from its first point, until its end or ``length_m`` of travel."""
    (x, y), (nx, ny) = route.points[0], route.points[1]
    base = Base(x, y, math.atan2(ny - y, nx - x))
    follower = WayFollower(route.points, speed_mps, route.lookahead_m)
    rows = [base.row()]
    travelled = 0.0
    while not follower.done and travelled < route.length_m:
        base.step(*follower.command(base.pose))
        rows.append(base.row())
        travelled += abs(base.linear_mps) * TICK_S
    return track_of(rows)


def track_of(rows: Sequence[Row]) -> Track:
    """Track of the rows a base gave, one for each tick."""
    table = np.array(rows)
    travelled = np.cumsum(np.abs(table[:, 3]) * TICK_S)
    return Track(table[:, :3], table[:, 3:], travelled)


def capture_times(track: Track, step_m: float, length_m: float = math.inf) -> NDArray[np.float64]:
    """Times (s) at which another ``step_m`` of travel is complete, the start included."""
    end = min(float(track.travelled_m[-1]), length_m)
    marks = np.arange(0.0, end - 1e-9, step_m)
    moving = np.concatenate([[True], np.diff(track.travelled_m) > 0.0])
    times = np.arange(len(track.poses)) * TICK_S
    return np.asarray(np.interp(marks, track.travelled_m[moving], times[moving]))


def kidnapped(
    track: Track, times: NDArray[np.float64], count: int, rng: np.random.Generator
) -> tuple[Track, NDArray[np.float64]]:
    """The track cut at ``count`` places between data sets, its pieces put in another order.

    At every joint the robot is lifted and set down elsewhere; speeds, and with them odometry, go
    on as if nothing had happened. Times move with their pieces; the data set of the very start is
    left out, so that each is well away from a joint.
    """
    if count < 1 or len(times) < 2 * (count + 1) + 1:
        return track, times
    times = times[1:]
    inner = 1 + rng.choice(len(times) - 1, size=count, replace=False)
    first = np.concatenate([[0], np.sort(inner), [len(times)]])
    joints = (times[first[1:-1] - 1] + times[first[1:-1]]) / 2
    ticks = np.round(joints / TICK_S).astype(int)
    cuts = np.concatenate([[0], ticks, [len(track.poses)]])
    order = _deranged(count + 1, rng)
    rows = np.concatenate([np.arange(cuts[k], cuts[k + 1]) for k in order])
    shift = np.cumsum([0, *(cuts[k + 1] - cuts[k] for k in order[:-1])])
    moved = [
        times[first[k] : first[k + 1]] + (start - cuts[k]) * TICK_S
        for k, start in zip(order, shift, strict=True)
    ]
    speeds = track.speeds[rows]
    travelled = np.cumsum(np.abs(speeds[:, 0]) * TICK_S)
    return Track(track.poses[rows], speeds, travelled), np.concatenate(moved)


def _deranged(count: int, rng: np.random.Generator) -> list[int]:
    """An order in which no piece follows the one it followed before."""
    while True:
        order = [int(k) for k in rng.permutation(count)]
        if all(b != a + 1 for a, b in itertools.pairwise(order)):
            return order


def carry(points: Sequence[Point]) -> Track:
    """Put the robot from point to point: it turns to the next one, then goes straight there.

    Each leg takes CARRY_S; it begins by facing the second point.
    """
    ticks = round(CARRY_S / TICK_S)
    turned = np.clip(np.arange(1, ticks + 1) / (0.4 * ticks), 0.0, 1.0)
    gone = np.clip((np.arange(1, ticks + 1) / ticks - 0.4) / 0.6, 0.0, 1.0)
    way = np.array(points)
    leg = np.diff(way, axis=0)
    heading = np.unwrap(np.arctan2(leg[:, 1], leg[:, 0]))
    turn = np.diff(heading, prepend=heading[0])
    place = way[:-1, None] + leg[:, None] * gone[:, None]
    facing = (heading - turn)[:, None] + turn[:, None] * turned
    linear = np.hypot(leg[:, 0], leg[:, 1])[:, None] * np.diff(gone, prepend=0.0) / TICK_S
    angular = turn[:, None] * np.diff(turned, prepend=0.0) / TICK_S
    poses = np.column_stack([place.reshape(-1, 2), facing.ravel()])
    speeds = np.column_stack([linear.ravel(), angular.ravel()])
    start = np.array([[*way[0], heading[0]]])
    travelled = np.concatenate([[0.0], np.cumsum(linear.ravel() * TICK_S)])
    return Track(np.vstack([start, poses]), np.vstack([np.zeros((1, 2)), speeds]), travelled)
