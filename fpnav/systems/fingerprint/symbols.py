"""Features and symbols of a fingerprint: correspondence, empty space, the readable string."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import UsageError
from fpnav.geometry import TAU
from fpnav.values import FloatArray

ALPHABET = "ABCDEFGHIJKLMNOPvcfn"
COLOURS = 16
V, C, F, N = 16, 17, 18, 19
LASER, CAMERA = 0, 1

_CODE_OF = {letter: code for code, letter in enumerate(ALPHABET)}
_ORDER = np.array([1] * COLOURS + [2, 0, 3, 4])
"""Order of symbols at one angle: c, colour, v, f (systems.md 1.3.5), then n."""

TIE_RAD = np.deg2rad(0.5)

FEATURE = np.dtype(
    [
        ("type", "S1"),
        ("angle_rad", "<f8"),
        ("certainty", "<f4"),
        ("width_rad", "<f4"),
        ("range_m", "<f4"),
        ("seen", "<i4"),
    ]
)
"""A perceived feature: v, c or a hue A..P; angle in [0, 2 pi), counter-clockwise from ahead;
``seen`` in how many of this and the few fingerprints before it; in a mean, in how many fused."""

SYMBOL = np.dtype([("type", "S1"), ("angle_rad", "<f8"), ("certainty", "<f4"), ("feature", "<i2")])
"""A letter of the string; ``feature`` is the row it stands for, -1 for f and n."""


def features_of(
    letters: NDArray[Any], angles_rad: FloatArray, certainty: FloatArray
) -> NDArray[Any]:
    """Rows of FEATURE with angles wrapped to [0, 2 pi), seen once, without width and range."""
    rows = np.zeros(len(letters), FEATURE)
    rows["type"] = letters
    rows["angle_rad"] = unsigned(angles_rad)
    rows["certainty"] = certainty
    rows["range_m"] = np.nan
    rows["seen"] = 1
    return rows


def unsigned(angles_rad: FloatArray) -> FloatArray:
    """Angles wrapped to [0, 2 pi)."""
    wrapped = np.mod(np.asarray(angles_rad, dtype=np.float64), TAU)
    return np.where(wrapped >= TAU, 0.0, wrapped)


def codes(letters: NDArray[Any]) -> NDArray[np.uint8]:
    """Code 0..19 of each letter; -> ALPHABET."""
    table = np.full(256, 255, np.uint8)
    table[[ord(letter) for letter in ALPHABET]] = np.arange(len(ALPHABET))
    return np.asarray(table[np.ascontiguousarray(letters, "S1").view(np.uint8)])


def symbols_of(
    features: NDArray[Any],
    arcs: FloatArray,
    *,
    pair_rad: float,
    delta_rad: float,
    certainty_n: float,
) -> NDArray[Any]:
    """String of features, with correspondences f and empty space n inserted, by angle.

    Parameters
    ----------
    features : (F,) FEATURE
    arcs : (A, 2) centre and width of what each sensor covered; n stands only where one did
    """
    own = np.zeros(len(features), SYMBOL)
    for name in ("type", "angle_rad", "certainty"):
        own[name] = features[name]
    own["feature"] = np.arange(len(features))
    pairs = _corresponding(features, pair_rad)
    empty = _empty_space(np.sort(features["angle_rad"]), arcs, delta_rad, certainty_n)
    return _sorted(np.concatenate([own, pairs, empty]))


def text(symbols: NDArray[Any]) -> str:
    """The readable string, from the first symbol at or left of the heading, counter-clockwise."""
    return bytes(np.ascontiguousarray(symbols["type"]).tobytes()).decode("ascii")


def parse(string: str, certainty: float = 1.0) -> NDArray[Any]:
    """Symbols of a string, evenly spaced around the circle.

    Raises
    ------
    UsageError
        A letter is not of the alphabet.
    """
    unknown = sorted(set(string) - set(_CODE_OF))
    if unknown:
        raise UsageError(
            f"{string!r} is no fingerprint: {''.join(unknown)!r} is not of {ALPHABET!r}"
        )
    rows = np.zeros(len(string), SYMBOL)
    rows["type"] = np.frombuffer(string.encode("ascii"), "S1")
    rows["angle_rad"] = np.arange(len(string)) * (TAU / max(len(string), 1))
    rows["certainty"] = certainty
    rows["feature"] = -1
    return rows


def _corresponding(features: NDArray[Any], pair_rad: float) -> NDArray[Any]:
    """One f for each corner and edge paired greedily, closest first."""
    kinds = codes(features["type"])
    corners, edges = np.flatnonzero(kinds == C), np.flatnonzero(kinds == V)
    angles = features["angle_rad"]
    turn = (angles[edges][None, :] - angles[corners][:, None] + np.pi) % TAU - np.pi
    rows: list[tuple[bytes, float, float, int]] = []
    free_c, free_v = np.ones(len(corners), bool), np.ones(len(edges), bool)
    near_c, near_v = np.nonzero(np.abs(turn) <= pair_rad)
    for at in np.lexsort((near_v, near_c, np.abs(turn[near_c, near_v]))):
        c, v = near_c[at], near_v[at]
        if not (free_c[c] and free_v[v]):
            continue
        free_c[c] = free_v[v] = False
        certainty = features["certainty"][[corners[c], edges[v]]].astype(np.float64)
        middle = float(angles[corners[c]] + turn[c, v] / 2.0)
        rows.append((b"f", middle, float(np.sqrt(certainty.prod())), -1))
    out = np.array(rows, SYMBOL)
    out["angle_rad"] = unsigned(out["angle_rad"])
    return out


def _empty_space(
    angles: FloatArray, arcs: FloatArray, delta_rad: float, certainty: float
) -> NDArray[Any]:
    """n symbols evenly inside every gap, one per delta, where a sensor covered (1.3.6)."""
    if len(angles):
        starts, gaps = angles, np.diff(np.append(angles, angles[0] + TAU))
        counts = np.floor(gaps / delta_rad + 1e-9).astype(np.int64)
        share = gaps / (counts + 1)
        first = 1
    else:
        starts, counts = np.zeros(1), np.array([int(TAU / delta_rad + 1e-9)])
        share, first = TAU / np.maximum(counts, 1), 0
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + first
    where = np.repeat(starts, counts) + number * np.repeat(share, counts)
    off = np.abs((where[:, None] - arcs[None, :, 0] + np.pi) % TAU - np.pi)
    where = where[(off <= arcs[None, :, 1] / 2.0).any(axis=1) & (arcs[:, 1] > 0.0).any()]
    rows = np.zeros(len(where), SYMBOL)
    rows["type"], rows["angle_rad"] = b"n", unsigned(where)
    rows["certainty"], rows["feature"] = certainty, -1
    return rows


def _sorted(symbols: NDArray[Any]) -> NDArray[Any]:
    """By angle; within half a degree c, colour, v, f."""
    bins = np.floor(symbols["angle_rad"] / TIE_RAD + 1e-9)
    kinds = codes(symbols["type"])
    order = np.lexsort((kinds, symbols["angle_rad"], _ORDER[kinds], bins))
    return symbols[order]
