"""Is the simulated office hard enough? Plain peers beside the paper's fingerprint, five seeds.

Every method names the place of data sets of the test drive (every fifth), among the places that the
paper's fingerprint found on the mapping drive. It compares with one view a place (the middle one;
the fingerprint's own way is the mean), or with every view of the mapping drive, of which the
nearest one's place is the answer. The peers learn nothing. A tiny image is compared as it stands or
under every turn; strings always under every turn; a histogram has none.

Options: ``--work FOLDER`` where drives are kept (default build/hardness), ``--seeds 1,2,3``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnav.evaluation.case import judge
from fpnav.evaluation.measure import share
from fpnav.execution.spread import Here
from fpnav.execution.stages import locate_run, make_map
from fpnav.execution.walk import Run, SystemChoice, make_system
from fpnav.experiments.workshop import Workshop, job_of
from fpnav.localization.locate import Method
from fpnav.localization.recall import recall_all
from fpnav.logs.frames import open_log
from fpnav.sensing.panorama import View, from_panorama, grey
from fpnav.store.tables import Result
from fpnav.systems.base import Memory, System
from fpnav.values import FloatArray, Image, Metric

MAPPED, DRIVEN = 1, 2
"""Runs: another day, other people, lamps and blinds on the test drive."""

PAPER = SystemChoice("fingerprint", "paper")
BARE = {"fingerprint": {"scores": "plain", "certainty": "flat"}}
PLAIN = SystemChoice("fingerprint", "paper", BARE)
"""The same strings, scored +1, -1 and -0.5 a gap, every symbol certain."""

TINY = (64, 16)
BINS = (16, 8)
"""Hues and saturations of the histogram."""

EVERY = 5
"""Of the test drive's data sets, 0.15 m apart, one in so many is judged."""

FEWER = 5
"""Of these, one in so many where strings are aligned with every view: that takes long."""

Names = Iterator[tuple[str, Metric]]
Describe = Callable[[View], FloatArray]
Likeness = Callable[[FloatArray, FloatArray], FloatArray]
"""Descriptors (Q, ...) and (R, ...) to how alike they are, (Q, R)."""


