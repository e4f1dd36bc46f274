"""True poses in TUM files: ``t tx ty tz qx qy qz qw`` a line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal, InvalidOperation
from pathlib import Path

from fpnav.errors import TruthError
from fpnav.logs.ledger import Ledger
from fpnav.logs.text import lines
from fpnav.values import Pose2


def read_poses(path: Path, ledger: Ledger) -> Iterator[tuple[int, Pose2]]:
    """(stamp in ns, pose) of every row, in the order of the file; rows with NaN are counted.

    Raises
    ------
    TruthError
        Names the line: not 8 columns (E610), not numbers, decimal commas.
    """
    for number, text in lines(path):
        text = text.strip()
        if not text or text.startswith("#"):
            continue
        stamp_ns, values = _row(path, number, text)
        length = math.sqrt(sum(value * value for value in values[3:]))
        if not all(map(math.isfinite, values)) or length < 1e-6:
            ledger.topic("/truth").skipped["E504"] += 1
            continue
        x, y, z, w = (value / length for value in values[3:])
        heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        yield stamp_ns, Pose2(values[0], values[1], heading)


def _row(path: Path, number: int, text: str) -> tuple[int, list[float]]:
    words = text.split()
    if len(words) != 8:
        raise TruthError(
            f"{path} line {number}: E610 {len(words)} columns, expected t tx ty tz qx qy qz qw"
        )
    try:
        stamp_ns = int(Decimal(words[0]).scaleb(9).to_integral_value())
        return stamp_ns, [float(word) for word in words[1:]]
    except (InvalidOperation, ValueError, OverflowError):
        hint = "; decimal commas are not read" if "," in text else ""
        raise TruthError(f"{path} line {number}: {text!r} is not 8 numbers{hint}") from None
