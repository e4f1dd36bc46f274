"""What a check finds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["ok", "note", "warn", "fail", "loss"]
"""ok: holds. note: worth knowing. warn: works, worse. fail: a stage cannot run. loss: more data
is lost than allowed."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Outcome of one named check: its code where something is found, and what to do about it."""

    check: str
    level: Level
    message: str
    code: str = ""
    fix: str = ""


def ok(check: str, message: str) -> Finding:
    """The assumption holds."""
    return Finding(check, "ok", message)


def note(check: str, code: str, message: str, fix: str = "") -> Finding:
    """Worth knowing, harms nothing."""
    return Finding(check, "note", message, code, fix)


def warn(check: str, code: str, message: str, fix: str) -> Finding:
    """Stages run, but worse than they could."""
    return Finding(check, "warn", message, code, fix)


def fail(check: str, code: str, message: str, fix: str) -> Finding:
    """A stage cannot run."""
    return Finding(check, "fail", message, code, fix)


def loss(check: str, code: str, message: str, fix: str) -> Finding:
    """More data is lost than allowed."""
    return Finding(check, "loss", message, code, fix)
