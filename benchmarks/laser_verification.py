"""Learn the logistic of fingerprint/evidence.py from two recordings, each tested by the other.

Prints what each recording gives with weights learned on the other, then the weights of both, which
are what the module ships.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fpnav.localization.locate import frame_memory
from fpnav.localization.recognize import past_candidates
from fpnav.store.signatures import read_signatures
from fpnav.store.tables import SignatureTable
from fpnav.systems.fingerprint import Fingerprint, evidence
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.systems.fingerprint.verification import overlays_of
from fpnav.values import FloatArray

RUNS = {
    "intel": ("laser/carmen/intel-corrected.log.gz", ("--step", "0"), 1),
    "freiburg-079": (
        "laser/carmen/freiburg-079-corrected.log.gz",
        ("--step", "0.3", "--step-heading", "15"),
        2,
    ),
}
"""File, thinning, and which fraction of the signatures is a query, as in README."""

EXCLUDE_M = 15.0
RIDGE = 3.0
SPARSER = 3
"""Only every third query is used: neighbouring ones say the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Checked pairs of one recording: ``table`` (n, evidence.NAMES), ``same`` whether it is the
    same place, ``query`` whose it is; ``positive`` queries that have a match at all."""

    table: FloatArray
    same: NDArray[np.bool_]
    query: NDArray[np.int64]
    positive: int


def examples(run: SignatureTable, every: int) -> Examples:
    """Every checked pair of every few queries of a run in its own past."""
    params = PRESETS["default"]
    memory = frame_memory(Fingerprint(params), run)
    candidates = past_candidates(run.references, EXCLUDE_M, 0)
    near = near_pairs(run, params.same_m, params.same_deg)
    tables, same, query, positive = [], [], [], 0
    for row in range(0, len(run), every * SPARSER):
        if candidates[row] == 0:
            continue
        allowed = np.arange(len(run))[None, :] < candidates[row]
        found, _ = memory.recall([run[row]], params.candidates, allowed, None)
        ranked = found.places[0][found.places[0] >= 0]
        rows, table = overlays_of(run[row], [run[int(k)] for k in ranked], params)
        tables.append(table)
        same.append(near[row, ranked[rows]])
        query.append(np.full(len(rows), row))
        positive += bool(near[row, : candidates[row]].any())
    return Examples(np.concatenate(tables), np.concatenate(same), np.concatenate(query), positive)


def near_pairs(run: SignatureTable, radius_m: float, heading_deg: float) -> NDArray[np.bool_]:
    """Which signatures show the same place by truth, (N, N)."""
    pose = run.references["truth"]
    apart = np.hypot(*(pose[:, None, :2] - pose[None, :, :2]).transpose(2, 0, 1))
    turn = np.abs((pose[:, None, 2] - pose[None, :, 2] + np.pi) % (2 * np.pi) - np.pi)
    return np.asarray((apart <= radius_m) & (turn <= np.deg2rad(heading_deg)))


def fitted(table: FloatArray, same: NDArray[np.bool_]) -> tuple[FloatArray, float]:
    """Weights and bias of a logistic with a ridge on standardised columns, by Newton's steps."""
    mean, spread = table.mean(axis=0), table.std(axis=0) + 1e-9
    x = np.column_stack([(table - mean) / spread, np.ones(len(table))])
    ridge = RIDGE * np.append(np.ones(table.shape[1]), 0.0)
    weights = np.zeros(x.shape[1])
    for _ in range(50):
        p = 1.0 / (1.0 + np.exp(-np.clip(x @ weights, -50.0, 50.0)))
        hessian = (x * (p * (1.0 - p) + 1e-9)[:, None]).T @ x + np.diag(ridge)
        weights -= np.linalg.solve(hessian, x.T @ (p - same) + ridge * weights)
    raw = weights[:-1] / spread
    return raw, float(weights[-1] - raw @ mean)


def judged(one: Examples, logits: FloatArray) -> str:
    """Recall at 1, average precision and calibration of the best answer of each query."""
    best = [rows[np.argmax(logits[rows])] for rows in map(np.flatnonzero, _groups(one.query))]
    right, score = one.same[best].astype(float), logits[best]
    order = np.argsort(-score, kind="stable")
    precision = np.cumsum(right[order]) / np.arange(1, len(order) + 1)
    stated = 1.0 / (1.0 + np.exp(-score))
    bins = np.minimum((stated * 10).astype(int), 9)
    gaps = [abs((stated - right)[bins == k].sum()) for k in range(10)]
    skill = 1.0 - ((stated - right) ** 2).mean() / right.var()
    return (
        f"recall_at_1 {right.sum() / one.positive:.3f} ({right.sum():.0f} of {one.positive}), "
        f"average_precision {(right[order] * precision).sum() / one.positive:.3f}, "
        f"ece {sum(gaps) / len(best):.3f}, brier_skill {skill:.2f}"
    )


def _groups(query: NDArray[np.int64]) -> Sequence[NDArray[np.bool_]]:
    return [query == one for one in np.unique(query)]


def signatures(file: str, options: Sequence[str], folder: Path) -> SignatureTable:
    """Signatures of a recording with the default preset."""
    data = Path(os.environ.get("FPNAV_DATA", "../shared/data"))
    log, out = folder / "log.mcap", folder / "signatures.h5"
    for words in (
        ["ingest", str(data / file), "-o", str(log)],
        ["extract", str(log), "-s", Fingerprint.NAME, *options, "-o", str(out)],
    ):
        subprocess.run([sys.executable, "-m", "fpnav", *words, "-q"], check=True)
    return read_signatures(out, Fingerprint.RECORD, Fingerprint.PARTS)


def main() -> None:
    """Learn, test crosswise, print."""
    found = {}
    for name, (file, options, every) in RUNS.items():
        with tempfile.TemporaryDirectory() as folder:
            found[name] = examples(signatures(file, options, Path(folder)), every)
    for name, one in found.items():
        others = [other for key, other in found.items() if key != name]
        weights, bias = fitted(*_joined(others))
        print(f"{name}, learned on the other: {judged(one, one.table @ weights + bias)}")
        shipped = judged(one, evidence.logits(one.table))
        print(f"{name}, as shipped: {shipped}")
    weights, bias = fitted(*_joined(list(found.values())))
    for column, weight in zip(evidence.NAMES, weights, strict=True):
        print(f"{column:16s} {weight:9.3f}")
    print(f"{'bias':16s} {bias:9.3f}")


def _joined(many: Sequence[Examples]) -> tuple[FloatArray, NDArray[np.bool_]]:
    return np.concatenate([one.table for one in many]), np.concatenate([one.same for one in many])


if __name__ == "__main__":
    main()
