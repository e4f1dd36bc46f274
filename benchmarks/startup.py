"""``fpnav --help`` against ``python -c 'import click'``, whole processes."""

from __future__ import annotations

import subprocess
import sys

from benchmarks.timing import in_turn, show


def main() -> None:
    """Print both medians and their ratio (goal: at most 1.5)."""

    def run(*words: str) -> None:
        subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL)

    show(
        in_turn(
            {
                "python -c 'import click'": lambda: run("-c", "import click"),
                "fpnav --help": lambda: run("-m", "fpnav", "--help"),
            },
            rounds=15,
        )
    )
