"""Message definitions in a log compared with the types known here (faults.md C1-C6).

Only the names and types of fields are read from a log's text; nothing is compiled from it.
"""

from __future__ import annotations

from functools import cache

from fpnav.logs import limits
from fpnav.logs.container import Damaged

Fields = tuple[tuple[str, str], ...]
_MOST_FIELDS = 10_000
_DEEPEST = 32


def parse_definition(text: bytes, name: str) -> dict[str, Fields]:
    """Fields (type, name) of a type and of all it nests, by short type name.

    ``text`` is a .msg file followed by ``MSG: package/Type`` sections, of ROS 1 or 2. Comments,
    constants, default values and packages of nested types are left out.

    Raises
    ------
    Damaged
        E303: larger than the limits.
    """
    if len(text) > limits.SCHEMA_BYTES:
        raise Damaged("E303", f"definition of {len(text)} bytes")
    found: dict[str, list[tuple[str, str]]] = {}
    current = found.setdefault(_short(name), [])
    total = 0
    for line in text.decode("utf-8", "replace").splitlines():
        line = line.split("#", 1)[0].strip()
        if line.startswith("MSG:"):
            current = found.setdefault(_short(line[4:].strip()), [])
        elif line and not line.startswith("=") and not _constant(line):
            words = line.split()
            if len(words) >= 2:
                total += 1
                current.append((_field_type(words[0]), words[1].lower()))
        if total > _MOST_FIELDS:
            raise Damaged("E303", f"definition with more than {_MOST_FIELDS} fields")
    return {key: tuple(fields) for key, fields in found.items()}


def same_layout(stated: dict[str, Fields], known: dict[str, Fields], name: str) -> bool:
    """Whether a stated definition has the fields of the known one, nested types included.

    A nested type the log leaves out is taken as known (C3).
    """
    return _same(stated, known, _short(name), 0)


def _same(stated: dict[str, Fields], known: dict[str, Fields], name: str, depth: int) -> bool:
    if name not in stated or depth > _DEEPEST:
        return depth <= _DEEPEST
    if stated[name] != known.get(name):
        return False
    nested = (kind.split("[", 1)[0] for kind, _ in stated[name])
    return all(_same(stated, known, kind, depth + 1) for kind in nested if kind in known)


@cache
def known_layout(store: str, type_name: str, ros_version: int) -> dict[str, Fields]:
    """Fields of a built-in type in the same form."""
    from fpnav.logs.messages import definition

    return parse_definition(definition(type_name, store, ros_version), type_name)


def _constant(line: str) -> bool:
    """Whether a line defines a constant: TYPE NAME=VALUE, the sign before any blank value."""
    words = line.split(None, 1)
    return len(words) == 2 and "=" in words[1].split("'", 1)[0].split('"', 1)[0]


def _short(name: str) -> str:
    return name.rsplit("/", 1)[-1].strip()


def _field_type(word: str) -> str:
    """Type without its package, old names of bytes and times as the new ones."""
    base, bracket, rest = word.partition("[")
    base = _short(base)
    return (
        {"byte": "uint8", "char": "uint8", "time": "Time", "duration": "Duration"}.get(base, base)
        + bracket
        + rest
    )
