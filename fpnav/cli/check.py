"""``fpnav check``: every assumption a stage makes of a log."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.plain import table, visible

_WORDS = {"ok": "ok", "note": "note", "warn": "WARN", "fail": "FAIL", "loss": "LOSS"}


@click.command("check")
@click.argument("files", nargs=-1, required=True, type=options.FILE)
@options.topics
@options.max_loss
@options.allow_truncated
@options.as_json
def command(
    files: tuple[Path, ...],
    topics: dict[str, str],
    max_loss: float,
    allow_truncated: bool,
    as_json: bool,
) -> int:
    """Test every assumption a stage makes of the logs FILES; nothing is changed.

    Exit codes: 0 a walk can go on, 1 a stage cannot run, 3 more data is lost than allowed.

    \b
    fpnav check drive.mcap
    fpnav check drive.mcap --json
    """
    from fpnav.logs.checks.registry import check_log
    from fpnav.logs.ledger import Budget
    from fpnav.logs.views import views

    budget = Budget(max_loss, allow_truncated=allow_truncated)
    levels: set[str] = set()
    for path in files:
        with views(path) as found:
            for view in found:
                with view.open(topics) as log:
                    findings = check_log(log, budget)
                levels |= {finding.level for finding in findings}
                for line in _lines(path, view.name, findings, as_json):
                    click.echo(line)
    return 3 if "loss" in levels else int("fail" in levels)


def _lines(path: Path, name: str, findings: list[Any], as_json: bool) -> list[str]:
    if as_json:
        facts = {"name": name, "findings": [asdict(finding) for finding in findings]}
        return [json.dumps(facts, sort_keys=True, allow_nan=False)]
    rows = [(_WORDS[f.level], f.check, f.code, _sentence(f)) for f in findings]
    shown = path if path.name == name else path / name
    return [f"{shown}:", *(f"  {line}" for line in table(rows))]


def _sentence(finding: Any) -> str:
    fix = f"; {visible(finding.fix)}" if finding.fix else ""
    return visible(finding.message) + fix
