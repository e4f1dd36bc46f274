"""The paper's figures 1, 3 and 4 with what was made here, and runs located on a map."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fpnav.evaluation.evaluate import Evaluation
from fpnav.evaluation.plan import plan_of_world
from fpnav.experiments.tapus.office import Mapped
from fpnav.logs.frames import open_log
from fpnav.report.entry import Entry
from fpnav.report.figures import fingerprints, plans, runs, trajectory
from fpnav.report.figures.style import Drawing
from fpnav.report.study import Illustration
from fpnav.sensing import panorama
from fpnav.values import FloatArray, Frame

NO_POINTS = np.zeros((0, 2))
STRETCH = 7
"""Measurement points of the paper's figure 3."""


def generation(log: Path, mapped: Mapped) -> Illustration:
    """Figure 1: a fingerprint in the making, half way along the mapping run."""
    return Illustration(
        "fingerprint",
        "Figure 1 here: how a fingerprint comes about",
        "The paper shows a panorama with edges and patches, a scan with corners, and the string "
        "cIfvncvfnvncvnnvcvBnvBccE. The same, of the data set half way along the mapping run.",
        partial(_generation, log, mapped),
    )


def new_node(log: Path, mapped: Mapped) -> Illustration:
    """Figure 3: a new node where the world changes."""
    return Illustration(
        "new-node",
        "Figure 3 here: a new node",
        "The paper shows seven measurement points and the laser points for reference; the mapping "
        "adds fingerprints to a node until the dissimilarity passes the threshold.",
        partial(_new_node, log, mapped),
    )


def floor_plan(log: Path, mapped: Mapped) -> Illustration:
    """Figure 4, left: the map on the floor plan."""
    return Illustration(
        "floor-plan",
        "Figure 4 here: the map on the floor plan",
        "The robot starts at S and ends at E. The paper: 75 m, 500 data sets, 20 nodes, none in "
        "front of closed doors.",
        partial(_topological, log, mapped),
    )


def scan_map(log: Path, mapped: Mapped) -> Illustration:
    """Figure 4, right: the map on the raw scans."""
    return Illustration(
        "scan-map",
        "Figure 4 here: the map on the raw scans",
        "Laser points put where the robot truly was, every tenth scan.",
        partial(_on_scans, log, mapped),
    )


def loop_plan(log: Path, mapped: Mapped) -> Illustration:
    """A loop and the places on it."""
    return Illustration(
        "loop",
        "A loop closed",
        "The robot comes back to where it was; a loop is closed where the way back meets places "
        "of the way out.",
        partial(_topological, log, mapped),
    )


def located_plan(name: str, found: Evaluation) -> Illustration:
    """Where each sample of a run was located right and wrong."""
    return Illustration(
        "located",
        f"{name}: right and wrong along the run",
        "Samples on the true path, by their decision.",
        partial(_drawn, trajectory.draw, found),
    )


def belief_over_run(found: Evaluation) -> Illustration:
    """The belief over the whole run."""
    return Illustration(
        "belief",
        "The belief along the run",
        "Rows are places; dots the true one.",
        partial(_drawn, runs.belief, found),
    )


def _drawn(draw: Any, found: Evaluation) -> Drawing:
    entry = Entry("", "", found.case.result.header, found.metrics, evaluation=found)
    drawing: Drawing = draw(entry)
    return drawing


def _generation(log: Path, mapped: Mapped) -> Drawing:
    signatures = mapped[1].signatures
    signature = signatures[len(signatures) // 2]
    frame = next(f for f in _frames(log) if f.reference.index == signature.reference.index)
    if frame.panorama is None or frame.scan is None:
        raise ValueError(f"{log}: the experiments record panorama and scan")
    view = panorama.from_panorama(frame.panorama)
    features = signature.parts["features"]
    corners = features[features["type"] == b"c"]
    symbols = signature.parts["symbols"]
    return fingerprints.generation(
        fingerprints.Generation(
            image=_rgb(view.pixels),
            points=frame.scan.points_m(),
            corners=corners["range_m"][:, None] * _unit(corners["angle_rad"]),
            bearings_rad=symbols["angle_rad"].astype(np.float64),
            letters=symbols["type"].tobytes().decode(),
            certainty=symbols["certainty"].astype(np.float64),
        )
    )


def _new_node(log: Path, mapped: Mapped) -> Drawing:
    """The stretch around the third place that starts on new ground."""
    built = mapped[1]
    references = built.signatures.references
    owner = built.topomap.owner(len(references))
    starts = np.sort(np.unique(owner, return_index=True)[1])
    at = int(starts[min(3, len(starts) - 1)])
    rows = np.arange(max(0, at - STRETCH + 1), min(at + 3, len(owner)))
    seen = set(references["index"][rows].tolist())
    scans = _scans(log, seen)
    return plans.new_node(
        plans.NewNode(
            points=references["truth"][rows, :2],
            scans=scans,
            novelty=built.novelty[rows],
            owner=owner[rows],
            threshold=built.threshold,
        )
    )


def plan_of_run(log: Path, mapped: Mapped, scans: FloatArray = NO_POINTS) -> plans.Plan:
    """A map over the building its log says it was made in."""
    built = mapped[1]
    truth = built.signatures.references["truth"][:, :2]
    owner = built.topomap.owner(len(truth))
    _, first = np.unique(owner, return_index=True)
    with open_log(log) as opened:
        building = plan_of_world(opened.world)
    places = built.topomap.places
    return plans.Plan(
        building=building,
        scans=scans,
        path=truth,
        place_ids=built.topomap.ids,
        places=np.array([truth[place.members[len(place.members) // 2]] for place in places]),
        edges=np.array([(e.source, e.target) for e in built.topomap.edges]).reshape(-1, 2),
        starts=truth[np.sort(first)],
    )


def _topological(log: Path, mapped: Mapped) -> Drawing:
    return plans.topological(plan_of_run(log, mapped))


def _on_scans(log: Path, mapped: Mapped) -> Drawing:
    index = mapped[1].signatures.references["index"]
    return plans.on_scans(plan_of_run(log, mapped, _scans(log, set(index[::10].tolist()))))


def _frames(log: Path) -> Iterator[Frame]:
    with open_log(log) as opened:
        yield from opened.frames()


def _scans(log: Path, wanted: set[int]) -> FloatArray:
    """Laser points of the wanted frames, where the robot truly was, (N, 2)."""
    parts = [NO_POINTS]
    for frame in _frames(log):
        truth = frame.reference.truth
        if frame.reference.index in wanted and frame.scan is not None and truth is not None:
            turn = _unit(np.array([truth.heading_rad]))[0]
            x, y = frame.scan.points_m().T
            here = np.column_stack([x * turn[0] - y * turn[1], x * turn[1] + y * turn[0]])
            parts.append(here + np.array([truth.x_m, truth.y_m]))
    return np.concatenate(parts)


def _unit(angles_rad: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def _rgb(pixels: Any) -> Any:
    """Panorama for drawing: 8 bit RGB."""
    shown = np.asarray(pixels)
    if shown.dtype != np.uint8:
        shown = np.clip(255.0 * shown, 0, 255).astype(np.uint8)
    return cv2.cvtColor(shown, cv2.COLOR_BGR2RGB)
