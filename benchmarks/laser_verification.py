"""Learn the two logistics of fingerprint/evidence.py and say how the shipped numbers come about.

The first, of one overlay, from every third query of two recordings, each tested by the other. The
second, of what else a query's candidates show, from the best candidate of every query of five, with
the shipped weights of the first; each is tested by the second logistic of the others. Recordings
that are not there (see benchmarks/real.toml) are left out. Prints figures and weights; takes some
ten minutes of one core.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import truth
from benchmarks.real import FOLDER, Places, Run, missing, runs
from fpnav.localization.recall import frame_memory
from fpnav.localization.recognize import past_candidates
from fpnav.store.signatures import read_signatures
from fpnav.store.tables import SignatureTable
from fpnav.systems.fingerprint import Fingerprint, evidence
from fpnav.systems.fingerprint.params import PRESETS
from fpnav.systems.fingerprint.verification import looked_at
from fpnav.values import FloatArray

FIRST = ("intel", "freiburg-079")
SECOND = (*FIRST, "killian", "belgioioso", "wean")
BELGIOIOSO = Run(
    "belgioioso", "Belgioioso", "1.5 m, 45 deg",
    (("@laser/carmen/belgioioso-corrected.log.gz",),), ("--step", "0"), (),
)  # fmt: skip

EXCLUDE_M = 15.0
RIDGE = 3.0
SPARSER = 3
"""Every which query the first logistic learns from: neighbouring ones say the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Checked candidates of a recording: ``table`` (n, evidence.NAMES), ``same`` (n,) whether it is
    the same place, ``query`` (n,) whose it is. Of each query (Q,): its ``number`` in the run,
    ``around`` (Q, evidence.AROUND_NAMES), ``positive`` whether it has a match at all."""

    table: FloatArray
    same: NDArray[np.bool_]
    query: NDArray[np.int64]
    number: NDArray[np.int64]
    around: FloatArray
    positive: NDArray[np.bool_]

    @property
    def best(self) -> NDArray[np.int64]:
        """Row of the best candidate of each query by the shipped first logistic, (Q,)."""
        logits = evidence.logits(self.table)
        groups = (np.flatnonzero(self.query == number) for number in self.number)
        return np.array([rows[np.argmax(logits[rows])] for rows in groups], np.int64)

    def thinned(self, every: int) -> Examples:
        """Those of every so many queries of the run."""
        queries = self.number % every == 0
        rows = self.query % every == 0
        return Examples(
            self.table[rows], self.same[rows], self.query[rows],
            self.number[queries], self.around[queries], self.positive[queries],
        )  # fmt: skip


def examples(reference: SignatureTable, asked: SignatureTable | None, every: int) -> Examples:
    """Every query of a run in its own past, or of one run in another."""
    params = PRESETS["default"]
    memory = frame_memory(Fingerprint(params), reference)
    queries = reference if asked is None else asked
    allowed = past_candidates(reference.references, EXCLUDE_M, 0) if asked is None else None
    tables, same, query, number, around, positive = [], [], [], [], [], []
    for row in range(0, len(queries), every):
        count = len(reference) if allowed is None else int(allowed[row])
        near = near_rows(reference, queries.references["truth"][row], params.same_m)[:count]
        mask = np.arange(len(reference))[None, :] < count
        found, _ = memory.recall([queries[row]], params.candidates, mask, None)
        ranked = found.places[0][found.places[0] >= 0]
        seen = looked_at(queries[row], [reference[int(k)] for k in ranked], params)
        if seen is None or not len(seen.rows):
            continue
        tables.append(seen.table)
        same.append(near[ranked[seen.rows]])
        query.append(np.full(len(seen.rows), row // every))
        number.append(row // every)
        around.append(seen.around)
        positive.append(bool(near.any()))
    return Examples(
        np.concatenate(tables), np.concatenate(same), np.concatenate(query),
        np.array(number), np.array(around), np.array(positive),
    )  # fmt: skip


def near_rows(run: SignatureTable, pose: FloatArray, radius_m: float) -> NDArray[np.bool_]:
    """Which signatures show the place of a pose by truth, (N,)."""
    there = run.references["truth"]
    turn = np.abs((there[:, 2] - pose[2] + np.pi) % (2 * np.pi) - np.pi)
    apart = np.hypot(*(there[:, :2] - pose[:2]).T)
    return np.asarray((apart <= radius_m) & (turn <= np.deg2rad(PRESETS["default"].same_deg)))


def fitted(table: FloatArray, same: NDArray[np.bool_]) -> tuple[FloatArray, float]:
    """Weights and bias of a logistic with a ridge on standardised columns, by Newton's steps."""
    mean, spread = table.mean(axis=0), table.std(axis=0) + 1e-9
    x = np.column_stack([(table - mean) / spread, np.ones(len(table))])
    ridge = RIDGE * np.append(np.ones(table.shape[1]), 0.0)
    weights = np.zeros(x.shape[1])
    for _ in range(60):
        p = 1.0 / (1.0 + np.exp(-np.clip(x @ weights, -40.0, 40.0)))
        hessian = (x * (p * (1.0 - p) + 1e-9)[:, None]).T @ x + np.diag(ridge)
        weights -= np.linalg.solve(hessian, x.T @ (p - same) + ridge * weights)
    raw = weights[:-1] / spread
    return raw, float(weights[-1] - raw @ mean)


