"""What became of every message: used, skipped with a code, or unread after damage (faults.md R3).

For every topic ``used + sum(skipped) + unread == in_file``. The budget (R4) decides whether the
loss is small enough to go on.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LossError

Integrity = Literal["verified", "unverified", "damaged"]

BY_OPTION = frozenset({"thinned", "unjoined", "unused", "duplicate"})
"""Skips the user asked for or that a join makes: no loss of data."""


@dataclass(frozen=True, slots=True)
class Budget:
    """How much may be lost: share per used topic, and whether a damaged file may be used."""

    max_loss: float = 0.01
    strict: bool = False
    allow_truncated: bool = False

    @property
    def share(self) -> float:
        """Largest share of a used topic that may be lost."""
        return 0.0 if self.strict else self.max_loss


@dataclass(slots=True)
class TopicCount:
    """One topic's messages; ``repaired`` and ``skipped`` count by code."""

    type_name: str = ""
    used: int = 0
    unread: int = 0
    needed: bool = True
    skipped: Counter[str] = field(default_factory=Counter)
    repaired: Counter[str] = field(default_factory=Counter)
    first_ns: int | None = None
    last_ns: int | None = None

    def drop(self, code: str, count: int = 1) -> None:
        """Move messages from used to skipped."""
        if count:
            self.used -= count
            self.skipped[code] += count

    def see(self, log_ns: NDArray[np.uint64]) -> None:
        """Widen the span of log times by those of some messages."""
        first, last = int(log_ns.min()), int(log_ns.max())
        self.first_ns = first if self.first_ns is None else min(self.first_ns, first)
        self.last_ns = last if self.last_ns is None else max(self.last_ns, last)

    def unuse(self) -> None:
        """Nobody needs the topic: what could be read is skipped, what could not is no loss."""
        self.skipped["unused"] += self.used
        self.used = 0
        self.needed = False

    @property
    def in_file(self) -> int:
        """Messages of the topic the file is known to hold."""
        return self.used + sum(self.skipped.values()) + self.unread

    @property
    def lost(self) -> int:
        """Messages lost to faults, not to options."""
        faults = (n for code, n in self.skipped.items() if code not in BY_OPTION)
        return self.unread + sum(faults)

    @property
    def fraction(self) -> float:
        """Share of the topic's messages that is lost."""
        return self.lost / self.in_file if self.in_file else 0.0


@dataclass(slots=True)
class InputFile:
    """One file that was read.

    ``truncated_at`` : byte where reading had to stop. ``damage`` : a loss that cannot be counted,
    in words; a loss that can be counted stands with its topics.
    """

    name: str
    size: int
    sha256: str = ""
    integrity: Integrity = "unverified"
    truncated_at: int | None = None
    damage: str = ""


@dataclass(slots=True)
class Ledger:
    """Counts of one reading of one or more files."""

    inputs: list[InputFile] = field(default_factory=list)
    topics: dict[str, TopicCount] = field(default_factory=dict)
    notes: Counter[str] = field(default_factory=Counter)
    remarks: dict[str, str] = field(default_factory=dict)

    def topic(self, name: str) -> TopicCount:
        """The counts of a topic, made where they are new."""
        return self.topics.setdefault(name, TopicCount())

    def add(self, name: str, count: TopicCount) -> None:
        """Take the counts of one file's topic, on top of those of files before."""
        if name not in self.topics:
            self.topics[name] = count
            return
        present = self.topics[name]
        present.used += count.used
        present.unread += count.unread
        present.skipped.update(count.skipped)
        present.needed = present.needed or count.needed

    def note(self, code: str, remark: str = "", count: int = 1) -> None:
        """Count something worth knowing that lost nothing; the first remark of a code is kept."""
        self.notes[code] += count
        if remark:
            self.remarks.setdefault(code, remark)

    def worst(self) -> tuple[str, float]:
        """Topic with the largest share lost, and that share."""
        used = ((name, count) for name, count in self.topics.items() if count.needed)
        shares = ((count.fraction, name) for name, count in used)
        fraction, name = max(shares, default=(0.0, ""))
        return (name, fraction) if fraction else ("", 0.0)

    def settle(self, budget: Budget) -> None:
        """Refuse to go on where more was lost than the budget allows.

        Raises
        ------
        LossError
            A file is damaged and ``allow_truncated`` is off, or a topic lost too large a share.
        """
        for source in self.inputs:
            if source.damage and not budget.allow_truncated:
                raise LossError(
                    f"{source.name}: {source.damage}; rerun with --allow-truncated to use what "
                    "is whole"
                )
        name, fraction = self.worst()
        if fraction > budget.share:
            count = self.topics[name]
            codes = ", ".join(f"{n} {code}" for code, n in sorted(count.skipped.items()))
            raise LossError(
                f"{name}: {count.lost} of {count.in_file} messages lost ({fraction:.2%}; "
                f"{codes or 'unread'}), allowed {budget.share:.2%}; see --max-loss"
            )

    def as_dict(self) -> dict[str, Any]:
        """The ledger as JSON-ready values (faults.md 1.5)."""
        name, fraction = self.worst()
        return {
            "schema": "fpnav.ledger/1",
            "inputs": [_input(source) for source in self.inputs],
            "topics": [_topic(name, count) for name, count in sorted(self.topics.items())],
            "loss": {"worst_topic": name, "fraction": fraction},
            "notes": dict(sorted(self.notes.items())),
            "remarks": dict(sorted(self.remarks.items())),
        }


def _input(source: InputFile) -> dict[str, Any]:
    return {
        "name": source.name,
        "sha256": source.sha256,
        "bytes": source.size,
        "integrity": source.integrity,
        "truncated_at": source.truncated_at,
        "damage": source.damage,
    }


def _topic(name: str, count: TopicCount) -> dict[str, Any]:
    return {
        "topic": name,
        "type": count.type_name,
        "in_file": count.in_file,
        "used": count.used,
        "skipped": dict(sorted(count.skipped.items())),
        "unread": count.unread,
        "repaired": dict(sorted(count.repaired.items())),
        "first_ns": count.first_ns,
        "last_ns": count.last_ns,
    }
