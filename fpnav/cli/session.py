"""What several commands do around their one library call: choose, time, say."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from fpnav.cli.progress import set_quiet


@dataclass(frozen=True)
class Session:
    """One command's run: its output, how it talks, and when it began."""

    output: Path
    no_clobber: bool
    as_json: bool
    quiet: bool
    stats_json: Path | None
    started_s: float = field(default_factory=time.perf_counter)

    @staticmethod
    def begin(inputs: Sequence[Path], **options: Any) -> Session:
        """Start: silence where asked, and refuse an impossible output before any work."""
        from fpnav.publish import check_output

        session = Session(
            **{
                key: options[key]
                for key in ("output", "no_clobber", "as_json", "quiet", "stats_json")
            }
        )
        set_quiet(session.quiet)
        check_output(session.output, inputs=inputs, clobber=not session.no_clobber)
        return session

    def end(self, sentence: str, facts: Mapping[str, Any]) -> None:
        """Say what was made: one line on stderr, or one JSON line on stdout."""
        if self.stats_json is not None:
            self._write_stats()
        if self.as_json:
            click.echo(json.dumps({"output": self.output.name, **facts}, sort_keys=True))
        elif not self.quiet:
            click.echo(f"{self.output}: {sentence}", err=True)

    def _write_stats(self) -> None:
        import resource

        from fpnav.publish import publish_bytes

        own = resource.getrusage(resource.RUSAGE_SELF)
        workers = resource.getrusage(resource.RUSAGE_CHILDREN)
        stats = {
            "command": sys.argv[1] if len(sys.argv) > 1 else "",
            "wall_s": round(time.perf_counter() - self.started_s, 3),
            "cpu_s": round(own.ru_utime + own.ru_stime + workers.ru_utime + workers.ru_stime, 3),
            "peak_memory_mb": round(max(own.ru_maxrss, workers.ru_maxrss) / 1024, 1),
        }
        if self.stats_json is not None:
            publish_bytes(self.stats_json, json.dumps(stats, sort_keys=True).encode() + b"\n")


def choice_of(options: Mapping[str, Any]) -> Any:
    """The system, preset and parameters asked for."""
    from fpnav.execution.walk import SystemChoice
    from fpnav.params import read_tables
    from fpnav.systems.registry import SYSTEMS

    known = [*SYSTEMS, "filter", "loops"]
    settings = options.get("settings", ())
    tables = read_tables(options.get("params_file"), settings, known)
    flags = frozenset(setting.partition(".")[0].strip() for setting in settings)
    return SystemChoice(options.get("system"), options.get("preset"), tables, flags)


def log_options_of(options: Mapping[str, Any]) -> Any:
    """How logs are to be read."""
    from fpnav.execution.walk import LogOptions

    return LogOptions(
        topics=options["topics"],
        step_m=options["step_m"],
        step_deg=options["step_deg"],
        max_loss=options["max_loss"],
        allow_truncated=options["allow_truncated"],
        start_s=options["start_s"],
        end_s=options["end_s"],
    )


def plural(count: int, noun: str) -> str:
    """``1 place``, ``2 places``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
