"""Recall with landmarks selected at a budget per place beside recall with all of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from benchmarks.timing import in_turn
from fpnav.execution.checkpoint import Checkpoints
from fpnav.execution.spread import Here
from fpnav.execution.stages import make_map
from fpnav.execution.walk import LogOptions, Run, SystemChoice, signatures_of
from fpnav.systems.base import Memory

LOGS = Path(__file__).parents[1] / "sample_logs"
PRESET = "fig4c"
BUDGETS = (0, 60, 40, 20)
PANORAMAS, SPACING_M = 20, 0.3


def main() -> None:
    """Print landmarks kept and the time a panorama takes to be located, for every budget."""
    cv2.setNumThreads(1)
    memories = {budget: memory_of(budget) for budget in BUDGETS}
    asked = list(run_of("office_test.mcap", 0).table)[:PANORAMAS]
    calls: dict[str, Callable[[], object]] = {
        str(budget): partial(memory.recall, asked, 1, None, None)
        for budget, (memory, _) in memories.items()
    }
    medians = in_turn(calls)
    for budget, (_, landmarks) in memories.items():
        kept = f"{budget} a place" if budget else "all"
        each_ms = 1e3 * medians[str(budget)] / PANORAMAS
        ratio = medians[str(budget)] / medians["0"]
        print(f"  {kept:12s} {landmarks:7,d} landmarks {each_ms:8.2f} ms a panorama  x {ratio:.2f}")


def memory_of(budget: int) -> tuple[Memory, int]:
    """What is learned of the sample office within a budget, and how many landmarks that is."""
    run = run_of("office_map.mcap", budget)
    _, built = make_map(
        run,
        [LOGS / "office_map.mcap"],
        guided=False,
        close_loops=False,
        advance=lambda done: None,
    )
    memory = run.system.memory()
    memory.load(built.memory)
    return memory, len(np.unique(built.memory["triplets"]["landmark"]))


def run_of(name: str, budget: int) -> Run:
    """Signatures of a sample log."""
    choice = SystemChoice(
        "placecell", PRESET, {"placecell": {"budget": budget, "spacing_m": SPACING_M}}
    )
    nowhere = Checkpoints(LOGS / name, resume=False)
    return signatures_of([LOGS / name], choice, LogOptions(), Here(), lambda done: None, nowhere)
