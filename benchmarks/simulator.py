"""Frames per second of the simulator, and against pybullet's renderer on the same triangles.

pybullet is no dependency: put it on the path for this measurement alone,
pip install --target DIR pybullet && PYTHONPATH=DIR python -m benchmarks simulator
"""

from __future__ import annotations

import functools
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fpnav.sim.catalogue import Setting, default_rig
from fpnav.sim.record import Job, driven, sealed, stage_of
from fpnav.sim.rig import Rig, make_rig
from fpnav.sim.sense import Moment, sense
from fpnav.sim.sensors import eyes
from fpnav.sim.stage import Stage
from fpnav.values import Pose2

SETTING = Setting("office", 1, 1)
FRAMES = 24
Call = Callable[[], Any]
FACE = (512, 424)
"""Size of each of the four images that cover 360 degrees in pybullet, and about 60 upwards."""


def main() -> None:
    """Print frames per second of data sets and images, and the ratio to pybullet."""
    cv2.setNumThreads(1)
    for width, height in ((720, 120), (1500, 240)):
        rate = data_sets_per_s(rig_of(width, height))
        print(f"data sets, panorama {width} x {height} + scan + sonar + JPEG: {rate:.1f} /s")
    stage, places = stage_of(SETTING), poses()
    ours = images_of(stage, places)
    print(f"panorama 1500 x 240, rendered only: {rate_of(ours):.1f} /s")
    theirs = pybullet_images_of(stage, places)
    if theirs is None:
        print("pybullet is not installed: no ratio (see the head of this file)")
        return
    compare(ours, theirs)


def compare(ours: list[Call], theirs: list[Call]) -> None:
    """Print the ratio to pybullet; both render the same place in turn, so that both suffer alike
    from whatever else the machine does."""
    times: dict[str, list[float]] = {"ours": [], "theirs": []}
    for mine, other in zip(ours, theirs, strict=True):
        times["ours"].append(seconds(mine))
        times["theirs"].append(seconds(other))
    mine_s, other_s = (float(np.median(times[name][1:])) for name in ("ours", "theirs"))
    print(f"pybullet TinyRenderer, same triangles, same views: {1.0 / other_s:.2f} /s")
    print(f"ratio: {other_s / mine_s:.1f}")


def rig_of(width: int, height: int) -> Rig:
    """The office's rig with a panorama of that size."""
    roles, defaults = default_rig("office")
    return make_rig(roles, defaults, {"panorama": {"width_px": width, "height_px": height}})


def data_sets_per_s(rig: Rig) -> float:
    """Data sets sensed and encoded per second of processor time, along the mapping route."""
    stage = stage_of(SETTING)
    _, track, times = driven(Job(SETTING, "map", rig))
    chosen = np.linspace(0, len(times) - 1, FRAMES).astype(int).tolist()

    def one(i: int) -> None:
        moment = Moment(stage, rig, track.state_at, i, float(times[i]))
        for reading in sense(moment):
            sealed(reading, rig)

    return rate_of([functools.partial(one, i) for i in chosen])


def poses() -> list[Pose2]:
    """Poses along the mapping route."""
    _, track, times = driven(Job(SETTING, "map", rig_of(720, 120)))
    return [track.pose_at(float(t)) for t in times[:: len(times) // FRAMES]]


def images_of(stage: Stage, places: list[Pose2]) -> list[Call]:
    """Calls that cast and shade a 1500 x 240 panorama each."""
    eye = eyes.PanoramaEye(width_px=1500, height_px=240)
    rays = eyes.panorama_rays(eye)
    return [functools.partial(stage.look, rays, p, eye.height_m, None) for p in places]


def rate_of(calls: list[Call]) -> float:
    """Calls per second of processor time; the median call, the first one not counted."""
    return 1.0 / float(np.median([seconds(call) for call in calls][1:]))


def seconds(call: Call) -> float:
    """Processor time of one call."""
    start = time.process_time()
    call()
    return time.process_time() - start


def pybullet_images_of(stage: Stage, places: list[Pose2]) -> list[Call] | None:
    """Calls that make the same views by pybullet's software renderer: four faces, resampled."""
    try:
        import pybullet
    except ImportError:
        return None
    client = pybullet.connect(pybullet.DIRECT)
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "scene.obj"
        write_obj(stage, mesh)
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH, fileName=str(mesh), physicsClientId=client
        )
        pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client)
    maps = face_maps()
    return [functools.partial(faces_of, pybullet, client, p, maps) for p in places]


def write_obj(stage: Stage, file: Path) -> None:
    """All solid triangles as a Wavefront file."""
    faces = [face for face in stage.world.faces if not face.material.glass]
    corners = np.concatenate([face.corners() for face in faces]).reshape(-1, 3)
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in corners]
    lines += [f"f {i + 1} {i + 2} {i + 3}" for i in range(0, len(corners), 3)]
    file.write_text("\n".join(lines) + "\n")


def face_maps() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Columns, and remap tables, of the panorama that each of the four faces supplies."""
    width, height = FACE
    bearing = math.pi - 2 * math.pi * (np.arange(1500) + 0.5) / 1500
    elevation = ((240 - 1) / 2 - np.arange(240)) * 2 * math.pi / 1500
    made = []
    for quarter in range(4):
        offset = (bearing - quarter * math.pi / 2 + math.pi) % (2 * math.pi) - math.pi
        columns = np.flatnonzero(np.abs(offset) <= math.pi / 4)
        x = width / 2 * (1 - np.tan(offset[columns]))
        up = np.tan(elevation)[:, None] / np.cos(offset[columns])[None]
        y = height / 2 - width / 2 * up
        across = np.broadcast_to(x, y.shape)
        made.append((columns, across.astype(np.float32), y.astype(np.float32)))
    return made


def faces_of(pybullet: Any, client: int, pose: Pose2, maps: list[Any]) -> np.ndarray:
    """One panorama by pybullet."""
    width, height = FACE
    up = 2 * math.degrees(math.atan(height / width))
    projection = pybullet.computeProjectionMatrixFOV(up, width / height, 0.05, 200.0)
    out = np.zeros((240, 1500, 3), dtype=np.uint8)
    eye = (pose.x_m, pose.y_m, 1.05)
    for quarter, (columns, x, y) in enumerate(maps):
        angle = pose.heading_rad + quarter * math.pi / 2
        target = (eye[0] + math.cos(angle), eye[1] + math.sin(angle), eye[2])
        view = pybullet.computeViewMatrix(eye, target, (0, 0, 1))
        _, _, pixels, _, _ = pybullet.getCameraImage(
            width,
            height,
            view,
            projection,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=client,
        )
        face = np.reshape(np.asarray(pixels, dtype=np.uint8), (height, width, 4))[..., :3]
        out[:, columns] = cv2.remap(np.ascontiguousarray(face), x, y, cv2.INTER_LINEAR)
    return out


if __name__ == "__main__":
    main()
