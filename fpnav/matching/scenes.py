"""Scenes of vertical edges compared: the four algorithms of Kortenkamp and Weymouth, and a fifth
that does not fall over cell borders (systems.md 3.7, 3.11).

Every score is the share of what a stored scene holds that the present one shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.matching import scene_kernels as kernels
from fpnav.sensing.cues import CUE
from fpnav.sensing.scene import cells_of, columns_of, distance_class
from fpnav.values import FloatArray

FEATURE, CELL_CUE, CELL_DIRECTION, CELL_OCCUPIED = 1, 2, 3, 4
"""The paper's algorithms: whole features by direction and distance; cells by direction and
distance, by direction alone, by being occupied."""


@dataclass(frozen=True, slots=True, eq=False)
class Scenes:
    """Batch of N scenes as flat columns; scene n owns rows ``offsets[n]`` to ``offsets[n + 1]``.

    ``whole`` (R, 5) int64 : facing, direction, column, cells, distance class
    ``real`` (R, 6) float64 : x, top, bottom (pixels), distance (metres, NaN unknown), strength,
        weight
    ``facings`` (N,) int64 : bit f is set where the scene looked in direction f
    """

    whole: NDArray[np.int64]
    real: FloatArray
    offsets: NDArray[np.int64]
    facings: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.facings)


@dataclass(frozen=True, slots=True)
class Soft:
    """The fifth algorithm: a cue counts by how near, as tall and as far it is, at the best of
    several shifts and scales of the present scene.

    width_px : distance across at which a cue no longer counts
    shift_px, shift_step_px : shifts tried; scales : scales tried about the image's middle
    off : what a shift or a scale to the limit costs
    unknown : worth of a distance that is not known on either side
    beta : how many times more the stored cues count than those the present scene has besides
    """

    width_px: float = 48.0
    shift_px: float = 47.0
    shift_step_px: float = 6.0
    scales: tuple[float, ...] = (0.9, 1.0, 1.1)
    off: float = 0.15
    unknown: float = 0.7
    beta: float = 2.0


def scenes_of(
    cues: Sequence[NDArray[np.void]],
    facings: Sequence[int],
    weights: Sequence[FloatArray] | None = None,
) -> Scenes:
    """Batch of scenes from the CUE rows of each; without weights every cue counts 1."""
    lengths = [len(rows) for rows in cues]
    flat: NDArray[Any] = np.concatenate(cues) if cues else np.zeros(0, CUE)
    weight = np.concatenate(weights) if weights else np.ones(len(flat))
    whole = np.zeros((len(flat), 5), np.int64)
    real = np.zeros((len(flat), 6))
    if len(flat):
        columns = flat["facing"], flat["direction"], columns_of(flat), cells_of(flat)
        whole[:] = np.column_stack([*columns, distance_class(flat["distance_m"])])
        names = ("x_px", "top_px", "bottom_px", "distance_m", "strength")
        real[:] = np.column_stack([*(flat[name] for name in names), weight])
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    return Scenes(whole, real, offsets, np.array(facings, np.int64).reshape(len(lengths)))


def match_scores(
    present: Scenes, stored: Scenes, method: int, distance_share: float = 0.25
) -> FloatArray:
    """Score of every present scene with every stored one by one of the paper's four algorithms.

    A stored cue or cell counts only where the present scene looked; a scene without any scores 0.
    A cell is of one cue, the strongest edge in it ("connected to a representation of a visual
    cue"); distances fit within ``distance_share`` of the larger.

    Returns
    -------
    (Q, N) in [0, 1]
    """
    out = np.zeros((len(present), len(stored)))
    one, other = _columns(present), _columns(stored)
    kernels.hard(one, other, method, distance_share, out)
    return out


def soft_scores(present: Scenes, stored: Scenes, soft: Soft) -> FloatArray:
    """Score of every present scene with every stored one by the fifth algorithm, (Q, N)."""
    steps = np.floor(soft.shift_px / soft.shift_step_px)
    shifts = soft.shift_step_px * np.arange(-steps, steps + 1.0)
    scales = np.array(soft.scales)
    reach = max(float(np.abs(scales - 1.0).max()), 1e-9)
    cost = 1.0 - soft.off * np.maximum(
        np.abs(shifts)[:, None] / max(soft.shift_px, 1e-9), np.abs(scales - 1.0)[None, :] / reach
    )
    out = np.zeros((len(present), len(stored)))
    rule = np.array([soft.width_px, soft.unknown, soft.beta])
    kernels.soft(_columns(present), _columns(stored), shifts, scales, cost, rule, out)
    return out


def unique_best(scores: FloatArray) -> NDArray[np.int64]:
    """Column of the largest score of each row, -1 where several share it or all are 0, (Q,).

    The paper's decision: a tie is no match.
    """
    if scores.shape[1] == 0:
        return np.full(len(scores), -1, np.int64)
    best = scores.max(axis=1, keepdims=True)
    alone = ((scores == best).sum(axis=1) == 1) & (best[:, 0] > 0.0)
    return np.where(alone, scores.argmax(axis=1), -1).astype(np.int64)


def _columns(scenes: Scenes) -> tuple[Any, ...]:
    return scenes.whole, scenes.real, scenes.offsets, scenes.facings
