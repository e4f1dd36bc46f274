"""Run the benchmarks of README's speed table, or the ones named; each prints its own lines."""

from __future__ import annotations

import importlib
import sys

BENCHMARKS = {
    "startup": "fpnav --help against importing click",
    "alignment": "cyclic alignment against Biopython's aligner",
    "read_scans": "reading all scans of a log against mcap-ros2-support",
    "landmarks": "30 local views against many landmarks, against faiss",
    "budget": "recall with few landmarks a place against recall with all",
    "laser_query": "a laser query of 1,000 candidates, checked, against correlative matching",
    "simulator": "simulated frames per second",
    "hardness": "the simulated office: plain peers beside the paper's fingerprint",
}
LONG = {"hardness"}
"""Takes many minutes: run where it is named."""


def main(names: list[str]) -> None:
    """Run the named benchmarks, all but the long ones by default."""
    for name in names or [name for name in BENCHMARKS if name not in LONG]:
        print(f"== {name}: {BENCHMARKS[name]}", flush=True)
        importlib.import_module(f"benchmarks.{name}").main()


if __name__ == "__main__":
    main(sys.argv[1:])
