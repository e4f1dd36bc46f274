"""``fpnav localize``: where on a map each signature of a run was made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import msgspec

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, choice_of, log_options_of


@click.command("localize")
@click.argument("map_file", type=options.FILE, metavar="MAP.h5")
@click.argument("query", type=options.FILE, metavar="LOG_OR_SIGS")
@options.output
@options.method
@options.truth
@options.system_options
@options.log_options
@options.run_options
@options.resume
def command(
    map_file: Path, query: Path, method: str, truth_file: Path | None, resume: bool, **given: Any
) -> None:
    """Locate each signature of LOG_OR_SIGS on MAP.h5, with the system and parameters of the map.

    \b
    Example: fpnav localize map.h5 again.mcap --method filter -o result.h5
    """
    from fpnav.execution.checkpoint import Checkpoints
    from fpnav.execution.spread import make_spread
    from fpnav.execution.stages import locate_run
    from fpnav.execution.walk import SystemChoice, signatures_of, system_of
    from fpnav.localization.locate import Method
    from fpnav.store.header import MAP, check_header
    from fpnav.store.maps import read_map
    from fpnav.store.results import read_header, write_result

    session = Session.begin((map_file, query), **given)
    choice = choice_of(given)
    map_header = read_header(map_file)
    check_header(map_file, map_header, MAP)
    system, preset = system_of(map_header, choice)
    built = read_map(map_file, system.RECORD, system.PARTS)
    as_mapped = SystemChoice(system.NAME, preset, {system.NAME: msgspec.to_builtins(system.params)})
    checkpoints = Checkpoints(session.output, resume=resume)
    with progress("extract", None) as advance:
        spread = make_spread(given["jobs"], given["scheduler"])
        run = signatures_of([query], as_mapped, log_options_of(given), spread, advance, checkpoints)
    with progress("localize", len(run.table)) as advance:
        result = locate_run(
            system,
            map_header,
            built,
            run,
            method=Method(method),
            tables=choice.tables,
            truth_file=truth_file,
            advance=advance,
        )
    write_result(session.output, result, clobber=not session.no_clobber)
    checkpoints.clear()
    found = int((result.decision >= 0).sum())
    session.end(
        f"{found} of {len(result.queries)} queries localized by {method}",
        {"queries": len(result.queries), "localized": found, "method": method},
    )
