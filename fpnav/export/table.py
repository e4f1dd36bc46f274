"""The formats there are. A new one is a module with ``write(subject) -> bytes`` and one line."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Protocol, cast

from fpnav.export.subject import Subject


@dataclass(frozen=True, slots=True)
class Format:
    """Where a format's writer lives, whether it is text, and what it is for."""

    module: str
    text: bool
    purpose: str


FORMATS: dict[str, Format] = {
    "graphml": Format("fpnav.export.graphml", True, "networkx, Gephi, yEd"),
    "geojson": Format("fpnav.export.geojson", True, "the Nav2 route server"),
    "json": Format("fpnav.export.nodelink", True, "node-link JSON: networkx, d3"),
    "tum": Format("fpnav.export.tum", True, "trajectory: evo"),
    "g2o": Format("fpnav.export.g2o", True, "pose graph: optimisers"),
    "csv": Format("fpnav.export.rows", True, "places of a map, queries of a result"),
    "mcap": Format("fpnav.export.foxglove_scene", False, "Foxglove, Lichtblick, Rerun"),
}


class Writer(Protocol):
    """What a format's module offers."""

    def write(self, subject: Subject) -> bytes:
        """The whole file."""
        ...


def export(subject: Subject, name: str) -> bytes:
    """A subject in the named format.

    Raises
    ------
    StoreError
        It lacks what the format needs.
    """
    return cast("Writer", importlib.import_module(FORMATS[name].module)).write(subject)
