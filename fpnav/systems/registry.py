"""The systems there are: name -> where its class lives. A new system is one line here."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, cast

from fpnav.errors import UsageError

if TYPE_CHECKING:  # the contract imports numpy, which help and completion do not need
    from fpnav.systems.base import System

SYSTEMS: dict[str, str] = {
    "fingerprint": "fpnav.systems.fingerprint:Fingerprint",
    "placecell": "fpnav.systems.placecell:Placecell",
    "gateway": "fpnav.systems.gateway:Gateway",
    "tiny": "fpnav.systems.tiny:TinyImage",
    "colourhist": "fpnav.systems.colourhist:ColourHistogram",
    "hog": "fpnav.systems.hog:Hog",
    "ridf": "fpnav.systems.ridf:Ridf",
    "vlad": "fpnav.systems.vlad:Vlad",
    "seqslam": "fpnav.systems.seqslam:SeqSlam",
    "onnx": "fpnav.systems.onnx:Onnx",
    "fourier": "fpnav.systems.fourier:FourierSignature",
    "polar": "fpnav.systems.polar:Polar",
    "cornerpairs": "fpnav.systems.cornerpairs:CornerPairs",
    "correlative": "fpnav.systems.correlative:Correlative",
}


def system_class(name: str) -> type[System]:
    """Class of the named system, or of several joined as ``a+b``; imported on first use.

    Raises
    ------
    UsageError
        No system has that name.
    """
    if "+" in name:
        from fpnav.systems.joined import joined_class

        return joined_class([system_class(part) for part in name.split("+")])
    if name not in SYSTEMS:
        raise UsageError(f"no system {name!r}; known: {', '.join(SYSTEMS)}")
    module, _, attribute = SYSTEMS[name].partition(":")
    return cast("type[System]", getattr(importlib.import_module(module), attribute))
