"""Make docs/pictures: one page of what the sensors see for each world of the simulator.

python docs/make_pictures.py [WORLD ...]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Wedge
from matplotlib.transforms import ScaledTranslation

from fpnav.geometry import transform_points
from fpnav.sim.catalogue import Setting, default_rig
from fpnav.sim.motion import Track
from fpnav.sim.record import Job, driven, looking, stage_at, world_of
from fpnav.sim.rig import make_rig
from fpnav.sim.sense import Moment, sense
from fpnav.sim.world import World
from fpnav.values import LaserScan, Pose2, SonarRing

HERE = Path(__file__).resolve().parent / "pictures"
PAGES: dict[str, dict[str, Any]] = {
    "office": {"route": "map", "roles": ("panorama", "scan", "sonar"), "at": (0.02, 0.3, 0.62)},
    "room": {"route": "homing", "roles": ("panorama", "scan", "sonar"), "at": (0.0, 0.12, 0.6)},
    "outdoor": {"route": "line", "roles": ("panorama", "scan"), "at": (0.1, 0.5, 0.95)},
    "suburb": {"route": "loop", "roles": ("panorama", "pan", "scan"), "at": (0.05, 0.4, 0.75)},
    "gateways": {
        "route": "route-1",
        "roles": ("camera", "camera_offset", "scan", "sonar"),
        "at": (0.1, 0.25, 0.75),
    },
    "campus": {"route": "tour", "roles": ("panorama", "scan", "sonar"), "at": (0.02, 0.12, 0.3)},
}
PANORAMA = {"width_px": 1500, "height_px": 240}


def main(names: list[str]) -> None:
    """Make the pages of the named worlds, all by default."""
    HERE.mkdir(exist_ok=True)
    for name in names or list(PAGES):
        page(name, **PAGES[name])
        print(HERE / f"{name}.jpg", file=sys.stderr)


def page(name: str, route: str, roles: tuple[str, ...], at: tuple[float, ...]) -> None:
    """One page: images from three places, the plan with the route, scan and sonar over the plan."""
    _, defaults = default_rig(name)
    changes = {"panorama": PANORAMA, "capture": {"images_near_m": 0.0}}
    job = Job(Setting(name, 1, 1), route, make_rig(roles, defaults, changes))
    _, track, times = driven(job)
    moments = [round(share * (len(times) - 1)) for share in at]
    taken = [take(job, track, float(times[i]), i) for i in moments]
    figure = Figure(figsize=(12, 12.6), dpi=110, layout="constrained")
    grid = figure.add_gridspec(len(at) + 1, 2, height_ratios=[*(1.0 for _ in at), 2.9])
    for row, readings in enumerate(taken):
        axes = figure.add_subplot(grid[row, :])
        axes.imshow(strip(readings))
        axes.set_axis_off()
    plan_axes = figure.add_subplot(grid[len(at), 0])
    draw_plan(plan_axes, world_of(job.setting))
    draw_route(plan_axes, track, [track.pose_at(float(times[i])) for i in moments])
    plan_axes.set_title(f"{name}, seed 1: {route}, {track.travelled_m[-1]:.0f} m", fontsize=10)
    legend_below(plan_axes)
    pose = track.pose_at(float(times[moments[1]]))
    draw_ranges(figure.add_subplot(grid[len(at), 1]), job, pose, taken[1])
    save(figure, HERE / f"{name}.jpg")


def take(job: Job, track: Track, time_s: float, index: int) -> dict[str, Any]:
    """Readings by role; images of one role side by side."""
    stage = stage_at(job.setting, track.pose_at(time_s))
    assert looking(driven(job)[0], job.rig, track.pose_at(time_s))
    found: dict[str, list[Any]] = {}
    for reading in sense(Moment(stage, job.rig, track.state_at, index, time_s)):
        found.setdefault(reading.role, []).append(reading.value)
    return {role: values if role == "camera" else values[0] for role, values in found.items()}


def strip(readings: dict[str, Any]) -> np.ndarray:
    """The images of a data set as one RGB picture."""
    if "camera_offset" in readings:
        shown = np.hstack([readings["camera"][0], readings["camera_offset"]])
    elif "panorama" in readings:
        shown = readings["panorama"]
        views = readings.get("camera")
        if views:
            row = np.hstack([cv2.resize(view, (166, 125)) for view in views])
            shown = np.vstack([shown, cv2.resize(row, (shown.shape[1], 126))])
    else:
        shown = np.hstack(readings["camera"])
    return np.asarray(shown[..., ::-1])


def draw_plan(axes: Axes, world: World) -> None:
    """Walls, or the trace of everything that stands where there are none; doors, gateways."""
    for x0, y0, x1, y1 in world.walls:
        axes.plot([x0, x1], [y0, y1], color="0.15", lw=1.6, solid_capstyle="round")
    if not world.walls:
        for face in world.faces:
            corners = face.corners().reshape(-1, 3)
            if corners[:, 2].max() > 0.3 and np.ptp(corners[:, 2]) > 0.2:
                axes.plot(corners[:2, 0], corners[:2, 1], color="0.6", lw=0.4)
    for space in world.spaces if world.blocks else ():
        x, y = (space.x0, space.x1, space.x1, space.x0), (space.y0, space.y0, space.y1, space.y1)
        axes.fill(x, y, facecolor="none", edgecolor="0.15", lw=0.8)
    for is_open, tone, word in (
        (True, "tab:green", "open door"),
        (False, "tab:red", "closed door"),
    ):
        at = [(door.x_m, door.y_m) for door in world.doors if door.open == is_open]
        if at:
            axes.plot(*zip(*at, strict=True), "s", color=tone, ms=4, label=word)
    for gateway in {g.name: g for g in reversed(world.gateways)}.values():
        axes.annotate(gateway.name, (gateway.x_m, gateway.y_m), fontsize=11, weight="bold")
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_xlabel("x, m", fontsize=8)
    axes.set_ylabel("y, m", fontsize=8)


def draw_route(axes: Axes, track: Track, poses: list[Pose2]) -> None:
    """The way driven, and where the images were taken."""
    axes.plot(track.poses[:, 0], track.poses[:, 1], color="tab:blue", lw=1.0, label="way driven")
    axes.plot([], [], ">", color="tab:orange", label="images from top to bottom")
    for number, pose in enumerate(poses, 1):
        dx, dy = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        axes.quiver(pose.x_m, pose.y_m, dx, dy, color="tab:orange", scale=18, width=0.008, zorder=5)
        axes.annotate(str(number), (pose.x_m, pose.y_m), fontsize=9, color="tab:orange")
    low, high = track.poses[:, :2].min(axis=0), track.poses[:, :2].max(axis=0)
    if np.ptp(axes.get_xlim()) > 3 * max(high - low):
        axes.set_xlim(low[0] - 30, high[0] + 30)
        axes.set_ylim(low[1] - 30, high[1] + 30)


def draw_ranges(axes: Axes, job: Job, pose: Pose2, readings: dict[str, Any]) -> None:
    """Scan and sonar of the second place, over the plan."""
    stage = stage_at(job.setting, pose)
    draw_plan(axes, stage.world)
    reach = 8.0
    if "sonar" in readings:
        draw_sonar(axes, pose, readings["sonar"])
    if "scan" in readings:
        scan: LaserScan = readings["scan"]
        points = transform_points(pose, scan.points_m())
        axes.plot(points[:, 0], points[:, 1], ".", color="tab:red", ms=2.5, label="laser")
        reach = min(max(float(np.percentile(scan.ranges_m[scan.valid], 80)), 4.0), 40.0)
    axes.plot(pose.x_m, pose.y_m, "o", color="tab:blue", ms=6, label="robot")
    axes.set_xlim(pose.x_m - 1.3 * reach, pose.x_m + 1.3 * reach)
    axes.set_ylim(pose.y_m - 1.3 * reach, pose.y_m + 1.3 * reach)
    shown = " and sonar" if "sonar" in readings else ""
    axes.set_title(f"scan{shown} at 2, over the plan", fontsize=10)
    legend_below(axes)


def legend_below(axes: Axes) -> None:
    """Legend a line below the plan's own words, where it hides nothing."""
    figure = axes.get_figure()
    assert figure is not None
    below = axes.transAxes + ScaledTranslation(0.0, -0.38, figure.dpi_scale_trans)
    axes.legend(
        loc="upper left", bbox_to_anchor=(0.0, 0.0), bbox_transform=below, ncols=4, fontsize=7.5,
        frameon=False, borderaxespad=0.0, columnspacing=1.2,
    )  # fmt: skip


def draw_sonar(axes: Axes, pose: Pose2, ring: SonarRing) -> None:
    """Each cone, as deep as it heard; hollow where it heard nothing."""
    for (x, y, heading), reading in zip(ring.mounts, ring.ranges_m, strict=True):
        (start,) = transform_points(pose, np.array([[x, y]]))
        middle = math.degrees(pose.heading_rad + heading)
        half = math.degrees(ring.field_of_view_rad) / 2
        heard = bool(np.isfinite(reading))
        radius = float(reading) if heard else ring.range_max_m
        tone = {"facecolor": "tab:cyan", "alpha": 0.18} if heard else {"fill": False, "alpha": 0.15}
        axes.add_patch(Wedge((start[0], start[1]), radius, middle - half, middle + half, **tone))
    axes.add_patch(Wedge((0.0, 0.0), 0.0, 0.0, 0.0, facecolor="tab:cyan", alpha=0.3, label="sonar"))


def save(figure: Figure, file: Path) -> None:
    """JPEG of a figure."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., 2::-1]
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, 82])
    file.write_bytes(bytes(data))


if __name__ == "__main__":
    main(sys.argv[1:])
