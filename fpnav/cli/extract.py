"""``fpnav extract``: frames of logs -> signatures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, choice_of, log_options_of, plural


@click.command("extract")
@click.argument("logs", nargs=-1, required=True, type=options.FILE)
@options.output
@options.system_options
@options.log_options
@options.run_options
@options.resume
def command(logs: tuple[Path, ...], resume: bool, **given: Any) -> None:
    """Turn the frames of LOGS into signatures; each log is a session.

    \b
    Example: fpnav extract drive.mcap -s fingerprint -o drive.sig.h5
    """
    from fpnav.execution.checkpoint import Checkpoints
    from fpnav.execution.spread import make_spread
    from fpnav.execution.walk import extract, make_system
    from fpnav.store.signatures import write_signatures

    session = Session.begin(logs, **given)
    system, preset = make_system(choice_of(given))
    checkpoints = Checkpoints(session.output, resume=resume)
    with progress("extract", None) as advance:
        spread = make_spread(given["jobs"], given["scheduler"])
        run = extract(logs, system, preset, log_options_of(given), spread, advance, checkpoints)
    write_signatures(session.output, run.header, run.table, clobber=not session.no_clobber)
    checkpoints.clear()
    count = plural(len(run.table), f"{system.NAME} signature")
    session.end(f"{count} from {plural(len(logs), 'log')}", {"signatures": len(run.table)})
