"""Every recording of FPNAV_DATA through every system that can use it: the README's table.

``python -m benchmarks.real [--keep] [--only NAME,...] [-o DIR]``; the runs stand in real.toml. Each
is ingested, recognised and reported by the command line as a user would; the table between the
markers of README.md is written anew from the reports. A run whose files are not there is left out,
and that is said.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks import truth

ROOT = Path(__file__).resolve().parents[1]
RUNS = Path(__file__).with_suffix(".toml")
FOLDER = ROOT / "build" / "real"
BEGIN, END = "<!-- real: begin -->", "<!-- real: end -->"
HEAD = (
    "| recording | system | recall at 1 | average precision | recall at precision 1.00 (dc) |\n"
    "|---|---|---|---|---|"
)


PLACES = "@%="


@dataclass(frozen=True, slots=True)
class Places:
    """Where the words of real.toml that name files point: ``data`` is FPNAV_DATA, ``made`` where
    benchmarks.truth wrote."""

    data: Path
    made: Path

    @staticmethod
    def usual(output: Path) -> Places:
        """FPNAV_DATA as the environment has it, what is made below the folder of results."""
        data = Path(os.environ.get("FPNAV_DATA", ROOT.parent / "shared" / "data"))
        return Places(data, output / "truth")

    def path(self, word: str) -> Path:
        """The file a word names; one that does not exist where its package is not installed."""
        kind, name = word[0], word[1:]
        if kind != "%":
            return {"@": self.data, "=": self.made}[kind] / name
        package, _, inner = name.partition("/")
        found = importlib.util.find_spec(package)
        folders = [] if found is None else found.submodule_search_locations or []
        return Path(folders[0] if folders else f"no package {package}") / inner

    def located(self, words: Sequence[str]) -> list[str]:
        """Words, those that name files as paths."""
        return [str(self.path(word)) if word[0] in PLACES else word for word in words]


@dataclass(frozen=True, slots=True)
class Run:
    """One recording: ``ingest`` lists what to ingest, one or two logs (reference, query).

    Words that name files begin with ``@`` (of FPNAV_DATA), ``%`` (of an installed package) or
    ``=`` (made by benchmarks.truth). ``recognize`` : options of recognition; ``systems`` : names
    with their options; ``truth`` : how the table names it.
    """

    name: str
    title: str
    truth: str
    ingest: tuple[tuple[str, ...], ...]
    recognize: tuple[str, ...]
    systems: tuple[tuple[str, tuple[str, ...]], ...]

    def files(self) -> Iterator[str]:
        """The words that name files and folders."""
        words = [*self.recognize, *(word for log in self.ingest for word in log)]
        return (word for word in words if word.startswith(tuple(PLACES)))


def runs() -> list[Run]:
    """The runs of real.toml, in its order."""
    table = tomllib.loads(RUNS.read_text(encoding="utf-8"))
    groups = {name: _systems(lines) for name, lines in table["systems"].items()}
    return [
        Run(
            one["name"],
            one["title"],
            one["truth"],
            tuple(tuple(words) for words in one["ingest"]),
            tuple(one["recognize"]),
            groups[one["systems"]],
        )
        for one in table["run"]
    ]


def _systems(lines: Sequence[str]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """``name options...`` as name and options."""
    return tuple((words[0], tuple(words[1:])) for words in (line.split() for line in lines))


def missing(run: Run, places: Places) -> list[str]:
    """Files of a run that are not there."""
    return [word[1:] for word in run.files() if not places.path(word).exists()]


def results(run: Run, places: Places, out: Path, *, keep: bool) -> list[Path]:
    """Result files of a run, one per system, in order."""
    folder = out / run.name
    folder.mkdir(parents=True, exist_ok=True)
    logs = [folder / f"log{number}.mcap" for number in range(len(run.ingest))]
    for log, words in zip(logs, run.ingest, strict=True):
        if not (keep and log.exists()):
            fpnav("ingest", *places.located(words), "-o", str(log))
    found = []
    for name, options in run.systems:
        result = folder / ("_".join([name, *options]).replace("-", "").replace("/", "") + ".h5")
        if not (keep and result.exists()):
            words = (*places.located(run.recognize), *options)
            fpnav("recognize", *map(str, logs), "-s", name, *words, "-o", str(result))
        found.append(result)
    return found


def fpnav(*words: str) -> None:
    """One command line; ends the program where it fails."""
    print("fpnav", *words, flush=True)
    subprocess.run([sys.executable, "-m", "fpnav", *words, "-q"], check=True)


def metrics(files: Sequence[Path], folder: Path) -> list[Mapping[str, Any]]:
    """Metrics of result files, through the report."""
    fpnav("report", *map(str, files), "-o", str(folder))
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    by_name = {one["name"]: one["metrics"] for one in report["results"]}
    return [by_name[file.stem] for file in files]


def rows(run: Run, found: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Lines of the table; the best recall and precision are set in bold."""
    first = f"{run.title}, {run.truth}"
    names = ("recall_at_1", "average_precision", "recall_at_100_precision_dc")
    best = {
        name: max((one[name]["value"] for one in found if name in one), default=None)
        for name in names
    }
    for (system, options), one in zip(run.systems, found, strict=True):
        cells = [cell(one.get(name), best[name], counted=name == names[0]) for name in names]
        yield f"| {first} | {' '.join([f'`{system}`', *options])} | " + " | ".join(cells) + " |"
        first = ""


def cell(metric: Mapping[str, Any] | None, best: float | None, *, counted: bool) -> str:
    """A value, with n of N and the 95 % interval where asked for."""
    if metric is None:
        return "-"
    value = f"{metric['value']:.3f}"
    value = f"**{value}**" if metric["value"] == best else value
    if not counted:
        return value
    low, high = metric["low"], metric["high"]
    interval = "" if low is None else f", {low:.2f}-{high:.2f}"
    return f"{value} ({metric['n']} of {metric['of']}{interval})"


def rewrite(page: Path, name: str, lines: Sequence[str]) -> None:
    """Put lines between the markers of a page."""
    text = page.read_text(encoding="utf-8")
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    page.write_text(f"{text[:begin]}\n{chr(10).join(lines)}\n{text[end:]}", encoding="utf-8")


def main() -> None:
    """Run what is there, say what is not, rewrite the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="reuse results that are there")
    parser.add_argument("--only", default="", help="names of runs, by commas; no table is written")
    parser.add_argument("-o", "--output", type=Path, default=FOLDER)
    given = parser.parse_args()
    places = Places.usual(given.output)
    wanted = [run for run in runs() if not given.only or run.name in given.only.split(",")]
    if any(word.startswith("=") for run in wanted for word in run.files()):
        truth.main(["-o", str(places.made)])
    lines = [HEAD]
    for run in wanted:
        absent = missing(run, places)
        if absent:
            print(f"{run.name}: left out, there is no {', '.join(absent)}", flush=True)
            continue
        files = results(run, places, given.output, keep=given.keep)
        lines += rows(run, metrics(files, given.output / run.name / "report"))
    print("\n".join(lines))
    if not given.only and len(lines) > 1:
        rewrite(ROOT / "README.md", "real", lines)


if __name__ == "__main__":
    main()
