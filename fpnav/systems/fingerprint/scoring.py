"""What symbols are worth against each other (systems.md 1.5), as tables for the aligner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.geometry import TAU
from fpnav.matching.coverage import SLACK_RAD
from fpnav.matching.strings import Scores, Strings, on_grid
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.symbols import (
    ALPHABET,
    CAMERA,
    COLOURS,
    LASER,
    SYMBOL,
    C,
    F,
    N,
    V,
    codes,
    unsigned,
)
from fpnav.values import FloatArray

KINDS = 2
HUE_SIGMA = (1.0, 0.5, 0.0)
EMPTY = np.arange(len(ALPHABET)) == N
"""Codes whose matches say nothing about orientation."""


def sigma_table() -> FloatArray:
    """Worth of every pair of codes in [-1, 1]; hue is circular, f asserts both c and v."""
    size = len(ALPHABET)
    sigma = np.full((size, size), -1.0)
    np.fill_diagonal(sigma, 1.0)
    apart = np.abs(np.arange(COLOURS)[:, None] - np.arange(COLOURS)[None, :])
    apart = np.minimum(apart, COLOURS - apart)
    for bins, worth in enumerate(HUE_SIGMA):
        sigma[:COLOURS, :COLOURS][apart == bins] = worth
    for first, second, worth in ((V, F, 0.4), (C, F, 0.4), (V, C, -0.5)):
        sigma[first, second] = sigma[second, first] = worth
    return sigma


def visible_table() -> NDArray[np.bool_]:
    """Which codes can be seen by no sensor, the laser, the camera, both, (20, 4)."""
    covered = np.arange(1 << KINDS)
    laser, camera = (covered >> LASER & 1).astype(bool), (covered >> CAMERA & 1).astype(bool)
    table = np.tile(camera, (len(ALPHABET), 1))
    table[C], table[F], table[N] = laser, laser & camera, laser | camera
    return table


def score_table(params: FingerprintParams) -> Scores:
    """The hand-made scores of the paper's alignment."""
    return Scores(sigma_table(), np.full(len(ALPHABET), params.gamma), visible_table())


def type_weights(params: FingerprintParams) -> FloatArray:
    """Weight tau of each code, (20,)."""
    weights = np.full(len(ALPHABET), params.weight_colour)
    weights[[V, C, F, N]] = params.weight_v, params.weight_c, params.weight_f, params.weight_n
    return weights


def is_open(arcs: FloatArray) -> bool:
    """Whether no sensor sees all round."""
    return bool((arcs[:, 1] < TAU - SLACK_RAD).all())


def cut_open(symbols: NDArray[Any], arcs: FloatArray) -> NDArray[Any]:
    """Symbols of an open view from the right edge of its widest arc; others as they are."""
    if not is_open(arcs):
        return symbols
    centre, width = arcs[int(np.argmax(arcs[:, 1]))]
    along = unsigned(symbols["angle_rad"] - (centre - width / 2.0) + SLACK_RAD)
    return symbols[np.argsort(along, kind="stable")]


def strings_of(
    rows: Sequence[NDArray[Any]],
    arcs: Sequence[FloatArray],
    weights: FloatArray,
    cuts: str,
) -> Strings:
    """Symbol rows with their sensed arcs as a batch for the aligner; w = tau(type) u."""
    flat = np.concatenate([np.zeros(0, SYMBOL), *rows])
    lengths = [len(row) for row in rows]
    kinds = codes(flat["type"])
    certainty = flat["certainty"].astype(np.float64)
    return Strings(
        kinds,
        on_grid(weights[kinds] * certainty),
        flat["angle_rad"].astype(np.float64),
        np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        np.array(arcs, dtype=np.float64).reshape(len(rows), KINDS, 2),
        np.array([cuts == "view" and is_open(one) for one in arcs], dtype=bool),
    )
