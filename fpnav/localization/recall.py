"""Asking a memory for the places of a whole run, in blocks, and what it answers as a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.systems.base import Memory, Recall, System, Trace
from fpnav.values import FloatArray, Signature

Advance = Callable[[int], None]
BLOCK = 64


def recall_all(
    memory: Memory,
    queries: Sequence[Signature],
    k: int,
    allowed: Callable[[int, int], NDArray[np.bool_]] | None,
    advance: Advance,
) -> Recall:
    """Recall in blocks, the trace carried along.

    ``allowed(start, stop)`` gives the (stop - start, P) mask of a block of queries.
    """
    answers = list(_recall_blocks(memory, queries, k, allowed, advance))
    return Recall(
        np.concatenate([answer.places for answer in answers]),
        np.concatenate([answer.scores for answer in answers]),
        np.concatenate([answer.headings_rad for answer in answers]),
    )


def _recall_blocks(
    memory: Memory,
    queries: Sequence[Signature],
    k: int,
    allowed: Callable[[int, int], NDArray[np.bool_]] | None,
    advance: Advance,
) -> Iterator[Recall]:
    trace: Trace = None
    for start in range(0, max(1, len(queries)), BLOCK):
        stop = min(start + BLOCK, len(queries))
        mask = None if allowed is None else allowed(start, stop)
        answer, trace = memory.recall([queries[i] for i in range(start, stop)], k, mask, trace)
        yield answer
        advance(stop - start)


def by_place(recall: Recall, ids: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Scores and headings as (Q, P) over ascending place ids; -inf and NaN where not ranked."""
    shape = (len(recall.places), len(ids))
    scores, headings = np.full(shape, -np.inf), np.full(shape, np.nan)
    rows, ranks = np.nonzero(recall.places >= 0)
    columns = np.searchsorted(ids, recall.places[rows, ranks])
    scores[rows, columns] = recall.scores[rows, ranks]
    headings[rows, columns] = recall.headings_rad[rows, ranks]
    return scores, headings


def frame_memory(system: System, signatures: Sequence[Signature]) -> Memory:
    """A memory in which every signature is a place of its own, its id the row."""
    memory = system.memory()
    memory.fit(signatures)
    for row, signature in enumerate(signatures):
        memory.learn(row, signature)
    return memory
