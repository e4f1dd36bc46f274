"""One fingerprint against all of a sample log, over all rotations, with uncertainty.

The peer is Biopython's aligner on the same strings, rotation by rotation, without uncertainty.
"""

from __future__ import annotations

from pathlib import Path

from Bio.Align import PairwiseAligner

from benchmarks.timing import in_turn, show
from fpnav.execution.checkpoint import Checkpoints
from fpnav.execution.spread import Here
from fpnav.execution.walk import LogOptions, SystemChoice, signatures_of
from fpnav.localization.recall import frame_memory

LOG = Path(__file__).parents[1] / "sample_logs" / "office_map.mcap"
QUERY = 40


def main() -> None:
    """Print medians per query for the exact ranking, the pruned best, and the peer."""
    run = signatures_of(
        [LOG],
        SystemChoice("fingerprint", "paper"),
        LogOptions(),
        Here(),
        lambda done: None,
        Checkpoints(LOG, resume=False),
    )
    memory = frame_memory(run.system, run.table)
    query = run.table[QUERY]
    texts = [run.system.picture(signature).text for signature in run.table]
    asked = texts[QUERY]
    turns = [asked[k:] + asked[:k] for k in range(len(asked))]
    aligner = PairwiseAligner(mode="global", match_score=1, mismatch_score=-1, gap_score=-0.5)
    memory.recall([query] * 20, 1, None, None)
    print(f"  {len(texts)} references of {sum(map(len, texts)) // len(texts)} symbols")
    show(
        in_turn(
            {
                "exact best place, pruned": lambda: memory.recall([query], 1, None, None),
                "exact ranking of all": lambda: memory.recall([query], len(texts), None, None),
                "Biopython, all rotations": lambda: [
                    max(aligner.score(turn, text) for turn in turns) for text in texts
                ],
            },
            rounds=3,
        )
    )
