"""Facts of a stored file as a screen of text, for ``fpnav info``."""

from __future__ import annotations

from typing import Any

from fpnav.cli.plain import size, visible
from fpnav.cli.session import plural


def stored_lines(facts: dict[str, Any]) -> list[str]:
    """What the file is, what it was made from, what it holds, and its parameters."""
    made = f"{facts['system']}, preset {facts['preset']}"
    lines = [
        f"{visible(facts['name'])}: {facts['kind']}, {size(facts['bytes'])}, {visible(made)}",
        f"made by fpnav {visible(facts['fpnav'])} from "
        f"{visible(', '.join(facts['sources']))}{', simulated' if facts['synthetic'] else ''}",
        "",
        *_HOLDS[facts["kind"]](facts),
        "",
        "parameters",
    ]
    return lines + [f"  {visible(k)} = {visible(str(v))}" for k, v in facts["params"].items()]


def _signatures(facts: dict[str, Any]) -> list[str]:
    rows = max(1, facts["signatures"])
    parts = [f"  {visible(name)}: {n / rows:.1f} each" for name, n in facts["parts"].items()]
    return [_walked(facts, "signatures"), *parts]


def _map(facts: dict[str, Any]) -> list[str]:
    lines = [
        f"{plural(facts['places'], 'place')}, {plural(facts['edges'], 'edge')}, "
        f"{facts['merged']} merged by closing loops",
        f"from {_walked(facts, 'signatures')}",
    ]
    if facts["returns"]:
        metres = "" if facts["return_m"] is None else f" and {facts['return_m']:.1f} m"
        lines.append(
            f"back at a place after {facts['return_s']:.1f} s{metres} "
            f"(median of {plural(facts['returns'], 'return')})"
        )
    if facts["guided"]:
        lines.append("places by label")
    return lines


def _result(facts: dict[str, Any]) -> list[str]:
    truth = {"poses": "poses", "pairs": "accepted pairs", "none": "none: nothing can be judged"}
    against = (
        f"a map of {plural(facts['places'], 'place')}"
        if facts["places"]
        else plural(facts["references"], "signature")
    )
    return [
        f"{_walked(facts, 'queries')}, {facts['localized']} localized",
        f"by {visible(facts['method'])} against {against}",
        f"truth: {truth[facts['truth']]}",
    ]


_HOLDS = {"signatures": _signatures, "map": _map, "result": _result}


def _walked(facts: dict[str, Any], noun: str) -> str:
    """``500 signatures, 75.1 m`` and the number of sessions where there are several."""
    words = [f"{facts[noun]} {noun}"]
    if facts["travelled_m"] is not None:
        words.append(f"{facts['travelled_m']:.1f} m")
    if facts["sessions"] > 1:
        words.append(plural(facts["sessions"], "session"))
    return ", ".join(words)
