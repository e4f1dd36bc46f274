"""Parameters: TOML file and ``--set`` flags -> one frozen block per stage; flags beat the file."""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec

from fpnav.errors import UsageError


class Params(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of every parameter block: frozen, unknown keys refused."""


Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
Pixels = Annotated[int, msgspec.Meta(ge=1, le=8192)]

Block = TypeVar("Block", bound=Params)
Tables = Mapping[str, Mapping[str, Any]]

NO_TABLES: Tables = {}


def read_tables(file: Path | None, settings: Sequence[str], known: Iterable[str]) -> Tables:
    """Parameter tables by block name, from a TOML file and ``block.key=value`` settings.

    Raises
    ------
    UsageError
        The file is not TOML, a setting is not of that form, a block is not among ``known``.
    """
    tables: dict[str, dict[str, Any]] = {}
    if file is not None:
        for name, table in _read_toml(file).items():
            if not isinstance(table, dict):
                raise UsageError(f"{file}: {name!r} stands outside a table; expected [block] first")
            tables[name] = dict(table)
    for setting in settings:
        block, key, value = _parse_setting(setting)
        tables.setdefault(block, {})[key] = value
    names = list(known)
    for block in tables:
        if block not in names:
            raise UsageError(f"no parameter block {block!r}{_nearest(block, names)}")
    return tables


def resolve(block: str, default: Block, tables: Tables) -> Block:
    """The block with the tables' values in place of the default's.

    A field that is a block itself takes the table of its own name too.

    Raises
    ------
    UsageError
        An unknown key, a value of the wrong type or out of range.
    """
    overrides = tables.get(block, {})
    fields = {field.name for field in msgspec.structs.fields(default)}
    for key, value in overrides.items():
        if key not in fields:
            raise UsageError(f"no parameter {block}.{key}{_nearest(key, fields)}")
        if isinstance(value, float) and not math.isfinite(value):
            raise UsageError(f"parameter {block}.{key}: {value} is not a finite number")
    values = {**msgspec.structs.asdict(default), **overrides}
    for name, inner in msgspec.structs.asdict(default).items():
        if isinstance(inner, Params):
            table = {**overrides.get(name, {}), **tables.get(name, {})}
            values[name] = resolve(name, inner, {name: table})
    try:
        return msgspec.convert(values, type(default), strict=True)
    except msgspec.ValidationError as error:
        raise UsageError(f"parameter block {block!r}: {error}") from error


def as_dict(block: Params) -> dict[str, Any]:
    """The block as JSON-ready values, for headers."""
    plain: dict[str, Any] = msgspec.to_builtins(block)
    return plain


def choose_preset(owner: str, presets: Mapping[str, Block], name: str) -> Block:
    """The named preset of a system; raises UsageError listing those there are."""
    if name not in presets:
        raise UsageError(f"{owner} has no preset {name!r}; it has {', '.join(presets)}")
    return presets[name]


def _read_toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UsageError(f"{file}: no such parameter file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise UsageError(f"{file}: not a TOML parameter file: {error}") from error


def _parse_setting(setting: str) -> tuple[str, str, Any]:
    path, equals, text = setting.partition("=")
    block, dot, key = path.strip().partition(".")
    if not (equals and dot and block and key):
        raise UsageError(f"--set {setting!r}: expected block.key=value, as fingerprint.theta=auto")
    return block, key, _parse_value(text.strip())


def _parse_value(text: str) -> Any:
    """A TOML value where the text is one, else the bare word itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        return text


def _nearest(word: str, words: Iterable[str]) -> str:
    names = sorted(words)
    near = difflib.get_close_matches(word, names, n=1)
    return f"; did you mean {near[0]!r}?" if near else f"; known: {', '.join(names)}"
