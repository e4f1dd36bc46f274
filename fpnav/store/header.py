"""The header every file carries, and the chain of headers back to the log."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from fpnav import __version__
from fpnav.errors import StoreError
from fpnav.publish import file_digest

FORMAT_VERSION = 1
"""Version of the layout of all three kinds of file.

History
-------
1 : first layout.
"""

SIGNATURES, MAP, RESULT = "fpnav/signatures", "fpnav/map", "fpnav/result"

_FIELDS: dict[str, type] = {
    "system": str, "preset": str, "params": dict, "sources": list, "chain": list
}  # fmt: skip

Header = Mapping[str, Any]


def make_header(
    kind: str,
    *,
    system: str,
    preset: str,
    params: Mapping[str, Any],
    sources: Sequence[Mapping[str, Any]],
    chain: Sequence[Header] = (),
    **facts: Any,
) -> dict[str, Any]:
    """Header of a new file. ``sources`` name, digest and size what it was made from."""
    return {
        "format": kind,
        "format_version": FORMAT_VERSION,
        "fpnav": __version__,
        "system": system,
        "preset": preset,
        "params": dict(params),
        "sources": [dict(source) for source in sources],
        "chain": [dict(header) for header in chain],
        **facts,
    }


def source_of(path: Path) -> dict[str, Any]:
    """How a file is named in the header of what is made from it: base name, digest, size."""
    return {"name": path.name, "sha256": file_digest(path), "bytes": path.stat().st_size}


def check_header(path: Path, header: Header, kind: str) -> None:
    """Refuse a file of another kind or layout version, or with a header that lacks its fields.

    Raises
    ------
    StoreError
        Says what the file is and what was expected.
    """
    found = header.get("format")
    if found != kind:
        raise StoreError(f"{path}: is {found!r}, expected {kind!r}")
    version = header.get("format_version")
    if version != FORMAT_VERSION:
        raise StoreError(
            f"{path}: format version {version}, this fpnav {__version__} reads {FORMAT_VERSION}; "
            "make the file again"
        )
    for name, kind_of in _FIELDS.items():
        if not isinstance(header.get(name), kind_of):
            raise StoreError(
                f"{path}: header field {name!r} is missing or not a {kind_of.__name__}"
            )


def flat(params: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Parameters by name; those of a block within a block as ``inner.name``."""
    out: dict[str, Any] = {}
    for key, value in params.items():
        inner = isinstance(value, Mapping)
        out |= flat(value, f"{before}{key}.") if inner else {f"{before}{key}": value}
    return out


def check_same_signatures(
    first: Header, second: Header, names: tuple[str, str], late: Collection[str]
) -> None:
    """Refuse to join two files whose signatures were not made alike; ``late`` may differ.

    Raises
    ------
    StoreError
        System or parameters differ; both sides are named.
    """
    if first["system"] != second["system"]:
        raise StoreError(
            f"{names[0]} was made with system {first['system']!r}, "
            f"{names[1]} with {second['system']!r}; make both with one"
        )
    ours, theirs = flat(first["params"]), flat(second["params"])
    for key in sorted({*ours, *theirs} - set(late)):
        for name, params in zip(names, (ours, theirs), strict=True):
            if key not in params:
                raise StoreError(
                    f"{name} was made by a version of fpnav that had no {first['system']}.{key}; "
                    "make both with the same version"
                )
        if ours[key] != theirs[key]:
            raise StoreError(
                f"{names[0]} has {first['system']}.{key}={ours[key]!r}, "
                f"{names[1]} has {theirs[key]!r}; make both with the same parameters"
            )
