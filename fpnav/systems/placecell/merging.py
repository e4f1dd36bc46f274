"""What and where: merging neurons (eq. 2) and place cells (eq. 3 and 4)."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import angular_distance
from fpnav.values import FloatArray

Shape = Literal["linear", "gaussian"]
NEGLIGIBLE = 0.01


def diffusion(apart_rad: FloatArray, rho: float, shape: Shape) -> FloatArray:
    """Activity g of a direction neuron at an angular distance: 1 at 0, falling to 0.

    ``rho`` is a fraction of pi; 0 stands for infinity: the angle is ignored. Linear reaches 0 at
    rho pi; the Gaussian has standard deviation rho pi / 2 and is 0 below 0.01.
    """
    if rho == 0.0:
        return np.ones_like(apart_rad)
    if shape == "linear":
        return np.asarray(np.maximum(1.0 - apart_rad / (rho * math.pi), 0.0))
    value = np.exp(-0.5 * (apart_rad / (rho * math.pi / 2.0)) ** 2)
    return np.asarray(np.where(value < NEGLIGIBLE, 0.0, value))


def merge(
    triplet: NDArray[np.int64],
    level: FloatArray,
    bearing_rad: FloatArray,
    azimuth_rad: FloatArray,
    offsets_rad: FloatArray,
    rho: float,
    shape: Shape,
) -> tuple[NDArray[np.int64], FloatArray]:
    """Activity of the merging neurons that a panorama excites, at each heading tried.

    Parameters
    ----------
    triplet : (n,) merging neuron each interpretation excites
    level : (n,) product of landmark and elevation activity
    bearing_rad : (n,) of the view in the robot's frame
    azimuth_rad : (n,) learned by the neuron
    offsets_rad : (O,) headings of the robot in the frame of the learned azimuths

    Returns
    -------
    neurons : (m,) excited neurons, ascending
    activity : (m, O) the largest over the views
    """
    order = np.argsort(triplet, kind="stable")
    triplet = triplet[order]
    turn = (bearing_rad - azimuth_rad)[order, None]
    apart = angular_distance(turn, -offsets_rad[None, :])
    product = level[order, None] * diffusion(apart, rho, shape)
    neurons, first = np.unique(triplet, return_index=True)
    if len(neurons) == 0:
        return neurons, np.zeros((0, len(offsets_rad)))
    return neurons, np.maximum.reduceat(product, first, axis=0)


def counted(triplets: NDArray[Any], rho_l: float) -> NDArray[np.int64]:
    """Number of triplets K = max(1, ceil(rho_l W)) that count of a cell's W."""
    exact = np.round(np.asarray(triplets, dtype=np.float64) * rho_l, 9)
    return np.maximum(1, np.ceil(exact)).astype(np.int64)


def cell_activity(
    neurons: NDArray[np.int64],
    activity: FloatArray,
    cell: NDArray[np.int64],
    keep: NDArray[np.int64],
    norm: FloatArray,
) -> tuple[NDArray[np.int64], FloatArray]:
    """Activity of the place cells that some neuron excites (eq. 4; eq. 3 where all count).

    Parameters
    ----------
    neurons, activity : (m,) ascending and (m, O), weighted
    cell : cell of every neuron there is; a cell's neurons follow one another
    keep : (C,) number of its strongest neurons that count
    norm : (C,) what their sum is divided by

    Returns
    -------
    cells : (c,) ascending; activities : (c, O)
    """
    cells, first, count = np.unique(cell[neurons], return_index=True, return_counts=True)
    if len(cells) == 0:
        return cells, np.zeros((0, activity.shape[1]))
    total = np.add.reduceat(activity, first, axis=0)
    for row in np.flatnonzero(count > keep[cells]):
        own = activity[first[row] : first[row] + count[row]]
        weakest = count[row] - keep[cells[row]]
        total[row] = np.partition(own, weakest, axis=0)[weakest:].sum(axis=0)
    return cells, total / norm[cells, None]