@dataclass(frozen=True, slots=True, eq=False)
class Drives:
    """The two drives of one office, and the second located on the map of the first.

    ``asked`` : rows of the test drive that are judged.
    """

    logs: tuple[Path, Path]
    runs: tuple[Run, Run]
    filtered: Result
    memory: Memory
    asked: NDArray[np.int64]

    @property
    def owner(self) -> NDArray[np.int64]:
        """Place of each mapping row."""
        return self.filtered.owner

    @property
    def middles(self) -> NDArray[np.int64]:
        """Mapping row in the middle of each place, (P,)."""
        rows = [np.flatnonzero(self.owner == place) for place in np.unique(self.owner)]
        return np.array([row[len(row) // 2] for row in rows])


def main(arguments: Sequence[str] = ()) -> None:
    """Print the place accuracy of every method: mean and range over the seeds."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hardness")
    parser.add_argument("--work", type=Path, default=Path("build/hardness"))
    parser.add_argument("--seeds", default="1,2,3,4,5")
    given = parser.parse_args(arguments)
    rows: dict[str, list[float]] = {}
    for seed in given.seeds.split(","):
        found = drives(Workshop(given.work, Here()), int(seed))
        print(f"seed {seed}: {len(found.middles)} places, {len(found.asked)} data sets", flush=True)
        for name, metric in measured(found):
            rows.setdefault(name, []).append(metric.value)
            print(f"  {name}: {metric.value:.3f} ({metric.n} of {metric.of})", flush=True)
    for name, values in rows.items():
        print(f"{name}: {np.mean(values):.3f} ({min(values):.3f} to {max(values):.3f})")


def drives(shop: Workshop, seed: int) -> Drives:
    """Both drives of an office, simulated and located unless they are kept already."""
    jobs = job_of("office", "map", seed, MAPPED), job_of("office", "test", seed, DRIVEN)
    mapped, driven = (shop.log(job) for job in jobs)
    known, asked = shop.run(mapped, PAPER), shop.run(driven, PAPER)
    header, built = make_map(known, [mapped], guided=False, close_loops=True, advance=_quiet)
    filtered = locate_run(known.system, header, built, asked, method=Method.FILTER, advance=_quiet)
    memory = known.system.memory()
    memory.load(built.memory)
    judged = np.arange(0, len(asked.table), EVERY)
    return Drives((mapped, driven), (known, asked), filtered, memory, judged)


def measured(found: Drives) -> Names:
    """Name and place accuracy of every method on one pair of drives."""
    matched = recalled(found.memory, found)
    yield "fingerprint, mean of each place", accuracy(found, matched)
    yield "fingerprint, mean, border tolerated", accuracy(found, matched, tolerant=True)
    filtered = found.filtered.places[found.asked, 0]
    yield "fingerprint, filter", accuracy(found, filtered)
    yield "fingerprint, filter, border tolerated", accuracy(found, filtered, tolerant=True)
    views = [list(views_of(*one)) for one in zip(found.logs, found.runs, strict=True)]
    views[1] = [views[1][row] for row in found.asked]
    for name, describe, likeness in IMAGES:
        there, here = (np.stack([describe(view) for view in one]) for one in views)
        yield from of_likeness(name, found, likeness(here, there))
    plain = make_system(PLAIN)[0]
    fewer = replace(found, asked=found.asked[::FEWER])
    (one, middles), (every, rows) = kinds_of_view(found)
    yield f"fingerprint, {one}", of_strings(found.runs[0].system, found, middles)
    yield f"plain Needleman-Wunsch, {one}", of_strings(plain, found, middles)
    yield f"plain Needleman-Wunsch, {every}", of_strings(plain, fewer, rows)


def of_strings(system: System, found: Drives, rows: NDArray[np.int64]) -> Metric:
    """Strings aligned with those of some mapping rows, under every rotation."""
    memory = system.memory()
    for row in rows.tolist():
        memory.learn(row, found.runs[0].table[row])
    return accuracy(found, found.owner[recalled(memory, found)])


def recalled(memory: Memory, found: Drives) -> NDArray[np.int64]:
    """What a memory takes the judged data sets for."""
    queries = [found.runs[1].table[row] for row in found.asked.tolist()]
    return recall_all(memory, queries, 1, None, _quiet).places[:, 0]


def of_likeness(name: str, found: Drives, likeness: FloatArray) -> Names:
    """The likest mapping row of each query by a (Q, R) table, among some rows and among all."""
    for words, rows in kinds_of_view(found):
        best = rows[np.argmax(likeness[:, rows], axis=1)]
        yield f"{name}, {words}", accuracy(found, found.owner[best])


def kinds_of_view(found: Drives) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """The mapping rows that are compared with."""
    yield "one view of each place", found.middles
    yield "every view", np.arange(len(found.owner))


def accuracy(found: Drives, places: NDArray[np.int64], *, tolerant: bool = False) -> Metric:
    """Share of the judged data sets whose place is named."""
    answers = np.full((len(found.filtered.queries), 1), -1, dtype=np.int64)
    answers[found.asked, 0] = places
    case = judge(found.filtered)
    hits = case.within(answers, tolerant=tolerant)[found.asked]
    return share("place_accuracy_top1", hits, case.has_match[found.asked])


def views_of(log: Path, run: Run) -> Iterator[View]:
    """Panoramas of a log that the signatures of a run were made of."""
    wanted = set(run.table.references["index"].tolist())
    with open_log(log, digest=False) as opened:
        for frame in opened.frames(0.0, 0.0):
            if frame.reference.index in wanted and isinstance(frame.panorama, Image):
                yield from_panorama(frame.panorama)


def tiny_image(view: View) -> FloatArray:
    """Small grey image of mean 0 and length 1, (16, 64)."""
    small = cv2.resize(grey(view), TINY, interpolation=cv2.INTER_AREA).astype(np.float64)
    small -= small.mean()
    return np.asarray(small / max(float(np.linalg.norm(small)), 1e-12))


def correlation(here: FloatArray, there: FloatArray) -> FloatArray:
    """Correlation of tiny images (Q, h, w), (R, h, w) as they stand, (Q, R)."""
    return np.asarray(here.reshape(len(here), -1) @ there.reshape(len(there), -1).T)


def turned_correlation(here: FloatArray, there: FloatArray) -> FloatArray:
    """Correlation of tiny images (Q, h, w), (R, h, w) under the best turn, (Q, R)."""
    spectra = np.fft.rfft(here, axis=2), np.conj(np.fft.rfft(there, axis=2))
    rows = [
        np.fft.irfft(np.einsum("hk,rhk->rk", one, spectra[1]), TINY[0], axis=1).max(axis=1)
        for one in spectra[0]
    ]
    return np.stack(rows)


def colour_histogram(view: View) -> FloatArray:
    """Share of the pixels of each hue and saturation, (128,)."""
    hsv = cv2.cvtColor(view.pixels, cv2.COLOR_BGR2HSV)
    counts = cv2.calcHist([hsv], [0, 1], None, list(BINS), [0, 180, 0, 256])
    return np.asarray(counts.ravel() / counts.sum(), dtype=np.float64)


def intersection(here: FloatArray, there: FloatArray) -> FloatArray:
    """Histogram intersection (Swain and Ballard 1991) of (Q, b) and (R, b), (Q, R)."""
    return np.stack([np.minimum(one, there).sum(axis=1) for one in here])


IMAGES: tuple[tuple[str, Describe, Likeness], ...] = (
    ("tiny image", tiny_image, correlation),
    ("tiny image, turned", tiny_image, turned_correlation),
    ("colour histogram", colour_histogram, intersection),
)


def _quiet(done: int) -> None:
    """Nobody is told."""


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])
