"""What a log is and holds, as JSON-ready facts for ``fpnav info``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fpnav.logs import roles, timing
from fpnav.logs.frames import Log
from fpnav.logs.topics import Topic
from fpnav.logs.views import views


def describe_logs(path: Path, topics: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    """Facts of a recording, of each of its files; damage is reported, not raised.

    Raises
    ------
    LogError
        No recording at all.
    """
    with views(path) as found:
        for view in found:
            with view.open(topics) as log:
                yield {
                    "kind": "log",
                    **_file(log),
                    **(_written(log) if not view.format else {"format": view.format}),
                    **_contents(log),
                    "ledger": log.ledger.as_dict(),
                }


def _written(log: Log) -> dict[str, Any]:
    """How the file was written."""
    file = log.file.contents
    return {
        "format": file.kind,
        "profile": file.profile,
        "library": file.library,
        "blocks": len(file.blocks),
        "compression": dict(sorted(file.compressions.items())),
    }


def _file(log: Log) -> dict[str, Any]:
    file = log.file.contents
    return {
        "name": log.name,
        "bytes": log.size,
        "sha256": log.sha256,
        "integrity": log.integrity,
        "damage": file.facts.damage,
        "attachments": [
            {"name": facts.name, "media_type": facts.media_type, "bytes": facts.size}
            for facts in file.attachments
        ],
        "metadata": sorted(log.metadata),
    }


def _contents(log: Log) -> dict[str, Any]:
    played = roles.places({role: facts.topics for role, facts in log.roles.items()})
    listed = [_topic(topic, played.get(name)) for name, topic in sorted(log.topics.items())]
    firsts = [topic["first_ns"] for topic in listed if topic["first_ns"] is not None]
    lasts = [topic["last_ns"] for topic in listed if topic["last_ns"] is not None]
    return {
        "start_ns": min(firsts, default=None),
        "duration_s": (max(lasts) - min(firsts)) / 1e9 if firsts else 0.0,
        "topics": listed,
        "roles": {role: list(facts.topics) for role, facts in log.roles.items()},
        "choices": _choices(log),
        "hints": _hints(log),
        "primary": log.primary,
        "travelled_from": log.travelled_from,
        "travelled_m": _travelled(log),
        "calibrated": sorted(log.calibrations),
    }


def _topic(topic: Topic, played: tuple[str, int] | None) -> dict[str, Any]:
    stamps = topic.rows["log_ns"][timing.by_log_time(topic.rows)]
    period = timing.median_period(stamps)
    pauses, longest = timing.gaps(stamps)
    return {
        "topic": topic.name,
        "type": topic.type_name,
        "encoding": topic.encoding,
        "messages": topic.count.in_file,
        "lost": topic.count.lost,
        "hz": None if math.isnan(period) else round(1e9 / period, 3),
        "gaps": pauses,
        "longest_gap_s": round(longest, 3),
        "first_ns": topic.count.first_ns,
        "last_ns": topic.count.last_ns,
        "role": played[0] if played else "",
        "problem": topic.problem,
    }


def _choices(log: Log) -> dict[str, list[str]]:
    """Roles that more than one topic could play, with all candidates, the chosen one first."""
    found: dict[str, list[str]] = {}
    for role in roles.RULES:
        names = roles.candidates(log.topics, role)
        if role != "sonar" and role in log.roles and len(names) > 1:
            chosen = log.roles[role].topics[0]
            found[role] = sorted(names, key=lambda name: name != chosen)
    return found


def _hints(log: Log) -> dict[str, list[str]]:
    """Topics that may play a role nothing plays, where only the user can say so."""
    absent = [role for role in ("odometry", "truth") if role not in log.roles]
    absent += [] if log.primary else list(roles.SENSORS)
    taken = set(roles.places({role: facts.topics for role, facts in log.roles.items()}))
    could = {role: roles.by_type(log.topics, role) for role in absent}
    free = {role: [n for n in names if n not in taken] for role, names in could.items()}
    return {role: names for role, names in free.items() if names}


def _travelled(log: Log) -> float | None:
    """Path length over the frames, None where there is no pose."""
    if not log.primary or not log.travelled_from:
        return None
    return round(log.references()[-1].travelled_m, 3)
