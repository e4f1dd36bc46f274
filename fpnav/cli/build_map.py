"""``fpnav build-map``: signatures -> topological map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnav.cli import options
from fpnav.cli.progress import progress
from fpnav.cli.session import Session, choice_of, log_options_of, plural


@click.command("build-map")
@click.argument("inputs", nargs=-1, required=True, type=options.FILE, metavar="LOG_OR_SIGS...")
@options.output
@options.system_options
@options.log_options
@options.run_options
@options.resume
@click.option(
    "--labels", type=click.Choice(["off", "guided"]), default="off", show_default=True,
    help="guided: the label topic decides the place.",
)  # fmt: skip
@click.option("--no-loops", is_flag=True, help="Leave loops open: every place is new.")
def command(
    inputs: tuple[Path, ...], labels: str, no_loops: bool, resume: bool, **given: Any
) -> None:
    """Build a topological map from logs or signature files; several are sessions of one map.

    \b
    Example: fpnav build-map drive.sig.h5 -o map.h5 --set fingerprint.theta=auto
    """
    from fpnav.execution.checkpoint import Checkpoints
    from fpnav.execution.spread import make_spread
    from fpnav.execution.stages import make_map
    from fpnav.execution.walk import signatures_of
    from fpnav.store.maps import write_map

    session = Session.begin(inputs, **given)
    choice = choice_of(given)
    checkpoints = Checkpoints(session.output, resume=resume)
    spread = make_spread(given["jobs"], given["scheduler"])
    with progress("extract", None) as advance:
        run = signatures_of(inputs, choice, log_options_of(given), spread, advance, checkpoints)
    with progress("build map", len(run.table)) as advance:
        header, built = make_map(
            run,
            inputs,
            guided=labels == "guided",
            close_loops=not no_loops,
            tables=choice.tables,
            advance=advance,
        )
    write_map(session.output, header, built, clobber=not session.no_clobber)
    checkpoints.clear()
    places, edges = len(built.topomap), len(built.topomap.edges)
    session.end(
        f"{plural(places, 'place')}, {plural(edges, 'edge')} "
        f"from {plural(len(run.table), 'signature')}",
        {"places": places, "edges": edges, "signatures": len(run.table)},
    )