def second_table(one: Examples) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Columns of the second logistic and whether the best candidate is right, of each query."""
    best = one.best
    own = evidence.logits(one.table)[best]
    return np.column_stack([own, one.around]), one.same[best]


def judged(right: NDArray[np.bool_], logits: FloatArray, positive: int) -> str:
    """Recall at 1, average precision and calibration of the answers to all queries."""
    order = np.argsort(-logits, kind="stable")
    precision = np.cumsum(right[order]) / np.arange(1, len(order) + 1)
    stated = 1.0 / (1.0 + np.exp(-logits))
    bins = np.minimum((stated * 10).astype(int), 9)
    gaps = [abs((stated - right)[bins == k].sum()) for k in range(10)]
    skill = 1.0 - ((stated - right) ** 2).mean() / right.var()
    return (
        f"recall_at_1 {right.sum() / positive:.3f} ({right.sum():.0f} of {positive}), "
        f"average_precision {(right[order] * precision).sum() / positive:.3f}, "
        f"ece {sum(gaps) / len(order):.3f}, brier_skill {skill:.2f}"
    )


def learn_first(found: Mapping[str, Examples]) -> None:
    """Each recording by the weights of the other, then the weights of both."""
    thin = {name: found[name].thinned(SPARSER) for name in FIRST if name in found}
    if not thin:
        print(f"first: left out, there is none of {', '.join(FIRST)}")
        return
    for name, one in thin.items():
        others = [other for key, other in thin.items() if key != name]
        if others:
            weights, bias = fitted(*_joined(others))
            logits = one.table @ weights + bias
            best = [rows[np.argmax(logits[rows])] for rows in _groups(one)]
            print(
                f"first, {name}, learned on the other: "
                + judged(one.same[best], logits[best], int(one.positive.sum()))
            )
    weights, bias = fitted(*_joined(list(thin.values())))
    _print("first", evidence.NAMES, weights, bias)


def learn_second(found: Mapping[str, Examples]) -> None:
    """Each recording by the weights of the others, then the weights of all."""
    if not found:
        print("second: left out, there is no recording")
        return
    tables = {name: second_table(one) for name, one in found.items()}
    for name, (table, right) in tables.items():
        others = [pair for key, pair in tables.items() if key != name]
        if others:
            weights, bias = fitted(*(np.concatenate(part) for part in zip(*others, strict=True)))
            figures = judged(right, table @ weights + bias, int(found[name].positive.sum()))
            print(f"second, {name}, learned on the others: {figures}")
    weights, bias = fitted(*(np.concatenate(part) for part in zip(*tables.values(), strict=True)))
    _print("second", ("own", *evidence.AROUND_NAMES), weights, bias)


def signatures(run: Run, places: Places, folder: Path) -> list[SignatureTable]:
    """Signatures of the logs of a run with the default preset."""
    step = [word for word in run.recognize if word not in ("--exclude-path", "15")]
    if "--query-every" in step:
        at = step.index("--query-every")
        del step[at : at + 2]
    tables = []
    for number, words in enumerate(run.ingest):
        log, out = folder / f"{number}.mcap", folder / f"{number}.h5"
        _fpnav("ingest", *places.located(words), "-o", str(log))
        _fpnav("extract", str(log), "-s", Fingerprint.NAME, *step, "-o", str(out))
        tables.append(read_signatures(out, Fingerprint.RECORD, Fingerprint.PARTS))
    return tables


def main() -> None:
    """Collect, learn, test, print."""
    places = Places.usual(FOLDER)
    wanted = {run.name: run for run in (*runs(), BELGIOIOSO) if run.name in SECOND}
    truth.main(["-o", str(places.made)])
    found = {}
    for name in SECOND:
        run = wanted[name]
        if missing(run, places):
            print(f"{name}: left out, there is no {', '.join(missing(run, places))}")
            continue
        with tempfile.TemporaryDirectory() as folder:
            tables = signatures(run, places, Path(folder))
            words = run.recognize
            every = int(words[words.index("--query-every") + 1]) if "--query-every" in words else 1
            found[name] = examples(tables[0], tables[1] if len(tables) > 1 else None, every)
    learn_first(found)
    learn_second(found)


def _joined(many: Sequence[Examples]) -> tuple[FloatArray, NDArray[np.bool_]]:
    return np.concatenate([one.table for one in many]), np.concatenate([one.same for one in many])


def _groups(one: Examples) -> list[NDArray[np.int64]]:
    return [np.flatnonzero(one.query == number) for number in one.number]


def _print(which: str, names: Sequence[str], weights: FloatArray, bias: float) -> None:
    for name, weight in zip((*names, "bias"), (*weights, bias), strict=True):
        print(f"{which}: {name:16s} {weight:9.3f}")


def _fpnav(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "fpnav", *words, "-q"], check=True)


if __name__ == "__main__":
    main()
