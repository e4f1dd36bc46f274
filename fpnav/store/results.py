"""Result files of ``localize`` and ``recognize``: all a report reads.

Layout
------
``header`` JSON; one dataset per array of tables.Result under its own name; ``truth/`` with
``facts`` JSON and ``pairs/`` ragged; ``view/`` the map as drawn; ``actions`` (A,) ACTION where a
policy decided.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fpnav.errors import StoreError
from fpnav.store.hdf5 import (
    create,
    has,
    opened,
    read_array,
    read_group,
    read_json,
    read_number,
    write_array,
    write_json,
)
from fpnav.store.header import RESULT, Header, check_header
from fpnav.store.signatures import get_ragged, put_ragged, ragged_to_texts, texts_to_ragged
from fpnav.store.tables import ACTION, EDGE, REFERENCE, Accepted, MapView, Result

_INT, _FLOAT = np.dtype(np.int64), np.dtype(np.float64)

_ARRAYS: dict[str, tuple[np.dtype[Any], str]] = {
    "queries": (REFERENCE, "Q"),
    "references": (REFERENCE, "R"),
    "owner": (_INT, "R"),
    "candidates": (_INT, "Q"),
    "places": (_INT, "Qk"),
    "members": (_INT, "Qk"),
    "scores": (_FLOAT, "Qk"),
    "headings_rad": (_FLOAT, "Qk"),
    "decision": (_INT, "Q"),
    "stated": (_FLOAT, "Q"),
    "entropy": (_FLOAT, "Q"),
    "belief": (np.dtype(np.float32), "QB"),
    "relative": (_FLOAT, "Q3"),
    "covariance": (_FLOAT, "Q33"),
}
"""Type and axes of each array: Q queries, R references, k ranks, B places or none."""

_VIEW: dict[str, tuple[np.dtype[Any], str]] = {
    "place_ids": (_INT, "P"),
    "place_pose": (_FLOAT, "P3"),
    "extent_m": (_FLOAT, "P"),
    "edges": (EDGE, "E"),
    "novelty": (_FLOAT, "N"),
}


def write_result(path: Path, result: Result, *, clobber: bool = True) -> None:
    """Publish a result file; raises FpnavError where it cannot be written."""
    with create(path, clobber=clobber) as file:
        write_json(file, "header", result.header)
        for name in _ARRAYS:
            write_array(file, name, getattr(result, name))
        put_ragged(file, "query_strips", texts_to_ragged(result.query_strips))
        if len(result.actions):
            write_array(file, "actions", result.actions)
        _put_truth(file.create_group("truth"), result.truth)
        _put_view(file.create_group("view"), result.view)


def read_result(path: Path) -> Result:
    """Result of a file.

    Raises
    ------
    StoreError
        Not a result file, of another layout, or damaged.
    """
    with opened(path) as file:
        header = read_json(file, "header")
        check_header(path, header, RESULT)
        return Result(
            header=header,
            **_get_arrays(file, _ARRAYS),
            query_strips=_get_texts(file, "query_strips"),
            actions=_get_actions(file),
            truth=_get_truth(read_group(file, "truth")),
            view=_get_view(read_group(file, "view")),
        )


def read_header(path: Path) -> Header:
    """Header of any fpnav file; raises StoreError where there is none."""
    with opened(path) as file:
        return read_json(file, "header")


def _get_arrays(
    group: h5py.Group, layout: Mapping[str, tuple[np.dtype[Any], str]]
) -> dict[str, NDArray[Any]]:
    """Arrays of a layout; raises StoreError where an axis is not as long as its namesakes."""
    arrays: dict[str, NDArray[Any]] = {}
    known = {"3": 3}
    for name, (dtype, axes) in layout.items():
        arrays[name] = read_array(group, name, dtype, ndim=len(axes))
        for axis, length in zip(axes, arrays[name].shape, strict=True):
            if known.setdefault(axis, length) != length:
                raise StoreError(
                    f"{group.file.filename}: {name}: shape {arrays[name].shape}, "
                    f"expected {known[axis]} along {axis}"
                )
    return arrays


def _get_actions(group: h5py.Group) -> NDArray[Any]:
    if not has(group, "actions"):
        return np.zeros(0, ACTION)
    return read_array(group, "actions", ACTION, ndim=1)


def _get_texts(group: h5py.Group, name: str) -> tuple[str, ...]:
    return ragged_to_texts(get_ragged(group, name, np.dtype(np.uint8)))


def _put_truth(group: h5py.Group, truth: Accepted) -> None:
    write_json(group, "facts", {"kind": truth.kind, "source": truth.source})
    if truth.pairs is not None:
        put_ragged(group, "pairs", truth.pairs)


def _get_truth(group: h5py.Group) -> Accepted:
    facts = read_json(group, "facts")
    kind, source = facts.get("kind"), facts.get("source")
    pairs = get_ragged(group, "pairs", _INT) if has(group, "pairs") else None
    if kind not in ("poses", "pairs", "none") or (kind == "pairs") != (pairs is not None):
        raise StoreError(f"{group.file.filename}: truth of unknown kind {kind!r}")
    return Accepted(kind=kind, source=str(source), pairs=pairs)


def _put_view(group: h5py.Group, view: MapView) -> None:
    for name in _VIEW:
        write_array(group, name, getattr(view, name))
    write_array(group, "threshold", np.array([view.threshold]))
    put_ragged(group, "strips", texts_to_ragged(view.strips))


def _get_view(group: h5py.Group) -> MapView:
    return MapView(
        **_get_arrays(group, _VIEW),
        threshold=read_number(group, "threshold"),
        strips=_get_texts(group, "strips"),
    )
