"""``fpnav info``: what a file is and holds."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.plain import size, table, visible
from fpnav.cli.session import plural
from fpnav.cli.stored import stored_lines


@click.command("info")
@click.argument("files", nargs=-1, required=True, type=options.FILE)
@options.topics
@options.as_json
def command(files: tuple[Path, ...], topics: dict[str, str], as_json: bool) -> None:
    """Say what each of FILES is and holds: a log, signatures, a map or a result.

    \b
    fpnav info drive.mcap
    fpnav info map.h5 --json
    """
    for number, facts in enumerate(facts for path in files for facts in _facts(path, topics)):
        if as_json:
            click.echo(json.dumps(facts, sort_keys=True, allow_nan=False))
            continue
        if number:
            click.echo()
        for line in log_lines(facts) if facts["kind"] == "log" else stored_lines(facts):
            click.echo(line)


def _facts(path: Path, topics: dict[str, str]) -> Iterator[dict[str, Any]]:
    """Facts of a stored file, or of the logs of a recording with the systems that can run."""
    from fpnav.execution.walk import is_store
    from fpnav.logs.describe import describe_logs
    from fpnav.store.describe import describe_store

    if not path.is_dir() and is_store(path):
        yield describe_store(path)
        return
    for facts in describe_logs(path, topics):
        yield {**facts, "systems": systems_of(facts["roles"])}


def systems_of(roles: dict[str, Any]) -> dict[str, list[list[str]]]:
    """Groups of roles every system lacks; none = it can run."""
    from fpnav.systems.registry import SYSTEMS, system_class

    return {
        name: [list(group) for group in system_class(name).NEEDS.missing(roles)] for name in SYSTEMS
    }


def log_lines(facts: dict[str, Any]) -> list[str]:
    """The facts of a log as a screen of text."""
    lines = [
        f"{visible(facts['name'])}: {facts['format']}, {size(facts['bytes'])}, "
        f"{facts['duration_s']:.1f} s, {facts['integrity']}",
    ]
    if "library" in facts:
        lines.append(
            f"written by {visible(facts['library']) or 'unknown'}, profile "
            f"{visible(facts['profile']) or 'none'}, {_compression(facts)}"
        )
    if facts["damage"]:
        lines.append(f"damage: {visible(facts['damage'])}")
    lines += ["", *_topic_table(facts), "", *_walk(facts), *_systems(facts["systems"])]
    lines += [f"attachment {visible(a['name'])}, {size(a['bytes'])}" for a in facts["attachments"]]
    notes = facts["ledger"]["remarks"]
    return lines + [f"note {code}: {visible(text)}" for code, text in notes.items()]


def _compression(facts: dict[str, Any]) -> str:
    kinds = [f"{plural(count, 'chunk')} {name}" for name, count in facts["compression"].items()]
    return ", ".join(kinds) or "no chunks"


def _topic_table(facts: dict[str, Any]) -> list[str]:
    rows: list[tuple[str, ...]] = [("role", "topic", "type", "messages", "Hz", "gaps", "")]
    rows += [_topic_row(topic) for topic in _rings_as_one(facts["topics"])]
    return table(rows)


def _rings_as_one(topics: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The transducers of a ring in one row: first topic to last, messages of all."""
    ring = [topic for topic in topics if topic["role"] == "sonar"]
    if len(ring) < 2:
        return topics
    name = f"{ring[0]['topic']} and {len(ring) - 1} more"
    counts = {key: sum(topic[key] for topic in ring) for key in ("messages", "lost")}
    others = [topic for topic in topics if topic["role"] != "sonar"]
    return [*others, {**ring[0], **counts, "topic": name}]


def _topic_row(topic: dict[str, Any]) -> tuple[str, ...]:
    lost = f" ({topic['lost']} lost)" if topic["lost"] else ""
    pauses = f"{topic['gaps']}, longest {topic['longest_gap_s']:.1f} s" if topic["gaps"] else ""
    return (
        topic["role"] or "-",
        visible(topic["topic"]),
        visible(topic["type"]),
        f"{topic['messages']}{lost}",
        "" if topic["hz"] is None else f"{topic['hz']:.4g}",
        pauses,
        visible(topic["problem"]),
    )


def _walk(facts: dict[str, Any]) -> list[str]:
    lines = []
    if facts["primary"]:
        lines.append(f"frames stand at the stamps of {facts['primary']}")
    if facts["travelled_m"] is not None:
        lines.append(f"path {facts['travelled_m']:.1f} m by {facts['travelled_from']}")
    for role, names in facts["choices"].items():
        lines.append(f"{role} is {visible(names[0])}; others:")
        lines += [f"  --topic {role}={visible(name)}" for name in names[1:]]
    for role, names in facts["hints"].items():
        lines.append(f"no {role}; if one of these is:")
        lines += [f"  --topic {role}={visible(name)}" for name in names]
    return lines


def _systems(systems: dict[str, list[list[str]]]) -> list[str]:
    lines = []
    for name, missing in systems.items():
        lacks = "; ".join(" or ".join(group) for group in missing)
        lines.append(f"{name}: lacks {lacks}" if missing else f"{name}: can run")
    return lines
