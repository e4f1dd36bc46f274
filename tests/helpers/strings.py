"""Random cyclic strings and a plain aligner to compare with."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fpnav.matching.strings import Scores, Strings, on_grid
from fpnav.systems.fingerprint.params import FingerprintParams
from fpnav.systems.fingerprint.scoring import score_table, type_weights
from fpnav.systems.fingerprint.symbols import ALPHABET, codes, parse

SCORES: Scores = score_table(FingerprintParams())
WEIGHTS = type_weights(FingerprintParams())
SILENT = np.array([letter == "n" for letter in ALPHABET])
TAU = 2.0 * math.pi
FULL = ((0.0, TAU), (0.0, TAU))


def strings(
    texts: Sequence[str],
    certainty: Sequence[Sequence[float]] | None = None,
    angles: Sequence[Sequence[float]] | None = None,
    arcs: Sequence[object] | None = None,
    fixed: bool = False,
) -> Strings:
    """Strings of letters; evenly spaced, certain and seen all round unless said."""
    rows = [parse(text) for text in texts]
    if certainty is not None:
        for row, values in zip(rows, certainty, strict=True):
            row["certainty"] = values
    if angles is not None:
        for row, values in zip(rows, angles, strict=True):
            row["angle_rad"] = values
    flat = np.concatenate([parse(""), *rows])
    kinds = codes(flat["type"])
    return Strings(
        kinds,
        on_grid(WEIGHTS[kinds] * flat["certainty"].astype(np.float64)),
        flat["angle_rad"].astype(np.float64),
        np.concatenate([[0], np.cumsum([len(row) for row in rows])]).astype(np.int64),
        np.array(arcs if arcs is not None else [FULL] * len(texts), dtype=np.float64),
        np.full(len(texts), fixed),
    )


def random_strings(
    seed: int, count: int, longest: int, *, partial: bool = False, shortest: int = 0
) -> Strings:
    """Random strings with random certainties and angles, some views partial if asked for."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(shortest, longest + 1, count)
    texts = ["".join(rng.choice(list(ALPHABET), length)) for length in lengths]
    certainty = [rng.uniform(0.3, 1.0, length) for length in lengths]
    angles = [np.sort(rng.uniform(0.0, TAU, length)) for length in lengths]
    arcs = None
    if partial:
        widths = rng.choice([0.0, 1.0, 3.0, TAU], (count, 2))
        arcs = list(np.stack([rng.uniform(-3.0, 3.0, (count, 2)), widths], axis=2))
    return strings(texts, certainty, angles, arcs)


def plain_score(
    x: Sequence[tuple[int, float]], y: Sequence[tuple[int, float]], scores: Scores
) -> float:
    """Needleman-Wunsch as the recurrence of systems.md 1.5 stands, in plain Python, no grid."""
    table = [[0.0] * (len(y) + 1) for _ in range(len(x) + 1)]
    for i in range(len(x) + 1):
        for j in range(len(y) + 1):
            options = []
            if i and j:
                (a, u), (b, v) = x[i - 1], y[j - 1]
                options.append(table[i - 1][j - 1] + 0.5 * (u + v) * scores.sigma[a, b])
            if i:
                options.append(table[i - 1][j] - scores.gap[x[i - 1][0]] * x[i - 1][1])
            if j:
                options.append(table[i][j - 1] - scores.gap[y[j - 1][0]] * y[j - 1][1])
            if options:
                table[i][j] = max(options)
    return table[len(x)][len(y)]


def symbols(batch: Strings, i: int) -> list[tuple[int, float]]:
    """Codes and weights of one string."""
    where = slice(batch.offsets[i], batch.offsets[i + 1])
    pairs = zip(batch.codes[where], batch.weights[where], strict=True)
    return [(int(code), float(weight)) for code, weight in pairs]


def brute_ratio(x: Strings, i: int, y: Strings, j: int, scores: Scores = SCORES) -> float:
    """Best normalised score over all rotations, one plain alignment for each."""
    a, b = symbols(x, i), symbols(y, j)
    total = 0.5 * (sum(weight for _, weight in a) + sum(weight for _, weight in b))
    best = max(plain_score(a[k:] + a[:k], b, scores) for k in range(max(len(a), 1)))
    return best / total if total > 0.0 else 0.0


def turned(batch: Strings, turn_rad: float, shift: int) -> Strings:
    """The one string of a batch with all angles turned and its start moved."""
    order = np.roll(np.arange(len(batch.codes)), shift)
    arcs = batch.arcs.copy()
    arcs[..., 0] += turn_rad
    return Strings(
        batch.codes[order],
        batch.weights[order],
        np.mod(batch.angles_rad[order] + turn_rad, TAU),
        batch.offsets,
        arcs,
        batch.fixed,
    )
