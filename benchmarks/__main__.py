"""Run every benchmark, or the ones named; each prints its own lines."""

from __future__ import annotations

import importlib
import sys

BENCHMARKS = {
    "startup": "fpnav --help against importing click",
    "alignment": "cyclic alignment against Biopython's aligner",
    "read_scans": "reading all scans of a log against mcap-ros2-support",
    "simulator": "simulated frames per second",
}


def main(names: list[str]) -> None:
    """Run the named benchmarks, all by default."""
    for name in names or list(BENCHMARKS):
        print(f"== {name}: {BENCHMARKS[name]}", flush=True)
        importlib.import_module(f"benchmarks.{name}").main()


if __name__ == "__main__":
    main(sys.argv[1:])
