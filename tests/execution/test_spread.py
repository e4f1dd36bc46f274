"""Worker processes: results in order, and nobody left behind."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fpnav.execution.spread import Here, Processes

LONG = """
import itertools
from fpnav.execution.spread import Processes
for length in Processes(2).ordered(len, itertools.repeat("item")):
    print(length, flush=True)
"""


@pytest.mark.parametrize("spread", [Here(), Processes(2)])
def test_results_come_in_the_order_of_the_items(spread: Here | Processes) -> None:
    assert list(spread.ordered(math.sqrt, range(40))) == [math.sqrt(n) for n in range(40)]


def test_workers_end_with_a_parent_that_was_killed(root: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(root)}
    parent = subprocess.Popen(
        [sys.executable, "-c", LONG],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
        start_new_session=True,
    )
    assert parent.stdout is not None
    with parent.stdout as said:
        said.readline()
        assert len(session(parent.pid)) > 2
        parent.send_signal(signal.SIGKILL)
        parent.wait()
    limit = time.monotonic() + 60
    while session(parent.pid):
        assert time.monotonic() < limit, "workers outlive their parent"
        time.sleep(0.05)


def session(leader: int) -> list[int]:
    """Living processes of a session."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, rest = stat.read_text().rsplit(")", 1)
        except OSError:
            continue
        state, fields = rest.split()[0], rest.split()
        if int(fields[3]) == leader and state != "Z":
            found.append(int(name.split()[0]))
    return found
