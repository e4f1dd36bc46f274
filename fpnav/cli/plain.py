"""Plain text for stdout: aligned columns, control characters of logs shown and not obeyed."""

from __future__ import annotations

from collections.abc import Sequence

_BIDIRECTIONAL = "\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
_LONGEST = 200


def visible(text: str) -> str:
    """Text of unknown origin made harmless for a terminal, cut at 200 characters."""
    shown = "".join(
        character
        if character.isprintable() and character not in _BIDIRECTIONAL
        else character.encode("unicode_escape").decode()
        for character in text[:_LONGEST]
    )
    return shown + ("..." if len(text) > _LONGEST else "")


def table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows as lines with aligned columns, two blanks apart."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))] if rows else []
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def size(count: int) -> str:
    """Bytes in a unit a person reads."""
    value = float(count)
    for unit in ("B", "kB", "MB", "GB"):
        if value < 1000.0 or unit == "GB":
            return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"
        value /= 1000.0
    return ""
