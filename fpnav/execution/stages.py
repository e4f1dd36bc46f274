"""One function per stage after extraction: what a command or an experiment calls in a row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fpnav.execution.outcome import make_result, no_view, result_header, view_of_map, with_truth
from fpnav.execution.walk import Run, is_store
from fpnav.localization.confidence import Confidence, mapping_confidence
from fpnav.localization.filter import FilterParams
from fpnav.localization.locate import Method, locate
from fpnav.localization.recall import recall_all
from fpnav.localization.recognize import past_candidates, recognize
from fpnav.localization.spots import Spots, along_spots, recall_spots
from fpnav.mapping.build import build_map
from fpnav.mapping.loops import LoopParams
from fpnav.params import NO_TABLES, Tables, as_dict, resolve
from fpnav.store.header import MAP, Header, check_same_signatures, make_header, source_of
from fpnav.store.maps import BuiltMap
from fpnav.store.tables import Ragged, Result, SignatureTable
from fpnav.systems.base import Recall, System
from fpnav.values import Signature

Advance = Callable[[int], None]
RANKS = 25
"""Depth of the ranking that a result keeps."""

CONFIDENCE_SAMPLE = 250
"""Mapping signatures asked, evenly spaced, to learn what right and wrong scores look like."""


def make_map(
    run: Run,
    inputs: Sequence[Path],
    *,
    guided: bool,
    close_loops: bool,
    tables: Tables = NO_TABLES,
    advance: Advance,
) -> tuple[Header, BuiltMap]:
    """Map of a run with the header of its file."""
    loops = resolve("loops", LoopParams(), tables) if close_loops else None
    built = build_map(run.system, run.table, guided=guided, loops=loops, advance=advance)
    every = max(1, len(run.table) // 2 // CONFIDENCE_SAMPLE)
    confidence = mapping_confidence(run.system, run.table, built.topomap, every=every)
    header = make_header(
        MAP,
        system=run.system.NAME,
        preset=run.header["preset"],
        params=as_dict(run.system.params),
        sources=sources_of(run, inputs),
        chain=[run.header],
        ledger=run.header["ledger"],
        guided=guided,
        loops=None if loops is None else as_dict(loops),
        confidence={"midpoint": finite(confidence.midpoint), "slope": confidence.slope},
    )
    return header, BuiltMap(
        built.topomap, run.table, built.novelty, built.threshold, built.memory.save()
    )


def sources_of(run: Run, inputs: Sequence[Path]) -> list[Any]:
    """What a file was made from: the signature files, else the logs they would hold."""
    if all(is_store(path) for path in inputs):
        return [source_of(path) for path in inputs]
    return list(run.header["sources"])


def finite(value: float) -> float | None:
    """JSON has no infinity: None stands for it."""
    return value if np.isfinite(value) else None


def locate_run(
    system: System,
    map_header: Header,
    built: BuiltMap,
    run: Run,
    *,
    method: Method,
    tables: Tables = NO_TABLES,
    truth_file: Path | None = None,
    advance: Advance,
) -> Result:
    """Locate a run's signatures on a map.

    Raises
    ------
    StoreError
        The run's signatures were not made like the map's.
    """
    found = locate_by(
        system,
        map_header,
        built,
        run,
        methods=(method,),
        tables=tables,
        truth_file=truth_file,
        advance=advance,
    )
    return found[0]


def locate_by(
    system: System,
    map_header: Header,
    built: BuiltMap,
    run: Run,
    *,
    methods: Sequence[Method],
    tables: Tables = NO_TABLES,
    truth_file: Path | None = None,
    recall: Recall | None = None,
    spots: Spots | None = None,
    advance: Advance = lambda done: None,
) -> list[Result]:
    """The same by several methods, each signature matched once.

    ``recall``, ``spots`` : what ``recall_run`` gave for the run and ``spots_along`` for the map,
    where they are known already.
    """
    check_same_signatures(map_header, run.header, ("the map", "the query"), system.LATE)
    params = resolve("filter", FilterParams(), tables)
    queries, truth = with_truth(run.table, built.signatures, truth_file)
    if recall is None:
        recall = recall_run(system, built, queries, advance)
    believed = bool(set(methods) - {Method.MATCH})
    along = None
    if believed and (spots := spots or spots_along(system, built, params)) is not None:
        along = along_spots(system, built.topomap, built.signatures, queries, recall, spots, params)
    results = []
    for method in methods:
        answers = locate(
            system,
            built.topomap,
            built.signatures,
            queries,
            recall,
            method=method,
            params=params,
            confidence=_confidence_of(map_header),
            depth=RANKS,
            along=along,
        )
        by = None if method is Method.MATCH else as_dict(params)
        protocol = {**_thinning_of(run), "filter": by}
        header = result_header(
            run.header, method=str(method), protocol=protocol, chain=[map_header]
        )
        results.append(
            make_result(
                system,
                answers,
                queries,
                built.signatures,
                header=header,
                truth=truth,
                owner=built.topomap.owner(len(built.signatures)),
                candidates=np.full(len(queries), len(built.signatures)),
                view=view_of_map(system, built),
            )
        )
    return results


def _confidence_of(map_header: Header) -> Confidence:
    """How the map states probabilities, as it was fitted on the mapping run."""
    stored = map_header["confidence"]
    midpoint = stored["midpoint"]
    return Confidence(np.inf if midpoint is None else midpoint, stored["slope"])


def recall_run(
    system: System, built: BuiltMap, queries: Sequence[Signature], advance: Advance
) -> Recall:
    """All places of a map ranked for each signature, by likeness alone."""
    memory = system.memory()
    memory.load(built.memory)
    return recall_all(memory, queries, len(built.topomap), None, advance)


def spots_along(
    system: System, built: BuiltMap, params: FilterParams | None = None
) -> Spots | None:
    """How like each place the views along the mapping path are; None where there is no path."""
    memory = system.memory()
    memory.load(built.memory)
    return recall_spots(memory, built.topomap, built.signatures, params or FilterParams())


def recognize_run(
    reference: Run,
    query: Run | None,
    *,
    exclude_path_m: float,
    exclude_frames: int,
    query_every: int,
    radius_m: float,
    heading_deg: float | None,
    verify_top: int,
    method: Method = Method.MATCH,
    truth_file: Path | None,
    advance: Advance,
) -> Result:
    """Frame-to-frame recognition of a run in its own past, or of a query run in a reference run.

    Queries that have no candidate at all (the first metres of a run) are left out.
    """
    system = reference.system
    asked = reference if query is None else query
    check_same_signatures(
        reference.header, asked.header, ("the reference", "the query"), system.LATE
    )
    candidates = np.full(len(asked.table), len(reference.table))
    if query is None:
        candidates = past_candidates(asked.table.references, exclude_path_m, exclude_frames)
    every = np.arange(0, len(asked.table), query_every)
    rows = every[candidates[every] > 0]
    table, truth = with_truth(take(asked.table, rows), reference.table, truth_file)
    answers = recognize(
        system,
        reference.table,
        table,
        candidates[rows],
        depth=RANKS,
        verify_top=verify_top,
        radius_m=radius_m,
        rows=rows if query is None else None,
        method=method,
        advance=advance,
    )
    protocol = {
        "radius_m": radius_m,
        "heading_deg": "any" if heading_deg is None else heading_deg,
        "exclude_path_m": exclude_path_m if query is None else 0.0,
        "exclude_frames": exclude_frames if query is None else 0,
        "query_every": query_every,
        "own_past": query is None,
        "left_out": len(every) - len(rows),
        **_thinning_of(asked),
    }
    chain = [] if query is None else [reference.header]
    named = "recognize" if method is Method.MATCH else f"recognize-{method}"
    return make_result(
        system,
        answers,
        table,
        reference.table,
        header=result_header(asked.header, method=named, protocol=protocol, chain=chain),
        truth=truth,
        owner=np.arange(len(reference.table)),
        candidates=candidates[rows],
        view=no_view(),
    )


def _thinning_of(run: Run) -> dict[str, Any]:
    """How a run was thinned and by what its path was measured, for the protocol."""
    return {name: run.header[name] for name in ("step_m", "step_heading_rad", "travelled_from")}


def take(table: SignatureTable, rows: Any) -> SignatureTable:
    """The given rows of a table, in their order."""
    parts = {
        name: Ragged.of([part[int(row)] for row in rows], part.flat.dtype)
        for name, part in table.parts.items()
    }
    return SignatureTable(table.references[rows], table.records[rows], parts)
