"""Signature files: one ragged layout for all systems.

Layout
------
``header`` JSON; ``references`` (N,) REFERENCE; ``records`` (N,) the system's RECORD;
``parts/NAME/flat`` the system's dtype; ``parts/NAME/offsets`` (N + 1,) int64.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.store.hdf5 import (
    create,
    opened,
    read_array,
    read_group,
    read_json,
    write_array,
    write_json,
)
from fpnav.store.header import SIGNATURES, Header, check_header
from fpnav.store.tables import REFERENCE, Ragged, SignatureTable, reference_row
from fpnav.values import Signature

Dtypes = Mapping[str, np.dtype[Any]]


def collect(
    signatures: Iterable[Signature], record: np.dtype[Any], parts: Dtypes
) -> SignatureTable:
    """Signatures of a stream as columns."""
    references: list[tuple[Any, ...]] = []
    records: list[np.void] = []
    rows: dict[str, list[NDArray[Any]]] = {name: [] for name in parts}
    for signature in signatures:
        references.append(reference_row(signature.reference))
        records.append(signature.record)
        for name, column in rows.items():
            column.append(signature.parts[name])
    return SignatureTable(
        np.array(references, dtype=REFERENCE),
        np.array(records, dtype=record),
        {name: Ragged.of(column, parts[name]) for name, column in rows.items()},
    )


def write_signatures(
    path: Path, header: Header, table: SignatureTable, *, clobber: bool = True
) -> None:
    """Publish a signature file; raises FpnavError where it cannot be written."""
    with create(path, clobber=clobber) as file:
        write_json(file, "header", header)
        put_table(file, table)


def read_signatures(path: Path, record: np.dtype[Any], parts: Dtypes) -> SignatureTable:
    """Table of a signature file, whose types must be those the system declares.

    Raises
    ------
    StoreError
        Not a signature file, or one of another layout or system.
    """
    with opened(path) as file:
        check_header(path, read_json(file, "header"), SIGNATURES)
        return get_table(file, record, parts)


def put_table(group: h5py.Group, table: SignatureTable) -> None:
    """Write a table's columns into a group."""
    write_array(group, "references", table.references)
    write_array(group, "records", table.records)
    folder = group.create_group("parts")
    for name, part in table.parts.items():
        put_ragged(folder, name, part)


def get_table(group: h5py.Group, record: np.dtype[Any], parts: Dtypes) -> SignatureTable:
    """Read a table's columns from a group; raises StoreError where they do not fit together."""
    references = read_array(group, "references", REFERENCE)
    records = read_array(group, "records", record)
    folder = read_group(group, "parts")
    columns = {name: get_ragged(folder, name, dtype) for name, dtype in parts.items()}
    lengths = {len(references), len(records), *(len(part) for part in columns.values())}
    if len(lengths) != 1:
        raise StoreError(f"{group.file.filename}: columns of unequal length {sorted(lengths)}")
    return SignatureTable(references, records, columns)


def put_ragged(group: h5py.Group, name: str, part: Ragged) -> None:
    """Write a ragged table as its flat array and offsets."""
    folder = group.create_group(name)
    write_array(folder, "flat", part.flat)
    write_array(folder, "offsets", part.offsets)


def get_ragged(group: h5py.Group, name: str, dtype: np.dtype[Any]) -> Ragged:
    """Read a ragged table; raises StoreError where the offsets do not fit the flat array."""
    folder = read_group(group, name)
    flat = read_array(folder, "flat", dtype)
    offsets = read_array(folder, "offsets", np.dtype(np.int64))
    sound = len(offsets) > 0 and offsets[0] == 0 and offsets[-1] == len(flat)
    if not sound or np.any(np.diff(offsets) < 0):
        raise StoreError(f"{group.file.filename}: {name}: offsets do not fit the rows")
    return Ragged(flat, offsets)


def texts_to_ragged(texts: Iterable[str]) -> Ragged:
    """Texts as ragged UTF-8 bytes."""
    rows = [np.frombuffer(text.encode(), dtype=np.uint8) for text in texts]
    return Ragged.of(rows, np.dtype(np.uint8))


def ragged_to_texts(part: Ragged) -> tuple[str, ...]:
    """Texts back from ragged UTF-8 bytes."""
    return tuple(part[row].tobytes().decode(errors="replace") for row in range(len(part)))
