"""Map files: the topological map, the signatures it is made of, and what the system learned.

Layout
------
``header`` JSON; ``signatures/`` as in a signature file; ``places`` (P,) PLACE; ``members/``
ragged; ``merged/`` ragged; ``edges`` (E,) EDGE; ``novelty`` (N,) and ``threshold`` (1,);
``memory/`` one dataset per array the system's memory saves.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fpnav.errors import StoreError
from fpnav.store.hdf5 import (
    create,
    opened,
    read_array,
    read_group,
    read_json,
    read_number,
    write_array,
    write_json,
)
from fpnav.store.header import MAP, Header, check_header
from fpnav.store.signatures import Dtypes, get_ragged, get_table, put_ragged, put_table
from fpnav.store.tables import EDGE, REFERENCE, Ragged, SignatureTable, label_bytes
from fpnav.systems.base import State
from fpnav.topomap.graph import Edge, TopoMap, check_map
from fpnav.values import FloatArray, Place

PLACE = np.dtype([("id", "<i8"), ("extent_m", "<f8"), ("label", "S64")])
_ROWS = np.dtype(np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class BuiltMap:
    """A map with everything needed to localize on it.

    ``novelty`` (N,) dissimilarity of each signature when it was seen, NaN for the first;
    ``threshold`` what it was compared with; ``memory`` what the system learned.
    """

    topomap: TopoMap
    signatures: SignatureTable
    novelty: FloatArray
    threshold: float
    memory: State


def write_map(path: Path, header: Header, built: BuiltMap, *, clobber: bool = True) -> None:
    """Publish a map file; raises StoreError where the map breaks an invariant."""
    check_map(built.topomap, len(built.signatures))
    with create(path, clobber=clobber) as file:
        write_json(file, "header", header)
        put_table(file.create_group("signatures"), built.signatures)
        _put_graph(file, built.topomap)
        write_array(file, "novelty", built.novelty)
        write_array(file, "threshold", np.array([built.threshold]))
        memory = file.create_group("memory")
        for name, values in built.memory.items():
            write_array(memory, name, values)


def read_map(path: Path, record: np.dtype[Any], parts: Dtypes) -> BuiltMap:
    """Map of a file, checked.

    Raises
    ------
    StoreError
        Not a map file, of another layout or system, or breaking an invariant.
    """
    with opened(path) as file:
        check_header(path, read_json(file, "header"), MAP)
        signatures = get_table(read_group(file, "signatures"), record, parts)
        memory = read_group(file, "memory")
        novelty = read_array(file, "novelty", np.dtype(np.float64))
        if len(novelty) != len(signatures):
            raise StoreError(f"{path}: {len(novelty)} novelties of {len(signatures)} signatures")
        return BuiltMap(
            topomap=_get_graph(file, path, len(signatures)),
            signatures=signatures,
            novelty=novelty,
            threshold=read_number(file, "threshold"),
            memory={name: read_array(memory, name, ndim=None) for name in sorted(memory)},
        )


def read_graph(path: Path) -> TopoMap:
    """The topological map alone, whatever system made it."""
    with opened(path) as file:
        check_header(path, read_json(file, "header"), MAP)
        signatures = read_array(read_group(file, "signatures"), "references", REFERENCE)
        return _get_graph(file, path, len(signatures))


def _put_graph(file: h5py.Group, topomap: TopoMap) -> None:
    places = topomap.places
    rows = [(place.id, place.extent_m, label_bytes(place.label)) for place in places]
    write_array(file, "places", np.array(rows, dtype=PLACE))
    members = [np.array(place.members, dtype=np.int64) for place in places]
    merged = [np.array(place.merged_from, dtype=np.int64) for place in places]
    put_ragged(file, "members", Ragged.of(members, _ROWS))
    put_ragged(file, "merged", Ragged.of(merged, _ROWS))
    write_array(file, "edges", edge_table(topomap))


def _get_graph(file: h5py.Group, path: Path, signatures: int) -> TopoMap:
    table = read_array(file, "places", PLACE)
    members, merged = get_ragged(file, "members", _ROWS), get_ragged(file, "merged", _ROWS)
    if not len(table) == len(members) == len(merged):
        raise StoreError(f"{path}: {len(table)} places, {len(members)} lists of members")
    places = [
        Place(
            id=int(row["id"]),
            members=tuple(members[i].tolist()),
            extent_m=float(row["extent_m"]),
            label=bytes(row["label"]).decode(errors="replace"),
            merged_from=tuple(merged[i].tolist()),
        )
        for i, row in enumerate(table)
    ]
    edges = [Edge(*row) for row in read_array(file, "edges", EDGE).tolist()]
    try:
        topomap = TopoMap.of(places, edges)
        check_map(topomap, signatures)
    except StoreError as error:
        raise StoreError(f"{path}: {error}") from None
    return topomap


def edge_table(topomap: TopoMap) -> np.ndarray[Any, np.dtype[np.void]]:
    """Edges of a map as rows of dtype EDGE."""
    return np.array(
        [
            (e.source, e.target, e.length_m, e.bearing_out_rad, e.bearing_in_rad, e.count)
            for e in topomap.edges
        ],
        dtype=EDGE,
    )
