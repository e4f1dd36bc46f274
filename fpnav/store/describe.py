"""What a stored file is and holds, as JSON-ready facts for ``fpnav info``; no system is needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.publish import file_digest
from fpnav.store.hdf5 import opened, read_array, read_group
from fpnav.store.header import MAP, RESULT, SIGNATURES, Header, check_header
from fpnav.store.maps import read_graph
from fpnav.store.results import read_header, read_result
from fpnav.store.tables import REFERENCE
from fpnav.values import Place

KINDS = {SIGNATURES: "signatures", MAP: "map", RESULT: "result"}


def describe_store(path: Path) -> dict[str, Any]:
    """Facts of a signature, map or result file.

    Raises
    ------
    StoreError
        Not a file of fpnav, of another layout version, or damaged.
    """
    header = read_header(path)
    kind = str(header.get("format"))
    if kind not in KINDS:
        raise StoreError(f"{path}: an HDF5 file that fpnav did not write (no known format in it)")
    check_header(path, header, kind)
    holds = {SIGNATURES: _signatures, MAP: _map, RESULT: _result}[kind](path)
    return {"kind": KINDS[kind], **_file(path, header), **holds}


def _file(path: Path, header: Header) -> dict[str, Any]:
    """What the header says; ``logs`` are those at the beginning of the chain."""
    return {
        "name": path.name,
        "bytes": path.stat().st_size,
        "sha256": file_digest(path),
        **{name: header[name] for name in ("fpnav", "format_version", "system", "preset")},
        "params": header["params"],
        "sources": [str(source.get("name")) for source in header["sources"]],
        "synthetic": _synthetic(header),
        **{name: header[name] for name in ("method", "protocol", "guided") if name in header},
    }


def _synthetic(header: Header) -> bool:
    """Whether any log in the chain came from the simulator."""
    return any(bool(one.get("synthetic")) for one in (header, *header["chain"]))


def _signatures(path: Path) -> dict[str, Any]:
    with opened(path) as file:
        facts = _walked(read_array(file, "references", REFERENCE))
        parts = read_group(file, "parts")
        rows = {name: len(read_array(read_group(parts, name), "flat")) for name in parts}
    return {**facts, "parts": rows}


def _map(path: Path) -> dict[str, Any]:
    topomap = read_graph(path)
    with opened(path) as file:
        references = read_array(read_group(file, "signatures"), "references", REFERENCE)
    places = topomap.places
    return {
        **_walked(references),
        "places": len(places),
        "edges": len(topomap.edges),
        "merged": sum(len(place.merged_from) > 0 for place in places),
        "labels": sorted({place.label for place in places} - {""}),
        **_returns(places, references),
    }


def _returns(places: Sequence[Place], references: NDArray[Any]) -> dict[str, Any]:
    """How often a session came back to a place it had left, and the usual time and way from one
    arrival to the next: those of a lap where it drove in laps. None where that is not known."""
    pairs = [pair for place in places for pair in pairwise(_arrivals(place.members))]
    left, back = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    same = references["session"][left] == references["session"][back]
    first, second = references[left[same]], references[back[same]]
    seconds = (second["stamp_ns"] - first["stamp_ns"]) * 1e-9
    metres = second["travelled_m"] - first["travelled_m"]
    return {"returns": len(seconds), "return_s": _median(seconds), "return_m": _median(metres)}


def _arrivals(members: Sequence[int]) -> list[int]:
    """The first signature of every visit."""
    return [row for row in members if row - 1 not in members]


def _median(values: NDArray[Any]) -> float | None:
    return round(float(np.median(values)), 3) if np.isfinite(values).any() else None


def _result(path: Path) -> dict[str, Any]:
    found = read_result(path)
    return {
        **_walked(found.queries, "queries"),
        "references": len(found.references),
        "places": len(found.view.place_ids),
        "localized": int((found.decision >= 0).sum()),
        "truth": found.truth.kind,
    }


def _walked(references: NDArray[Any], name: str = "signatures") -> Mapping[str, Any]:
    """Number of rows, of sessions, and the path they cover in metres (None where unknown)."""
    sessions = [references[references["session"] == s] for s in np.unique(references["session"])]
    lengths = [float(np.ptp(rows["travelled_m"])) for rows in sessions]
    metres = float(np.nansum(lengths)) if np.isfinite(lengths).any() else None
    return {
        name: len(references),
        "sessions": len(sessions),
        "travelled_m": None if metres is None else round(metres, 3),
        "labelled": int((references["label"] != b"").sum()),
    }
