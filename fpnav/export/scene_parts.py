"""Foxglove messages of a map: spheres and lines with ids that stay, poses, transforms."""

from __future__ import annotations

import math

import numpy as np
from foxglove.messages import (
    Color,
    FrameTransform,
    FrameTransforms,
    KeyValuePair,
    LinePrimitive,
    LinePrimitiveLineType,
    Log,
    LogLevel,
    Point3,
    Pose,
    PoseInFrame,
    PosesInFrame,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneEntityDeletionType,
    SceneUpdate,
    SpherePrimitive,
    TextPrimitive,
    Timestamp,
    Vector3,
)
from numpy.typing import NDArray

from fpnav.export.subject import Subject
from fpnav.values import FloatArray, Pose2

PLACE_SIZE_M, TEXT_SIZE_M, LIFT_M = 0.3, 0.35, 0.5
LEAST_BELIEF = 0.01
"""Places believed in less than this are not drawn."""

_PLACE = Color(r=0.04, g=0.4, b=0.66, a=0.9)
_EDGE = Color(r=0.42, g=0.45, b=0.5, a=0.9)
_TEXT = Color(r=0.13, g=0.15, b=0.17, a=1.0)


def graph_scene(subject: Subject, frame: str, stamp_ns: int) -> SceneUpdate:
    """One entity per place, one for all edges; ids stay, so that a later scene replaces them."""
    at = place_positions(subject)
    stamp = timestamp(stamp_ns)
    entities = [
        SceneEntity(
            timestamp=stamp,
            frame_id=frame,
            id=f"place/{place}",
            metadata=_metadata(subject, row),
            spheres=[_sphere(at[place], PLACE_SIZE_M, _PLACE)],
            texts=[_text(at[place], str(place))],
        )
        for row, place in enumerate(subject.view.place_ids.tolist())
        if place in at
    ]
    pairs = {tuple(sorted(pair)) for pair in subject.view.edges[["source", "target"]].tolist()}
    ends = [at[place] for pair in sorted(pairs) if set(pair) <= set(at) for place in pair]
    lines = LinePrimitive(
        type=LinePrimitiveLineType.LineList,
        thickness=2.0,
        scale_invariant=True,
        points=[Point3(x=x, y=y, z=0.0) for x, y in ends],
        color=_EDGE,
    )
    entities.append(SceneEntity(timestamp=stamp, frame_id=frame, id="edges", lines=[lines]))
    return SceneUpdate(entities=entities)


def belief_scene(
    subject: Subject, belief: NDArray[np.float32], shown: set[int], frame: str, stamp_ns: int
) -> tuple[SceneUpdate, set[int]]:
    """Spheres that grow with the belief in a place; places no longer believed in are deleted.

    Returns the scene and the places it shows, to be given back with the next belief.
    """
    at = place_positions(subject)
    stamp = timestamp(stamp_ns)
    ids = subject.view.place_ids.tolist()
    now = {
        place: float(p) for place, p in zip(ids, belief, strict=True)
        if p >= LEAST_BELIEF and place in at
    }  # fmt: skip
    entities = [
        SceneEntity(
            timestamp=stamp,
            frame_id=frame,
            id=f"belief/{place}",
            spheres=[_sphere(at[place], 0.2 + 1.2 * math.sqrt(p), _glow(p))],
        )
        for place, p in now.items()
    ]
    gone = [
        SceneEntityDeletion(
            timestamp=stamp, type=SceneEntityDeletionType.MatchingId, id=f"belief/{place}"
        )
        for place in sorted(shown - set(now))
    ]
    return SceneUpdate(entities=entities, deletions=gone), set(now)


def place_positions(subject: Subject) -> dict[int, tuple[float, float]]:
    """Where each place is drawn; places without a position are left out."""
    view = subject.view
    rows = zip(view.place_ids.tolist(), view.place_pose[:, :2].tolist(), strict=True)
    return {place: (x, y) for place, (x, y) in rows if math.isfinite(x) and math.isfinite(y)}


def pose_message(pose: Pose2, frame: str, stamp_ns: int) -> PoseInFrame:
    """One pose in a frame."""
    return PoseInFrame(timestamp=timestamp(stamp_ns), frame_id=frame, pose=_pose(pose))


def poses_message(poses: FloatArray, frame: str, stamp_ns: int) -> PosesInFrame:
    """A path of poses (N, 3) in a frame."""
    made = [_pose(Pose2(*pose)) for pose in poses.tolist()]
    return PosesInFrame(timestamp=timestamp(stamp_ns), frame_id=frame, poses=made)


def transforms_message(pose: Pose2, parent: str, child: str, stamp_ns: int) -> FrameTransforms:
    """Where the child frame stands in the parent frame."""
    transform = FrameTransform(
        timestamp=timestamp(stamp_ns),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=pose.x_m, y=pose.y_m, z=0.0),
        rotation=_rotation(pose.heading_rad),
    )
    return FrameTransforms(transforms=[transform])


def log_message(text: str, stamp_ns: int) -> Log:
    """An event in words."""
    return Log(timestamp=timestamp(stamp_ns), level=LogLevel.Info, message=text, name="fpnav")


def timestamp(stamp_ns: int) -> Timestamp:
    """Nanoseconds as the messages hold them."""
    seconds, rest = divmod(stamp_ns, 10**9)
    return Timestamp(sec=seconds, nsec=rest)


def _metadata(subject: Subject, row: int) -> list[KeyValuePair]:
    facts = {
        "extent_m": f"{subject.view.extent_m[row]:.3f}",
        "label": subject.labels[row],
        "signature": subject.strip(row),
    }
    return [KeyValuePair(key=key, value=value) for key, value in facts.items() if value]


def _sphere(at: tuple[float, float], size_m: float, color: Color) -> SpherePrimitive:
    size = Vector3(x=size_m, y=size_m, z=size_m)
    return SpherePrimitive(pose=_pose(Pose2(*at, 0.0)), size=size, color=color)


def _text(at: tuple[float, float], text: str) -> TextPrimitive:
    pose = Pose(position=Vector3(x=at[0], y=at[1], z=LIFT_M), orientation=_rotation(0.0))
    return TextPrimitive(pose=pose, billboard=True, font_size=TEXT_SIZE_M, color=_TEXT, text=text)


def _glow(probability: float) -> Color:
    return Color(r=0.82, g=0.33, b=0.05, a=0.15 + 0.75 * probability)


def _pose(pose: Pose2) -> Pose:
    position = Vector3(x=pose.x_m, y=pose.y_m, z=0.0)
    return Pose(position=position, orientation=_rotation(pose.heading_rad))


def _rotation(heading_rad: float) -> Quaternion:
    return Quaternion(z=math.sin(0.5 * heading_rad), w=math.cos(0.5 * heading_rad))
