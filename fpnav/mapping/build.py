"""The incremental builder: a new place where the world changes (systems.md 1.8).

Pass one walks the run once and asks the system how new each signature is; a place starts where
that reaches the threshold. Places too small to stand alone join the neighbour they are more like,
and loops are closed. Then the memory learns every place anew in travel order, and the travelled
edges are counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.mapping.loops import LoopParams, close_loops
from fpnav.mapping.places import learned, make_edges, make_places, runs_of
from fpnav.mapping.segment import change_points, resolve_threshold
from fpnav.mapping.sequences import close_sequences
from fpnav.systems.base import Memory, System, Trace
from fpnav.topomap.graph import TopoMap
from fpnav.values import FloatArray, Signature

Advance = Callable[[int], None]


@dataclass(frozen=True, slots=True, eq=False)
class Built:
    """What the builder makes: the map, the memory behind it, the trace it decided on."""

    topomap: TopoMap
    memory: Memory
    novelty: FloatArray
    threshold: float


def build_map(
    system: System,
    signatures: Sequence[Signature],
    *,
    guided: bool = False,
    loops: LoopParams | None = None,
    advance: Advance,
) -> Built:
    """Topological map of one or more mapping sessions.

    Parameters
    ----------
    signatures : in travel order; sessions follow one another and are not joined by an edge
    guided : the label decides the place
    loops : how loops are closed, None = not at all; labels need no closing
    advance : called with the number of signatures done

    Raises
    ------
    LogError
        There is no signature to build from.
    """
    if len(signatures) == 0:
        raise LogError("no signatures to build a map from")
    merged: dict[int, tuple[int, ...]] = {}
    threshold = math.nan
    if guided:
        novelty, owner = np.full(len(signatures), np.nan), places_by_label(signatures)
        advance(len(signatures))
    else:
        unlike = resolve_threshold(system.rule, lambda: consecutive_novelty(system, signatures))
        novelty, owner, threshold = _opened(system, signatures, unlike, advance)
        if loops is not None:
            close = close_sequences if system.rule.sequences else close_loops
            owner, merged = close(system, signatures, owner, unlike, loops)
    places = [
        replace(place, merged_from=merged.get(place.id, ()))
        for place in make_places(signatures, owner)
    ]
    topomap = TopoMap.of(places, make_edges(signatures, owner))
    memory = learned(system, signatures, owner)
    memory.shrink(system.rule.budget)
    return Built(topomap, memory, novelty, threshold)


def _opened(
    system: System, signatures: Sequence[Signature], unlike: float, advance: Advance
) -> tuple[FloatArray, NDArray[np.int64], float]:
    """The open chain of places: novelty, owners, and what the novelty was compared with."""
    rule = system.rule
    if rule.window > 0:
        novelty, owner = change_points(system, signatures, rule)
        advance(len(signatures))
        return novelty, owner, rule.penalty
    novelty, owner = walk(system, signatures, unlike, advance)
    return novelty, absorb_small(system, signatures, owner, rule.min_observations), unlike


def consecutive_novelty(system: System, signatures: Sequence[Signature]) -> FloatArray:
    """Dissimilarity of each signature to the one before it in its session, (N - sessions,)."""
    return np.array(
        [
            1.0 - system.similarity(first, second)
            for first, second in pairwise(signatures)
            if first.reference.session == second.reference.session
        ]
    )


def walk(
    system: System, signatures: Sequence[Signature], threshold: float, advance: Advance
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Novelty of each signature as the robot drives, and the place it starts or joins.

    The memory learns as it goes, so that a novelty against the present place's mean sees what a
    robot would have seen. A new session starts a new place.
    """
    memory = system.memory()
    memory.fit(signatures)
    novelty = np.full(len(signatures), np.nan)
    owner = np.zeros(len(signatures), dtype=np.int64)
    place = 0
    previous: Signature | None = None
    trace: Trace = None
    for row, signature in enumerate(signatures):
        if previous is not None and previous.reference.session != signature.reference.session:
            place, previous, trace = place + 1, None, None
        elif previous is not None:
            novelty[row], trace = memory.novelty(signature, previous, trace)
            place += int(novelty[row] >= threshold)
        memory.learn(place, signature)
        owner[row], previous = place, signature
        advance(1)
    return novelty, owner


def places_by_label(signatures: Sequence[Signature]) -> NDArray[np.int64]:
    """Place ids in the order the labels are first met.

    A label holds until the next of its session; what comes before the first is labelled like it.

    Raises
    ------
    LogError
        A session carries no label.
    """
    ids: dict[str, int] = {}
    owner: list[int] = []
    for session, rows in groupby(signatures, key=lambda row: row.reference.session):
        labels = [row.reference.label for row in rows]
        current = next(filter(None, labels), "")
        if not current:
            raise LogError(
                f"guided training needs a label topic; session {session} has no label "
                "(--topic label=/name)"
            )
        for label in labels:
            current = label or current
            owner.append(ids.setdefault(current, len(ids)))
    return np.array(owner, dtype=np.int64)


def absorb_small(
    system: System, signatures: Sequence[Signature], owner: NDArray[np.int64], least: int
) -> NDArray[np.int64]:
    """Owners with every run shorter than ``least`` joined to the more similar neighbour run.

    Runs of another session are no neighbours; ids are renumbered from 0 in travel order.
    """
    references = [signature.reference for signature in signatures]
    runs = [list(run) for run in runs_of(references, owner)]
    i = 0
    while i < len(runs):
        into = _better_neighbour(system, signatures, runs, i) if len(runs[i]) < least else None
        if into is None:
            i += 1
        else:
            runs[into] = sorted(runs[into] + runs[i])
            del runs[i]
    out = np.zeros(len(owner), dtype=np.int64)
    for place, run in enumerate(runs):
        out[run] = place
    return out


def _better_neighbour(
    system: System, signatures: Sequence[Signature], runs: list[list[int]], i: int
) -> int | None:
    session = signatures[runs[i][0]].reference.session
    scored = [
        (system.similarity(signatures[mine], signatures[theirs]), -j)
        for j, mine, theirs in _borders(runs, i)
        if signatures[theirs].reference.session == session
    ]
    return -max(scored)[1] if scored else None


def _borders(runs: list[list[int]], i: int) -> list[tuple[int, int, int]]:
    before = [(i - 1, runs[i][0], runs[i - 1][-1])] if i > 0 else []
    after = [(i + 1, runs[i][-1], runs[i + 1][0])] if i + 1 < len(runs) else []
    return before + after
