"""``fpnav systems``: what can recognise places, what it needs, how it can be set."""

from __future__ import annotations

import json
from typing import Any

import click

from fpnav.cli import options


@click.command("systems")
@options.as_json
def command(as_json: bool) -> None:
    """List the systems with their needs, presets and parameters.

    \b
    Example: fpnav systems --json | jq '.[].name'
    """
    from fpnav.systems.registry import SYSTEMS

    facts = [_facts(name) for name in SYSTEMS]
    if as_json:
        click.echo(json.dumps(facts, sort_keys=True))
        return
    click.echo("\n\n".join(_text(entry) for entry in facts))


def _facts(name: str) -> dict[str, Any]:
    from fpnav.params import as_dict
    from fpnav.systems.registry import system_class

    system = system_class(name)
    return {
        "name": name,
        "summary": system.SUMMARY,
        "needs": [list(group) for group in system.NEEDS.must],
        "uses": list(system.NEEDS.uses),
        "presets": {preset: as_dict(block) for preset, block in system.PRESETS.items()},
    }


def _text(entry: dict[str, Any]) -> str:
    needs = " and ".join(" or ".join(group) for group in entry["needs"])
    presets = entry["presets"]
    default = presets["default"]
    lines = [
        f"{entry['name']}: {entry['summary']}",
        f"  needs   {needs}",
        f"  uses    {', '.join(entry['uses'])}",
        f"  presets {', '.join(presets)}",
        f"  parameters (--set {entry['name']}.NAME=VALUE), default preset; others in brackets",
    ]
    for key, value in default.items():
        others = [f"{name}: {block[key]}" for name, block in presets.items() if block[key] != value]
        lines.append(f"    {key} = {value}" + (f"  ({', '.join(others)})" if others else ""))
    return "\n".join(lines)
