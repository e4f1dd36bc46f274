"""A laser query among 1,000 candidates: fingerprint, checked, against correlative scan matching.

Both rank all candidates by cheap signatures and then lay scans over each other: fingerprint those
of its best 200, roughly, and the best 16 in full, correlative matching those of its best 20.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

from fpnav.localization.recall import frame_memory
from fpnav.localization.verify import verified
from fpnav.store.signatures import read_signatures
from fpnav.systems.base import System
from fpnav.systems.registry import system_class

LOG = "laser/carmen/freiburg-079-corrected.log.gz"
THIN = ("--step", "0.3", "--step-heading", "15")
CANDIDATES, QUERIES, TOP = 1000, 15, 200


def queries(system: System, file: Path) -> Callable[[int], float]:
    """A function that answers the nth query and says how long that took, seconds of one core."""
    run = read_signatures(file, system.RECORD, system.PARTS)
    reference = [run[row] for row in range(CANDIDATES)]
    asked = [run[row] for row in np.linspace(CANDIDATES, len(run) - 1, QUERIES).astype(int)]
    memory = frame_memory(system, reference)

    def answer(number: int) -> float:
        started = time.process_time()
        found, _ = memory.recall([asked[number]], TOP, None, None)
        verified(system, reference, [asked[number]], found, TOP)
        return time.process_time() - started

    answer(0)
    return answer


def main() -> None:
    """Print milliseconds a query of each and the ratio; the two take turns."""
    data = Path(os.environ.get("FPNAV_DATA", "../shared/data")) / LOG
    if not data.exists():
        print(f"left out: {data} is not there")
        return
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log.mcap"
        _fpnav("ingest", str(data), "-o", str(log))
        answers = {}
        for name in ("fingerprint", "correlative"):
            kind, file = system_class(name), Path(folder) / f"{name}.h5"
            _fpnav("extract", str(log), "-s", name, *THIN, "-o", str(file))
            answers[name] = queries(kind(kind.PRESETS["default"]), file)
        rows = [{name: answer(n) for name, answer in answers.items()} for n in range(QUERIES)]
    spent = {name: median(row[name] for row in rows) for name in answers}
    for name, seconds in spent.items():
        print(f"{name:12s} {seconds * 1e3:7.1f} ms a query of {CANDIDATES} candidates, checked")
    ratio = median(row["fingerprint"] / row["correlative"] for row in rows)
    print(f"fingerprint takes {ratio:.2f} times what correlative scan matching takes")


def _fpnav(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "fpnav", *words, "-q"], check=True)


if __name__ == "__main__":
    main()
