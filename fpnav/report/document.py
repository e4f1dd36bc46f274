"""report.json: every figure of every result, for programs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from fpnav import __version__
from fpnav.report.entry import Entry
from fpnav.values import Metric


def document(entries: Sequence[Entry]) -> dict[str, Any]:
    """The report as plain values (commands.md): NaN becomes null."""
    return {"fpnav": __version__, "results": [_result(entry) for entry in entries]}


def as_json(value: Any) -> bytes:
    """Deterministic JSON: sorted keys, two blanks, a newline at the end.

    Raises
    ------
    ValueError
        A figure is not finite; absent figures must be left out, not written as NaN.
    """
    text = json.dumps(value, indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False)
    return (text + "\n").encode()


def _result(entry: Entry) -> dict[str, Any]:
    return {
        "name": entry.name,
        "system": entry.header.get("system", ""),
        "preset": entry.header.get("preset", ""),
        "method": entry.method,
        "protocol": plain(entry.protocol),
        "source": plain({str(s.get("name", "")): s for s in entry.header.get("sources", ())}),
        "metrics": {name: metric_values(metric) for name, metric in entry.metrics.items()},
        "absent": dict(entry.absent),
    }


def metric_values(metric: Metric) -> dict[str, Any]:
    """A metric as the report writes it; an interval that does not exist is null."""
    return {
        "value": metric.value,
        "n": metric.n,
        "of": metric.of,
        "unit": metric.unit,
        "low": _finite(metric.low),
        "high": _finite(metric.high),
    }


def plain(value: Any) -> Any:
    """The same value in JSON's own types; not finite numbers become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return _finite(value)
    return value


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
