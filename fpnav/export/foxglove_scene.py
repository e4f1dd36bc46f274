"""MCAP with Foxglove messages (protobuf): the map, and of a result belief and estimates in time.

Opens in Foxglove and Lichtblick (``/fpnav/graph``, ``/fpnav/belief``: scenes) and in Rerun
(``/fpnav/path``, ``/fpnav/pose``). Frames after REP 105: the localizer states map -> odom. Every
message carries the stamp of its observation, so the same input gives the same bytes. Needs the
extra ``foxglove``.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fpnav.errors import UsageError
from fpnav.evaluation.evaluate import evaluate
from fpnav.export.scene_parts import (
    belief_scene,
    graph_scene,
    log_message,
    pose_message,
    poses_message,
    transforms_message,
)
from fpnav.export.subject import Subject, estimates, poses_of
from fpnav.geometry import compose, inverse
from fpnav.store.tables import Result
from fpnav.values import Pose2

if TYPE_CHECKING:
    import foxglove

FRAME, ODOM = "map", "odom"
_SCALARS = {
    "type": "object",
    "title": "fpnav.Belief",
    "properties": {
        name: {"type": "number"} for name in ("entropy", "best", "p_best", "second", "p_second")
    },
}


def write(subject: Subject) -> bytes:
    """The recording.

    Raises
    ------
    UsageError
        The extra is not installed.
    """
    try:
        import foxglove
    except ImportError:
        raise UsageError("--to mcap needs foxglove-sdk: pip install 'fpnav[foxglove]'") from None
    context = foxglove.Context()
    buffer = io.BytesIO()
    with foxglove.open_mcap(buffer, context=context) as writer:
        writer.write_metadata("fpnav", _facts(subject))
        start = int(_first_stamp(subject))
        if subject.result is not None:
            metrics = _metrics(subject.result)
            writer.attach(
                log_time=start, create_time=start, name="metrics.json",
                media_type="application/json", data=metrics,
            )  # fmt: skip
        _log_map(subject, context, start)
        if subject.result is not None:
            _log_result(subject, subject.result, context)
    return buffer.getvalue()


def _log_map(subject: Subject, context: foxglove.Context, start: int) -> None:
    """The graph of places and the path of the mapping run, at the start."""
    from foxglove.channels import PosesInFrameChannel, SceneUpdateChannel

    if len(subject.view.place_ids):
        scenes = SceneUpdateChannel("/fpnav/graph", context=context)
        scenes.log(graph_scene(subject, FRAME, start), log_time=start)
    poses = poses_of(subject.references)
    poses = poses[np.isfinite(poses).all(axis=1)]
    path = PosesInFrameChannel("/fpnav/path", context=context)
    path.log(poses_message(poses, FRAME, start), log_time=start)


def _log_result(subject: Subject, result: Result, context: foxglove.Context) -> None:
    """Belief, estimate, map -> odom and events of every query, at its stamp."""
    from foxglove import Channel
    from foxglove.channels import (
        FrameTransformsChannel,
        LogChannel,
        PoseInFrameChannel,
        SceneUpdateChannel,
    )

    beliefs = SceneUpdateChannel("/fpnav/belief", context=context)
    scalars = Channel("/fpnav/belief_scalars", schema=_SCALARS, context=context)
    pose_channel = PoseInFrameChannel("/fpnav/pose", context=context)
    transforms = FrameTransformsChannel("/tf", context=context)
    events = LogChannel("/fpnav/log", context=context)
    found = dict(estimates(result))
    shown: set[int] = set()
    for query, stamp in enumerate(result.queries["stamp_ns"].tolist()):
        if result.belief.shape[1]:
            scene, shown = belief_scene(subject, result.belief[query], shown, FRAME, stamp)
            beliefs.log(scene, log_time=stamp)
            scalars.log(_scalars(result, query), log_time=stamp)
        if query in found:
            pose_channel.log(pose_message(found[query], FRAME, stamp), log_time=stamp)
            drift = _map_to_odom(result, query, found[query])
            if drift is not None:
                transforms.log(transforms_message(drift, FRAME, ODOM, stamp), log_time=stamp)
        for text in _events(result, query):
            events.log(log_message(text, stamp), log_time=stamp)


def _scalars(result: Result, query: int) -> dict[str, float]:
    """The belief in numbers, for plots; what is unknown is left out."""
    belief = result.belief[query].astype(np.float64)
    first, *rest = np.argsort(-belief, kind="stable")[:2].tolist()
    values = {"best": float(result.view.place_ids[first]), "p_best": float(belief[first])}
    if rest:
        values |= {
            "second": float(result.view.place_ids[rest[0]]),
            "p_second": float(belief[rest[0]]),
        }
    if np.isfinite(result.entropy[query]):
        values["entropy"] = float(result.entropy[query])
    return values


def _map_to_odom(result: Result, query: int, pose: Pose2) -> Pose2 | None:
    odometry = result.queries["odometry"][query]
    if not np.isfinite(odometry).all():
        return None
    return compose(pose, inverse(Pose2(*odometry.tolist())))


def _events(result: Result, query: int) -> Iterator[str]:
    """What changed at this query: localized, at another place, or lost."""
    before = int(result.decision[query - 1]) if query else -1
    now = int(result.decision[query])
    if now == before:
        return
    if now < 0:
        yield f"lost: no place is near enough (last was {before})"
    elif before < 0:
        yield f"localized at {now}"
    else:
        yield f"from {before} to {now}"


def _first_stamp(subject: Subject) -> int:
    rows = subject.references if subject.result is None else subject.result.queries
    return int(rows["stamp_ns"].min()) if len(rows) else 0


def _facts(subject: Subject) -> dict[str, str]:
    header: Mapping[str, Any] = subject.header
    return {key: str(header.get(key, "")) for key in ("fpnav", "format", "system", "preset")}


def _metrics(result: Result) -> bytes:
    """Name to value, n and of, as JSON."""
    metrics = evaluate(result).metrics
    values = {name: {"value": m.value, "n": m.n, "of": m.of} for name, m in metrics.items()}
    return json.dumps(values, sort_keys=True, allow_nan=False).encode()
