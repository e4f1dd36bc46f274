"""From answers to a result: everything a report needs, gathered in one value."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import TruthError
from fpnav.evaluation.truth import pairs_to_rows, poses_at, read_pairs, read_tum
from fpnav.localization.locate import Answers
from fpnav.store.header import RESULT, Header, make_header
from fpnav.store.maps import BuiltMap, edge_table
from fpnav.store.tables import EDGE, Accepted, MapView, Result, SignatureTable
from fpnav.systems.base import System
from fpnav.values import FloatArray, Place, Signature


def make_result(
    system: System,
    answers: Answers,
    queries: SignatureTable,
    references: SignatureTable,
    *,
    header: Header,
    truth: Accepted,
    owner: NDArray[np.int64],
    candidates: NDArray[np.int64],
    view: MapView,
) -> Result:
    """Result of a run; the readable signature of each query is kept for the report."""
    return Result(
        header={**header, "summary": system.SUMMARY},
        queries=queries.references,
        references=references.references,
        owner=owner,
        candidates=candidates,
        truth=truth,
        view=view,
        query_strips=texts(system, queries),
        **{name: getattr(answers, name) for name in Answers.__slots__},
    )


def result_header(
    query_header: Header, *, method: str, protocol: Mapping[str, Any], chain: Sequence[Header]
) -> dict[str, Any]:
    """Header of a result made from the queries' signatures and what stands in the chain."""
    return make_header(
        RESULT,
        system=query_header["system"],
        preset=query_header["preset"],
        params=query_header["params"],
        sources=query_header["sources"],
        chain=[*chain, query_header],
        method=method,
        protocol=dict(protocol),
        ledger=query_header["ledger"],
        synthetic=query_header["synthetic"],
        worlds=query_header["worlds"],
    )


def with_actions(result: Result, actions: NDArray[Any], task: Mapping[str, Any]) -> Result:
    """The result with what a policy decided, and its task in the protocol."""
    protocol = {**result.header["protocol"], "task": dict(task)}
    header = {**result.header, "method": "navigate", "protocol": protocol}
    return replace(result, header=header, actions=actions)


def view_of_map(system: System, built: BuiltMap) -> MapView:
    """What a report draws of a map."""
    references = built.signatures.references
    places = built.topomap.places
    return MapView(
        place_ids=built.topomap.ids,
        place_pose=np.array([_place_pose(references, place) for place in places]).reshape(-1, 3),
        extent_m=np.array([place.extent_m for place in places], dtype=np.float64),
        edges=edge_table(built.topomap),
        novelty=built.novelty,
        threshold=built.threshold,
        strips=texts(
            system, [built.signatures[place.members[len(place.members) // 2]] for place in places]
        ),
    )


def no_view() -> MapView:
    """The view of a result made without a map."""
    return MapView(
        place_ids=np.zeros(0, dtype=np.int64),
        place_pose=np.zeros((0, 3)),
        extent_m=np.zeros(0),
        edges=np.zeros(0, dtype=EDGE),
        novelty=np.zeros(0),
        threshold=math.nan,
    )


def texts(system: System, signatures: Sequence[Signature]) -> tuple[str, ...]:
    """Readable form of each signature, empty where the system has none."""
    return tuple(system.picture(signature).text for signature in signatures)


def _place_pose(references: NDArray[Any], place: Place) -> FloatArray:
    """Truth of the middle member where it is known, else its odometry."""
    middle = references[place.members[len(place.members) // 2]]
    truth: FloatArray = middle["truth"]
    return truth if np.isfinite(truth).all() else np.asarray(middle["odometry"], dtype=np.float64)


def with_truth(
    queries: SignatureTable, references: SignatureTable, truth_file: Path | None
) -> tuple[SignatureTable, Accepted]:
    """Queries with their truth, and where it is from.

    A TUM file replaces the queries' own truth; a JSON file names accepted reference rows.

    Raises
    ------
    TruthError
        The file cannot be read or does not fit the run.
    """
    if truth_file is None:
        known = _has_truth(queries) and _has_truth(references)
        return queries, Accepted("poses" if known else "none", "truth topic" if known else "none")
    if truth_file.suffix == ".json":
        pairs = pairs_to_rows(
            truth_file,
            read_pairs(truth_file),
            queries.references["index"],
            references.references["index"],
        )
        return queries, Accepted("pairs", truth_file.name, pairs)
    if truth_file.suffix not in (".tum", ".txt"):
        raise TruthError(f"{truth_file}: expected a .tum or .json file")
    rows = queries.references.copy()
    rows["truth"] = poses_at(truth_file, read_tum(truth_file), rows["stamp_ns"])
    return SignatureTable(rows, queries.records, queries.parts), Accepted("poses", truth_file.name)


def _has_truth(table: SignatureTable) -> bool:
    return bool(np.isfinite(table.references["truth"]).all(axis=1).any())
